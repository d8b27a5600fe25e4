"""The command ``ur5 validate --all``: every run below a folder, one line each."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rich.text import Text

from ur5_ros.analysis.result import FAIL, PASS
from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import BAD_INPUT, FAILED, SUCCESS
from ur5_ros.cli.json_file import write_json
from ur5_ros.errors import InputError
from ur5_ros.sweep.batch_validation import NOT_JUDGED, UNREADABLE, Judgement, judge_all
from ur5_ros.wording import number_of


def runs_below(folder: Path) -> list[Path]:
    """
    Return the run folders at or below ``folder``, in order of their names.

    A run is a folder with a bag in it, or with a folder ``sim`` or ``control`` with one; without
    metadata.yaml, files that are not numbered in a row are recordings of their own.

    """
    files: dict[Path, list[Path]] = {}
    for pattern in ('[!.]*.mcap', '[!.]*.db3'):
        for path in folder.rglob(pattern):
            files.setdefault(path.parent, []).append(path)
    runs: set[Path] = set()
    for bag, found in files.items():
        if bag.name in ('sim', 'control'):
            runs.add(bag.parent)
        elif len(found) == 1 or (bag / 'metadata.yaml').is_file() or _are_numbered(found):
            runs.add(bag)
        else:
            runs.update(found)
    return sorted(runs)


def _are_numbered(files: list[Path]) -> bool:
    """Return whether files are the parts of one bag: ``name_0``, ``name_1``, ..."""
    stems = {file.stem.rpartition('_')[0] for file in files}
    return len(stems) == 1 and all(file.stem.rpartition('_')[2].isdecimal() for file in files)


def validate_all(
    folder: Path, given: Mapping[str, Any], marks: str, json: Path | None, html: Path | None,
    junit: Path | None,
) -> int:
    """Judge every run below a folder; exit 0 if all pass, 2 if none can be read."""
    if html is not None:
        raise InputError('--html with --all: a report shows one run; give --json or --junit, or '
                         'validate one run')
    if not folder.is_dir():
        raise InputError(f'no folder {folder}; give a folder with runs in it')
    runs = runs_below(folder)
    if not runs:
        raise InputError(f'no bag below {folder}; give a folder with runs in it')
    judgements = []
    with terminal.progress('judging', len(runs), 'runs') as advance:
        for judgement in judge_all(runs, dict(given), marks):
            judgements.append(judgement)
            advance(len(judgements))
    judgements.sort(key=lambda judgement: judgement.folder)
    _show(judgements)
    write_json({'format': 'ur5_ros validation of a folder', 'version': 1, 'folder': str(folder),
                'runs': [{**judgement._asdict()} for judgement in judgements]}, json)
    if junit is not None:
        _write_junit(judgements, junit)
    verdicts = {judgement.verdict for judgement in judgements}
    if verdicts <= {UNREADABLE, NOT_JUDGED}:
        return BAD_INPUT
    return SUCCESS if verdicts == {PASS} else FAILED


def _show(judgements: list[Judgement]) -> None:
    out = terminal.console()
    for judgement in judgements:
        good = judgement.verdict == PASS
        out.print(Text.assemble(f'{judgement.folder}: ',
                                (judgement.verdict, 'green' if good else 'bold red'),
                                '' if good else f'  {_first(judgement.why)}'),
                  soft_wrap=not out.is_terminal)
    passed = sum(judgement.verdict == PASS for judgement in judgements)
    out.print(f'{passed} of {number_of(len(judgements), "run")} passed')


def _first(why: str) -> str:
    sentences = why.split('; ')
    return sentences[0] + (f'; {len(sentences) - 1} more' if len(sentences) > 1 else '')


def _write_junit(judgements: list[Judgement], path: Path) -> None:
    verdicts = [judgement.verdict for judgement in judgements]
    suite = ElementTree.Element('testsuite', {
        'name': 'ur5 validate --all', 'tests': str(len(verdicts)),
        'failures': str(verdicts.count(FAIL)),
        'errors': str(verdicts.count(UNREADABLE) + verdicts.count(NOT_JUDGED))})
    for judgement in judgements:
        case = ElementTree.SubElement(
            suite, 'testcase', {'classname': 'ur5.runs', 'name': judgement.folder})
        if judgement.verdict != PASS:
            kind = 'failure' if judgement.verdict == FAIL else 'error'
            ElementTree.SubElement(case, kind, {'message': judgement.why})
    text = ElementTree.tostring(suite, encoding='unicode', xml_declaration=True)
    path.write_text(text + '\n', encoding='utf-8')
