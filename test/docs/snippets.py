"""The fenced blocks of the documents, and what the comment before each says about running it.

    <!-- test: GROUP -->                 shell: part of the group's script
    <!-- test: GROUP, python -->         python: part of one session, run at the end
    <!-- test: GROUP, exit 1 -->         shell: every command of the block has to end with 1
    <!-- test: GROUP, background -->     shell: runs beside what follows, until the group ends
    <!-- test: GROUP, page -->           shell: serves a page, which is fetched, and is ended
    <!-- test: GROUP, interrupted -->    shell: every command goes on well until Ctrl-C
    <!-- test: GROUP, file NAME -->      is written to a file
    <!-- test: none, REASON -->          is not run
"""

import re
import shlex
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]
#: Blocks that a reader could type; drawings and output carry no language.
RUNNABLE = ('sh', 'bash', 'python', 'xml', 'yaml')

_BLOCK = re.compile(r'(?:<!-- test: (?P<said>[^>]*?) -->\s*\n)?^```(?P<language>\w*)[^\n]*\n'
                    r'(?P<text>.*?)^```', re.MULTILINE | re.DOTALL)


#: Fetches the page whose address a program prints, and ends the program.
_FETCH = """rm -f page.txt
{{ exec > page.txt
exec {command}
}} &
started+=($!)
for _ in $(seq 600); do
  address=$(grep -som1 'http://[0-9.:]*' page.txt || true)
  [ -z "$address" ] || break
  sleep 0.1
done
python -c "from urllib.request import urlopen; assert b'<html' in urlopen('$address').read()"
kill $!
wait $! || test $? -gt 128"""

#: What a program that Ctrl-C ended says; 0 is one that was quicker.
_INTERRUPTED = (0, 130)


class Snippet(NamedTuple):
    """One fenced block."""

    page: Path
    line: int
    language: str
    text: str
    group: str
    how: str


def snippets() -> list[Snippet]:
    """Return every runnable block of every page, in order."""
    found = []
    for page in PAGES:
        whole = page.read_text(encoding='utf-8')
        for block in _BLOCK.finditer(whole):
            if block['language'] in RUNNABLE:
                group, _, how = (block['said'] or '').partition(', ')
                line = whole[:block.start('text')].count('\n') + 1
                found.append(Snippet(page, line, block['language'], block['text'], group, how))
    return found


def groups() -> dict[str, list[Snippet]]:
    """Return the blocks that are run, by group."""
    found: dict[str, list[Snippet]] = {}
    for snippet in snippets():
        if snippet.group not in ('', 'none'):
            found.setdefault(snippet.group, []).append(snippet)
    return found


def script(group: list[Snippet], folder: Path) -> str:
    """Write the files of a group and return the bash script that runs the rest of it."""
    lines = ['set -euo pipefail', 'started=()',
             'trap \'kill "${started[@]}" 2>/dev/null || true; wait\' EXIT',
             # what make would do first is done: this environment exists
             f'make() {{ command make -C {shlex.quote(str(ROOT))} -n "$@"; }}']
    page = []
    for snippet in group:
        if snippet.how.startswith('file '):
            (folder / snippet.how.removeprefix('file ')).write_text(snippet.text, encoding='utf-8')
        elif snippet.language == 'python':
            page.append(snippet.text)
        elif snippet.how == 'background':
            lines += [f'{{ exec {snippet.text.strip()}; }} &', 'started+=($!)']
        elif snippet.how == 'page':
            lines += [_FETCH.format(command=each) for each in _commands(snippet.text)]
        elif snippet.how == 'interrupted':
            for command in _commands(snippet.text):
                lines.append(_ends(f'timeout --preserve-status -s INT 4 {command}', _INTERRUPTED))
        elif snippet.how.startswith('exit '):
            expected = int(snippet.how.removeprefix('exit '))
            lines += [_ends(command, (expected,)) for command in _commands(snippet.text)]
        else:
            lines.append(snippet.text)
    if page:
        (folder / 'page.py').write_text('\n'.join(page), encoding='utf-8')
        lines.append('python page.py')
    return '\n'.join(lines) + '\n'


def _ends(command: str, codes: tuple[int, ...]) -> str:
    """Return bash that runs a command, which has to end with one of some exit codes."""
    return (f'{{ set +e; {command}; code=$?; set -e; }}\n'
            f'[[ " {" ".join(map(str, codes))} " == *" $code "* ]] '
            '|| { echo "exit $code"; exit 9; }')


def _commands(text: str) -> list[str]:
    """Return the commands of a block, continued lines joined."""
    return [line for line in text.replace('\\\n', ' ').splitlines() if line.strip()]
