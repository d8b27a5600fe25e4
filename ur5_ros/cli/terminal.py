"""What a command prints: tables, verdicts, progress; colours on a terminal alone."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from ur5_ros.analysis.result import FAIL, PASS, Result

_COLOUR = {'pass': 'green', 'fail': 'bold red', 'not applicable': 'dim'}


class Advance(Protocol):
    """Moves a progress bar."""

    def __call__(self, done: float, total: float | None = None) -> None:
        """Set the amount that is done, and the total if it has changed."""


def console() -> Console:
    """Return where results go: as wide as the terminal, never wrapped in a file."""
    out = Console(highlight=False)
    if not out.is_terminal:
        out = Console(highlight=False, width=max(160, shutil.get_terminal_size().columns))
    return out


@contextmanager
def progress(what: str, total: float, unit: str = '') -> Iterator[Advance]:
    """
    Show a bar on stderr while the block works, and nothing where stderr is no terminal.

    Parameters
    ----------
    what : str
        What is being done.
    total : float
        The whole.
    unit : str, optional
        Unit of done and total.

    """
    errors = Console(stderr=True)
    bar = Progress(
        TextColumn('{task.description}'), BarColumn(),
        TextColumn(f'{{task.completed:.1f}} of {{task.total:.1f}} {unit}'), TimeRemainingColumn(),
        console=errors, transient=True, disable=not errors.is_terminal)
    with bar:
        task = bar.add_task(what, total=total)

        def advance(done: float, total: float | None = None) -> None:
            bar.update(task, completed=done, total=total)

        yield advance


def show_result(out: Console, result: Result) -> None:
    """Print the checks of a run as a table, then its causes and its verdict."""
    table = Table(box=None, pad_edge=False, header_style='bold')
    table.add_column('check', no_wrap=True)
    table.add_column('verdict', no_wrap=True)
    table.add_column('value', justify='right', no_wrap=True)
    table.add_column('limit', justify='right', no_wrap=True)
    table.add_column('unit', no_wrap=True)
    for check in result.checks:
        table.add_row(check.name, Text(check.verdict, _COLOUR[check.verdict]),
                      _number(check.value), _number(check.limit), check.unit)
    out.print(table)
    for remark in result.about.get('remarks', ()):
        out.print(Text(f'note: {remark}'), soft_wrap=True)
    for check in result.checks:
        if check.verdict == FAIL:
            out.print(Text(f'{check.name}: {check.sentence}'), soft_wrap=True)
    for cause in result.causes:
        out.print(Text(f'cause: {cause.get("sentence", cause)}'), soft_wrap=True)
    show_verdict(out, result.run, result.verdict)


def show_verdict(out: Console, run: str, verdict: str) -> None:
    """Print one line: the run and whether it passed."""
    out.print(Text.assemble(f'{run}: ', (verdict, _COLOUR[verdict] if verdict == PASS
                                         else _COLOUR['fail'])), soft_wrap=True)


def _number(value: float | None) -> str:
    return '' if value is None else f'{value:.4g}'
