"""Names on the pages are those of the product: files, commands, options, parameters."""

import re
from pathlib import Path

import typer.main

from ur5_ros.cli.app import app
from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]
COMMANDS = typer.main.get_command(app).commands
PARAMETERS = {each.name for each in (*SIM_PARAMETERS, *CONTROL_PARAMETERS)}
GROUPS = {name.partition('.')[0] for name in PARAMETERS if '.' in name}


def launch_arguments() -> set[str]:
    """Return the arguments of every launch file."""
    files = [*(ROOT / 'launch').glob('*.py'), *(ROOT / 'ur5_ros/launcher').glob('*.py')]
    text = '\n'.join(path.read_text(encoding='utf-8') for path in files)
    return set(re.findall(r"^(?:    |.*\{)'(\w+)': Argument\(", text, re.MULTILINE))


def code(page: Path) -> list[str]:
    """Return the inline code of a page, and the lines of its shell blocks."""
    text = page.read_text(encoding='utf-8')
    shell = '\n'.join(re.findall(r'^```(?:sh|bash)$(.*?)^```', text, re.DOTALL | re.MULTILINE))
    prose = re.sub(r'^```.*?^```', '', text, flags=re.DOTALL | re.MULTILINE)
    return re.findall(r'`([^`\n]+)`', prose) + shell.replace('\\\n', ' ').splitlines()


def everywhere() -> list[tuple[str, str]]:
    """Return page and piece of code, of all pages."""
    return [(page.name, each) for page in PAGES for each in code(page)]


def test_a_file_that_a_page_names_is_there():
    missing = []
    for page, text in everywhere():
        for name in re.findall(r'(?<![\w/.-])(?:config|ur5_ros|benchmarks|docs|test|launch|model|'
                               r'nodes|bag|sim|analysis)/[\w/-]+\.\w+', text):
            if not any((ROOT / room / name).exists() for room in ('', 'ur5_ros', 'test')):
                missing.append(f'{page}: {name}')
    assert not missing


def test_a_command_that_a_page_names_has_these_options():
    wrong = []
    for page, text in everywhere():
        for name, rest in re.findall(r'(?<![\w/.-])ur5 ([a-z][a-z-]*)([^|;&#]*)', text):
            if name not in COMMANDS:
                wrong.append(f'{page}: ur5 {name}')
                continue
            known = {option for each in COMMANDS[name].params for option in each.opts}
            used = set(re.findall(r'(?<!\S)--?[a-z][a-z0-9-]*', rest)) - {'--help', '-h'}
            wrong += [f'{page}: ur5 {name} {option}' for option in used - known]
    assert not wrong


def test_a_parameter_that_a_page_sets_exists():
    known = PARAMETERS | launch_arguments() | {'use_sim_time', 'name'}
    wrong = [f'{page}: {name}' for page, text in everywhere()
             for name in re.findall(r'([a-z][\w.]*):=', text) if name not in known]
    assert not wrong


def test_a_parameter_of_a_group_that_a_page_names_exists():
    wrong = [f'{page}: {text}' for page, text in everywhere()
             if re.fullmatch(r'[a-z_]+\.[a-z_]+', text) and text.partition('.')[0] in GROUPS
             and text not in PARAMETERS]
    assert not wrong
