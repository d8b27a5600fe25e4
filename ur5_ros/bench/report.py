"""The page of the bench: a heat map, the Pareto front of the gains, and the table."""

import math
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import polars

from ur5_ros.analysis.report.document import html_document, markup
from ur5_ros.bench.entries import Candidate
from ur5_ros.bench.scores import SCORES
from ur5_ros.bench.tuning import pareto_front

_UNITS = {'rms_error': 'mrad', 'max_error': 'mrad', 'effort': 'N m', 'energy': 'J',
          'roughness': 'N m/s', 'payload': 'kg', 'delay': 'ms'}
_HEADS = {'rms_error': 'RMS error', 'max_error': 'largest error', 'effort': 'RMS torque',
          'payload': 'largest payload', 'delay': 'largest delay'}
#: One scale from good (blue) to bad (red) where little is good.
LOW_IS_GOOD = [(0.0, '#4393c3'), (0.5, '#f7f7f7'), (1.0, '#d6604d')]


def summary(rows: list[dict[str, Any]]) -> polars.DataFrame:
    """
    Return a row for each law.

    Returned: ``law``, runs, how many survived, the median of each score over the runs survived,
    the largest payload [kg] and delay [ms] survived; in the order of the laws.
    """
    table = polars.DataFrame(rows, infer_schema_length=None)
    runs = table.filter(polars.col('kind') == 'run')
    lived = polars.col('survived')
    means = runs.group_by('law', maintain_order=True).agg(
        polars.len().alias('runs'), lived.sum().alias('survived'),
        *(polars.col(score).filter(lived).median() for score in SCORES))
    for what in ('payload', 'delay'):
        if 'largest' in table.columns:
            found = table.filter((polars.col('kind') == 'survival')
                                 & (polars.col('perturbation') == what))
            means = means.join(found.select('law', polars.col('largest').alias(what)), on='law',
                               how='left', maintain_order='left')
    return means


def write_report(rows: list[dict[str, Any]], tried: list[Candidate], path: Path) -> None:
    """Write the page."""
    table = polars.DataFrame(rows, infer_schema_length=None)
    figures = [_heat_map(table), *([_pareto(tried)] if tried else [])]
    boxes = ''.join(
        f'<figure class="wide"><figcaption><b>{markup(each["title"])}</b>{markup(each["caption"])}'
        f'</figcaption><div class="plot" id="plot-{each["key"]}"></div></figure>\n'
        for each in figures)
    body = (f'<h1>Laws side by side</h1>\n<div class="plots">{boxes}</div>\n'
            f'<h2>All perturbations together</h2>\n{_table(summary(rows))}')
    path.write_text(html_document('Laws side by side', body, figures), encoding='utf-8')


def markdown(rows: list[dict[str, Any]]) -> str:
    """Return the table of a page: the median error [mrad] of each law under each perturbation."""
    cells = error_cells(polars.DataFrame(rows, infer_schema_length=None))
    names = list(dict.fromkeys(name for _, name in cells))
    ends = {row['law']: row for row in summary(rows).to_dicts()}
    lines = ['| law | ' + ' | '.join([*(each.replace('_', ' ') for each in names),
                                      'payload [kg]', 'delay [ms]']) + ' |',
             '|---' * (len(names) + 3) + '|']
    for law, row in ends.items():
        shown = [cells[law, name].text for name in names]
        shown += ['-' if row.get(what) is None else f'{row[what]:.3g}'
                  for what in ('payload', 'delay')]
        lines.append(f'| {law} | ' + ' | '.join(shown) + ' |')
    return '\n'.join(lines) + '\n'


class Cell(NamedTuple):
    """The runs of a law under a perturbation."""

    value: float | None
    """Median error of those survived [mrad]; None where none was."""
    text: str


def error_cells(table: polars.DataFrame) -> dict[tuple[str, str], Cell]:
    """Return the cell of each law and perturbation, in the order of the table."""
    found = {}
    runs = table.filter(polars.col('kind') == 'run')
    for (law, name), some in runs.group_by(['law', 'perturbation'], maintain_order=True):
        alive, count = int(some['survived'].sum()), len(some)
        errors = some.filter(polars.col('survived'))['rms_error'].to_list()
        value = 1e3 * median(errors) if errors else None
        text = 'lost' if value is None else f'{value:.3g}'
        found[str(law), str(name)] = Cell(
            value, text if alive in (0, count) else f'{text} ({alive}/{count})')
    return found


def _heat_map(table: polars.DataFrame) -> dict[str, Any]:
    found = error_cells(table)
    laws = list(dict.fromkeys(law for law, _ in found))
    names = list(dict.fromkeys(name for _, name in found))
    rows = [[found[law, name] for name in names] for law in reversed(laws)]
    cells = [[None if each.value is None else math.log10(each.value) for each in row]
             for row in rows]
    texts = [[each.text for each in row] for row in rows]
    return {'key': 'laws', 'x': 'perturbation', 'y': 'law', 'log': False, 'category': 'xy',
            'title': 'Tracking error',
            'caption': 'Median of the root mean square error [mrad]; in brackets how many '
                       'survived; blue is good (the colour is its logarithm).',
            'traces': [{'type': 'heatmap', 'x': names, 'y': list(reversed(laws)), 'z': cells,
                        'text': texts, 'texttemplate': '%{text}', 'colorscale': LOW_IS_GOOD,
                        'textfont': {'color': '#1c2127', 'size': 12},
                        'hoverongaps': False, 'showscale': False}]}


def _pareto(tried: list[Candidate]) -> dict[str, Any]:
    traces = []
    for law in dict.fromkeys(row.law for row in tried):
        front = pareto_front([row for row in tried if row.law == law])
        traces.append({
            'type': 'scatter', 'mode': 'lines+markers', 'name': law,
            'x': [row.roughness for row in front],
            'y': [1e3 * (row.rms_error or 0.0) for row in front],
            'text': [f'{row.frequency:g} rad/s, damping {row.damping:g}, own {row.own:g}'
                     for row in front]})
    return {'key': 'pareto', 'x': 'roughness of the torque [N m/s]', 'y': 'rms error [mrad]',
            'log': True, 'title': 'What accuracy costs',
            'caption': 'Gains of the search that no others beat in error and in roughness.',
            'traces': traces}


def _table(table: polars.DataFrame) -> str:
    def shown(name: str, value: Any) -> str:
        if value is None:
            return '-'
        if name in ('rms_error', 'max_error'):
            return f'{1e3 * value:.3g}'
        return f'{value:.3g}' if isinstance(value, float) else str(value)
    head = ''.join(f'<th>{markup(_HEADS.get(name, name))}{_unit(name)}</th>'
                   for name in table.columns)
    rows = ''.join('<tr>' + ''.join(f'<td>{markup(shown(name, value))}</td>'
                                    for name, value in row.items()) + '</tr>\n'
                   for row in table.to_dicts())
    return f'<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>\n'


def _unit(name: str) -> str:
    return f' [{_UNITS[name]}]' if name in _UNITS else ''
