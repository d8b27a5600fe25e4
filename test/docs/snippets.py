"""The fenced blocks of the documents, and what the comment before each says about running it.

    <!-- test: GROUP -->                 shell: part of the group's script
    <!-- test: GROUP, python -->         python: part of one session, run at the end
    <!-- test: GROUP, exit 1 -->         shell: every command of the block has to end with 1
    <!-- test: GROUP, background -->     shell: runs beside what follows, until the group ends
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
             'trap \'for pid in "${started[@]}"; do kill "$pid" 2>/dev/null || true; done\' EXIT',
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
        elif snippet.how.startswith('exit '):
            wanted = snippet.how.removeprefix('exit ')
            for command in _commands(snippet.text):
                lines.append(f'{{ set +e; {command}; code=$?; set -e; }}\n'
                             f'test "$code" = {wanted} || {{ echo "exit $code"; exit 9; }}')
        else:
            lines.append(snippet.text)
    if page:
        (folder / 'page.py').write_text('\n'.join(page), encoding='utf-8')
        lines.append('python page.py')
    return '\n'.join(lines) + '\n'


def _commands(text: str) -> list[str]:
    """Return the commands of a block, continued lines joined."""
    return [line for line in text.replace('\\\n', ' ').splitlines() if line.strip()]
