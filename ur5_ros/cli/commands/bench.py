"""The command ``ur5 bench``: laws side by side."""

from collections import Counter
from pathlib import Path

import polars
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ur5_ros.bench.entries import load_bench, load_entries
from ur5_ros.bench.jobs import run_jobs
from ur5_ros.bench.perturbations import PERTURBATIONS, QUICK
from ur5_ros.bench.probe import probed_entry
from ur5_ros.bench.report import write_report
from ur5_ros.bench.runs import LARGEST_TRIED, jobs_of
from ur5_ros.bench.table import border_text, markdown, summary
from ur5_ros.bench.tuning import CANDIDATES, CONDITIONS, tune, write_bench
from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import SUCCESS
from ur5_ros.errors import InputError


def bench(law: Path | None, quick: bool, seeds: int, out: Path | None, scheduler: str | None,
          workers: int | None, gains: Path | None, tune_file: Path | None,
          law_timeout: float) -> int:
    """Run the bench; see ``ur5 bench --help``."""
    screen = terminal.console()
    if tune_file is not None:
        return _tune(tune_file, workers, screen)
    entries = load_entries(gains)
    if law is not None:
        entries.append(probed_entry(law, gains, law_timeout))
    names, seeds = (QUICK, 1) if quick else (tuple(PERTURBATIONS), seeds)
    jobs = jobs_of(entries, names, seeds, survival=not quick)
    folder = out if out is not None else Path('bench')
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f'{folder}: {error.strerror}; give another folder with --out') from None
    with terminal.progress('bench', len(jobs), 'runs') as advance:
        rows = run_jobs(jobs, scheduler, workers, advance)
    polars.DataFrame(rows, infer_schema_length=None).write_parquet(
        folder / 'table.parquet', compression='zstd')
    (folder / 'summary.md').write_text(markdown(rows), encoding='utf-8')
    write_report(rows, load_bench(gains).tried, folder / 'report.html')
    _show(summary(rows), screen)
    for why, runs in Counter((row['law'], row['why']) for row in rows
                             if row['why'].startswith('too late')).items():
        screen.print(Text(f'{why[0]}: {why[1]} ({runs} of its runs)'), soft_wrap=True)
    screen.print(Text(f'table: {folder / "table.parquet"}'), soft_wrap=True)
    screen.print(Text(f'report: {folder / "report.html"}'), soft_wrap=True)
    return SUCCESS


def _tune(file: Path, workers: int | None, screen: terminal.Console) -> int:
    try:
        file.open('a', encoding='utf-8').close()  # before the search
    except OSError as error:
        raise InputError(f'{file}: {error.strerror}; give another file with --tune') from None
    runs = len(load_entries()) * CANDIDATES * len(CONDITIONS)
    with terminal.progress('tuning', runs, 'runs') as advance:
        write_bench(tune(workers, advance), file)
    screen.print(Text(f'gains: {file}'), soft_wrap=True)
    return SUCCESS


def _show(table: polars.DataFrame, screen: terminal.Console) -> None:
    heads = ['law', 'survived', 'rms [mrad]', 'worst [mrad]', 'rough [N m/s]']
    borders = [what for what in LARGEST_TRIED if what in table.columns]
    heads += [f'{what} [{"kg" if what == "payload" else "ms"}]' for what in borders]
    shown = Table(*map(escape, heads), box=None, pad_edge=False)
    for row in table.to_dicts():
        numbers = ((row['rms_error'], 1e3), (row['max_error'], 1e3), (row['roughness'], 1.0))
        shown.add_row(row['law'], f'{row["survived"]}/{row["runs"]}',
                      *('-' if value is None else f'{factor * value:.3g}'
                        for value, factor in numbers),
                      *(border_text(row, what) for what in borders))
    screen.print(shown)
