"""What a command prints: tables, verdicts, progress; colours on a terminal alone."""

import math
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.result import FAIL, Result

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
    """Show a bar on stderr while the block works, and nothing where stderr is no terminal."""
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
    """Print why a run fails, its checks as a table, what was added to the plant, the verdict."""
    for cause in result.causes:
        show_text(out, f'cause: {cause.get("sentence", cause)}')
    for check in result.checks:
        if check.verdict == FAIL:
            show_text(out, f'{check.name}: {check.sentence}')
    table = Table(box=None, pad_edge=False, header_style='bold')
    table.add_column('check', no_wrap=True)
    table.add_column('verdict', no_wrap=True)
    table.add_column('value', justify='right', no_wrap=True)
    table.add_column('limit', justify='right', no_wrap=True)
    table.add_column('unit', no_wrap=True)
    for check in result.checks:
        value, limit, unit = check.on_screen()
        table.add_row(check.name, Text(check.verdict, _COLOUR[check.verdict]), number(value),
                      number(limit), unit)
    out.print(table)
    for remark in result.about.get('remarks', ()):
        show_text(out, f'note: {remark}')
    injected = [f'{each["what"]}' + (f' from {each["from_s"]:.4g} s' if each['from_s'] else '')
                for each in result.about.get('injected', ())]
    if injected:
        more = f'; {len(injected) - 6} more' if len(injected) > 6 else ''
        show_text(out, f'added to the plant: {"; ".join(injected[:6])}{more}')
    colour = 'yellow' if result.headline != result.verdict else _COLOUR[result.verdict]
    folder = result.about.get('folder') or result.run
    out.print(Text.assemble(f'{folder}: ', (result.headline, colour)), soft_wrap=True)


def show_notes(out: Console, run: Run) -> None:
    """Print what of a run was passed over, assumed or is missing."""
    for sentence in (*run.problems, *run.remarks):
        show_text(out, f'note: {run.name}: {sentence}')


def show_text(out: Console, text: str) -> None:
    """Print a sentence: wrapped at blanks on a terminal, one line in a file."""
    out.print(Text(text), soft_wrap=not out.is_terminal)


def show_next(out: Console, command: str, purpose: str) -> None:
    """Print the command that is useful next."""
    whole = f'next: {command}  # {purpose}'
    apart = out.is_terminal and len(whole) > out.width  # a command is never broken
    out.print(Text.assemble(('next: ', 'dim'), command,
                            (f'{chr(10) if apart else "  "}# {purpose}', 'dim')), soft_wrap=True)


def number(value: float | None) -> str:
    """Return a number in four digits; empty for none, ``never`` for a time without an end."""
    if value is None:
        return ''
    return 'never' if value == math.inf else f'{value:.4g}'
