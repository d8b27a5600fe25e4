"""The command ``ur5 sweep``: many runs, their table, their page."""

from pathlib import Path

from rich.text import Text

from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import FAILED, SUCCESS
from ur5_ros.errors import InputError
from ur5_ros.sweep.engine import run_sweep
from ur5_ros.sweep.report import repeat_command, write_report
from ur5_ros.sweep.run import check_success, config_of, row_of
from ur5_ros.sweep.spec import (
    SweepSpec,
    altered,
    expand,
    has_drawn_keys,
    load_sweep,
    number_of_runs,
)
from ur5_ros.sweep.summary import worst_runs
from ur5_ros.sweep.table import SweepFolder, open_sweep
from ur5_ros.wording import number_of

#: Where sweeps are written by default.
SWEEPS = Path('sweeps')


def sweep(name: str, out: Path | None, scheduler: str | None, workers: int | None,
          only: int | None) -> int:
    """Run a sweep, or go on with it; see ``ur5 sweep --help``."""
    spec = load_sweep(name)
    if only is not None:
        return _one(spec, only, out)
    _refuse_what_cannot_run(spec)
    folder = SweepFolder(out if out is not None else SWEEPS / spec.name, spec)
    total = number_of_runs(spec)
    screen = terminal.console()
    try:
        with terminal.progress(spec.name, total, 'runs') as advance:
            run_sweep(spec, folder, scheduler, workers, advance)
    except KeyboardInterrupt:
        terminal.show_text(screen, f'{len(folder.done())} of {number_of(total, "run")} done; '
                           'the same command continues')
        raise
    screen.print(f'table: {folder.write_table()}', soft_wrap=True)
    return _report(folder, screen)


def report(folder: Path | None) -> int:
    """Draw the page of a sweep that is done, or as far as it is."""
    if folder is None:
        raise InputError('report of which sweep? give the folder that ur5 sweep wrote')
    return _report(open_sweep(folder), terminal.console())


def _report(folder: SweepFolder, screen: terminal.Console) -> int:
    path = folder.path / 'report.html'
    rate = write_report(folder, path)
    interval = (f' (95 % interval {rate.low:.1%} to {rate.high:.1%})'
                if has_drawn_keys(folder.spec) else '')
    terminal.show_text(screen, f'{rate.successes} of {number_of(rate.runs, "run")} succeeded: '
                       f'{rate.rate:.1%}{interval}')
    worst = worst_runs(folder.table(), 3, folder.spec.success)
    failures = [row for row in worst if not row['success']]
    for row in failures:
        terminal.show_text(
            screen, f'run {row["index"]}: {row["status"]}: {row.get("why") or ""}')
    screen.print(Text(f'report: {path}'), soft_wrap=True)
    if failures:
        terminal.show_next(screen, repeat_command(folder.path, failures[0]['index']),
                           'the worst run again, with its bags')
    return SUCCESS


def _refuse_what_cannot_run(spec: SweepSpec) -> None:
    """Plan every run before the first one runs."""
    check_success(spec)
    with terminal.progress('checking', number_of_runs(spec), 'runs') as advance:
        for run in expand(spec):
            config_of(spec, run)
            if run.number % 100 == 0:
                advance(run.number)


def _one(spec: SweepSpec, index: int, out: Path | None) -> int:
    """Repeat one run of a sweep and keep its bags."""
    run = next((run for run in expand(spec) if run.number == index), None)
    if run is None:
        raise InputError(f'--only {index}: {spec.name} has the runs 0 to '
                         f'{number_of_runs(spec) - 1}')
    bags = out if out is not None else SWEEPS / spec.name / 'repeated'
    folder = bags / f'{index:06d}'
    if folder.exists():
        raise InputError(f'{folder} exists; give another folder with --out, or remove it')
    row = row_of(altered(spec, keep='all'), run, bags)
    screen = terminal.console()
    for key, value in row.items():
        shown = f'{value:.4g}' if isinstance(value, float) else value
        screen.print(Text(f'{key}: {shown}'), soft_wrap=True)
    screen.print(Text(f'bags: {folder}'), soft_wrap=True)
    return SUCCESS if row['success'] else FAILED
