"""The rows of the bench put together: what each law makes of each perturbation."""

from math import isinf
from statistics import median
from typing import Any, NamedTuple

import polars

from ur5_ros.bench.runs import LARGEST_TRIED
from ur5_ros.bench.scores import SCORES


class Cell(NamedTuple):
    """The runs of a law under a perturbation."""

    value: float | None
    """Median error of those survived [mrad]; None where none was."""
    text: str


def summary(rows: list[dict[str, Any]]) -> polars.DataFrame:
    """
    Return a row for each law.

    Returned: ``law``, runs, how many survived, the median of each score over the runs survived;
    where they were looked for, the largest ``payload`` [kg] and ``delay`` [ms] survived, and those
    with which the law is still accurate, ``accurate_payload`` and ``accurate_delay``.
    """
    table = polars.DataFrame(rows, infer_schema_length=None)
    runs = table.filter(polars.col('kind') == 'run')
    lived = polars.col('survived')
    means = runs.group_by('law', maintain_order=True).agg(
        polars.len().alias('runs'), lived.sum().alias('survived'),
        *(polars.col(score).filter(lived).median() for score in SCORES))
    for what in LARGEST_TRIED if 'largest' in table.columns else ():
        found = table.filter((polars.col('kind') == 'survival')
                             & (polars.col('perturbation') == what))
        means = means.join(
            found.select('law', polars.col('largest').alias(what),
                         polars.col('accurate').alias(f'accurate_{what}')),
            on='law', how='left', maintain_order='left')
    return means


def error_cells(rows: list[dict[str, Any]]) -> dict[tuple[str, str], Cell]:
    """Return the cell of each law and perturbation, in the order of the rows."""
    found = {}
    table = polars.DataFrame(rows, infer_schema_length=None)
    runs = table.filter(polars.col('kind') == 'run')
    for (law, name), some in runs.group_by(['law', 'perturbation'], maintain_order=True):
        alive, count = int(some['survived'].sum()), len(some)
        errors = some.filter(polars.col('survived'))['rms_error'].to_list()
        value = 1e3 * median(errors) if errors else None
        text = 'lost' if value is None else f'{value:.3g}'
        found[str(law), str(name)] = Cell(
            value, text if alive in (0, count) else f'{text} ({alive}/{count})')
    return found


def border_text(row: dict[str, Any], what: str) -> str:
    """Return the largest payload or delay survived and, in brackets, the largest accurate one."""
    if row.get(what) is None:
        return '-'
    largest, accurate = (f'> {LARGEST_TRIED[what]:g}' if isinf(value) else f'{value:.3g}'
                         for value in (row[what], row[f'accurate_{what}']))
    return f'{largest} ({accurate})'


def markdown(rows: list[dict[str, Any]]) -> str:
    """Return the table of a page: the median error [mrad] of each law under each perturbation."""
    cells = error_cells(rows)
    names = list(dict.fromkeys(name for _, name in cells))
    lines = ['| law | ' + ' | '.join([*(each.replace('_', ' ') for each in names),
                                      'payload [kg]', 'delay [ms]']) + ' |',
             '|---' * (len(names) + 3) + '|']
    for row in summary(rows).to_dicts():
        shown = [*(cells[row['law'], name].text for name in names),
                 *(border_text(row, what) for what in LARGEST_TRIED)]
        lines.append(f'| {row["law"]} | ' + ' | '.join(shown) + ' |')
    return '\n'.join(lines) + '\n'
