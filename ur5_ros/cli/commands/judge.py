"""Commands that judge bags: validate and compare."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ur5_ros.analysis.comparison import Difference
from ur5_ros.analysis.comparison import compare as compare_runs
from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.report.html import write_html
from ur5_ros.analysis.result import Result
from ur5_ros.analysis.validate import validate as validate_run
from ur5_ros.bag.run_folders import newest_run
from ur5_ros.cli import terminal
from ur5_ros.cli.commands import batch
from ur5_ros.cli.exit_codes import FAILED, SUCCESS
from ur5_ros.cli.json_file import write_json
from ur5_ros.errors import InputError
from ur5_ros.sweep.batch_validation import marks_of
from ur5_ros.wording import number_of


def validate(
    run: Path | None, folder: Path | None, given: Mapping[str, Any], marks: Path | None,
    json: Path | None, html: Path | None, junit: Path | None,
) -> int:
    """Judge one run or a folder of runs; see ``ur5 validate --help``."""
    limits = str(marks) if marks is not None else ''
    marks_of(limits)  # refused before anything is read
    if folder is not None:
        if run is not None:
            raise InputError(f'{run} and --all {folder}: give one of the two')
        return batch.validate_all(folder, {**given, 'keep_arm': True}, limits, json, html, junit)
    with terminal.progress('judging', 3, 'steps') as advance:
        read = load_run(run if run is not None else newest_run(), **given)
        advance(1)
        result = validate_run(read, marks_of(limits))
        advance(2)
        write(result, json, html, junit)
    out = terminal.console()
    terminal.show_result(out, result)
    for path in (json, html, junit):
        if path is not None:
            out.print(f'written: {path}', soft_wrap=True)
    _show_next(out, result, html, given)
    return SUCCESS if result.passed else FAILED


def _show_next(out: terminal.Console, result: Result, html: Path | None,
               given: Mapping[str, Any]) -> None:
    def again(*names: str) -> str:
        """Return the folder and those of the options that were given."""
        return ' '.join([result.about['folder'], *(
            f'--{name.replace("_", "-")} {shlex.quote(given[name])}' for name in names
            if given.get(name))])
    folder = again('arm', 'control_arm', 'joint_prefix', 'effort', 'reference')
    if not result.controller_judged:
        terminal.show_next(out, f'ur5 validate {folder} --reference JOINTS',
                           'or a topic, an experiment, a pose: judges the controller')
    elif html is None:
        terminal.show_next(out, f'ur5 validate {folder} --html report.html', 'figures')
    else:
        terminal.show_next(out, f'ur5 view {again("arm", "joint_prefix")}',
                           'the arm in the browser')


def judge(run: Path) -> Result:
    """Return the result of a run folder."""
    return validate_run(load_run(run), marks_of())


def write(result: Result, json: Path | None, html: Path | None, junit: Path | None) -> None:
    """Write a result to those of the files that are asked for; folders are made."""
    for path in (json, html, junit):
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
    if json is not None:
        json.write_text(result.to_json(), encoding='utf-8')
    if html is not None:
        write_html(result, html)
    if junit is not None:
        junit.write_text(result.to_junit(), encoding='utf-8')


def compare(run_a: Path, run_b: Path, json: Path | None, given: Mapping[str, Any]) -> int:
    """Compare two runs; see ``ur5 compare --help``."""
    a, b = (load_run(run, **given) for run in (run_a, run_b))
    found = compare_runs(a, b)
    marks = marks_of()
    verdicts = [validate_run(run, marks).verdict for run in (a, b)]
    out = terminal.console()
    for difference in found.differences:
        terminal.show_text(out, _in_words(difference))
    for count, run in ((found.only_a, a), (found.only_b, b)):
        if count:
            out.print(f'{number_of(count, "state")} only in {run.name}', soft_wrap=True)
    for run in (a, b):
        terminal.show_notes(out, run)
    for name, (left, right) in found.parameters.items():
        terminal.show_text(out, f'{name}: {left} and {right}')
    out.print(f'verdicts: {verdicts[0]} and {verdicts[1]}')
    if found.identical:
        out.print('the same run, to the last bit')
    elif found.same:
        out.print('the same run, within 1e-9, on another kind of machine')
    else:
        out.print('different runs')
    write_json({**found.to_plain(), 'verdicts': verdicts}, json)
    return SUCCESS if found.same else FAILED


def _in_words(difference: Difference) -> str:
    if not difference.different:
        rows = number_of(difference.compared, 'row')
        return f'{difference.quantity}: {rows} equal to the last bit'
    growth = ', '.join(f'{size:.2g} {when}' for when, size in difference.growth.items())
    return (f'{difference.quantity}: {difference.different} of {difference.compared} rows differ, '
            f'first at {difference.first_s:.9g} s ({difference.first_joint}), by at most '
            f'{difference.largest:.3g} {difference.unit}; {growth}')
