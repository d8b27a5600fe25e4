"""The page of the bench: a heat map, the Pareto front of the gains, and the table."""

import math
from pathlib import Path
from typing import Any

from ur5_ros.analysis.report.document import html_document, markup, write_document
from ur5_ros.analysis.report.palette import SERIES_COLOURS
from ur5_ros.bench.entries import Candidate
from ur5_ros.bench.perturbations import ACCURATE, SURVIVES
from ur5_ros.bench.runs import LARGEST_TRIED
from ur5_ros.bench.table import border_text, error_cells, summary
from ur5_ros.bench.tuning import pareto_front
from ur5_ros.sweep.report import LOW_IS_GOOD

#: A law that is so many times worse than the best of its column has the last colour.
_WORST = 100.0
#: Laws that share a colour differ in mark and dash.
_DASHES = ('solid', 'dot', 'dash')
_MARKS = ('circle', 'square', 'diamond', 'triangle-up', 'x')
#: Heading of a column of the table, its key and what its numbers are multiplied with.
_COLUMNS = (('RMS error [mrad]', 'rms_error', 1e3), ('largest error [mrad]', 'max_error', 1e3),
            ('RMS torque [N m]', 'effort', 1.0), ('energy [J]', 'energy', 1.0),
            ('roughness [N m/s]', 'roughness', 1.0))


def write_report(rows: list[dict[str, Any]], tried: list[Candidate], path: Path) -> None:
    """Write the page of rows and of what the search of the gains tried."""
    figures = [_heat_map(rows), *([_pareto(tried)] if tried else [])]
    body = (f'<h1>Laws side by side</h1>\n{"".join(map(_box, figures))}'
            f'<h2>All perturbations together</h2>\n{_table(rows)}')
    write_document(html_document('Laws side by side', body, figures), path)


def _box(figure: dict[str, Any]) -> str:
    """Return a figure as wide as the page; where that is too narrow it can be moved sideways."""
    return (f'<figure style="margin:18px 0;overflow-x:auto"><figcaption>'
            f'<b>{markup(figure["title"])}</b>{markup(figure["caption"])}</figcaption>'
            f'<div class="plot" id="plot-{figure["key"]}" '
            f'style="height:{figure["height"]}px;min-width:{figure["least"]}px"></div></figure>\n')


def _heat_map(rows: list[dict[str, Any]]) -> dict[str, Any]:
    found = error_cells(rows)
    laws = list(dict.fromkeys(law for law, _ in found))
    names = list(dict.fromkeys(name for _, name in found))
    best = {name: min((cell.value for (_, each), cell in found.items()
                       if each == name and cell.value is not None), default=1.0)
            for name in names}
    cells = [[found[law, name] for name in names] for law in laws]
    far = [[_times(cell.value, best[name]) for cell, name in zip(row, names, strict=True)]
           for row in cells]
    return {
        'key': 'laws', 'x': '', 'y': '', 'log': False, 'category': 'xy',
        'yaxis': {'autorange': 'reversed'},
        'title': 'Tracking error of each law under each perturbation',
        'caption': 'Median of the root mean square joint error [mrad], in brackets how many runs '
                   'survived where not all did. Blue: the best of its column; dark red: '
                   f'{_WORST:g} times its error or more, or lost.',
        'height': 90 + 34 * len(laws), 'least': 190 + 78 * len(names),
        'traces': [{
            'type': 'heatmap', 'x': [each.replace('_', ' ') for each in names], 'y': laws,
            'z': [[math.log10(value) for value in row] for row in far], 'zmin': 0.0,
            'zmax': math.log10(_WORST), 'colorscale': LOW_IS_GOOD, 'xgap': 2, 'ygap': 2,
            'text': [[cell.text for cell in row] for row in cells],
            'customdata': [[f'{value:.3g}' for value in row] for row in far],
            'texttemplate': '%{text}', 'textfont': {'size': 12}, 'showscale': False,
            'hovertemplate': '%{y}, %{x}: %{text}<br>%{customdata} times the best<extra></extra>',
        }]}


def _times(value: float | None, best: float) -> float:
    """Return how many times the best error an error is, at most the last colour's."""
    return _WORST if value is None else max(1.0, min(value / max(best, 1e-12), _WORST))


def _pareto(tried: list[Candidate]) -> dict[str, Any]:
    traces: list[dict[str, Any]] = []
    for number, law in enumerate(dict.fromkeys(row.law for row in tried)):
        rows = [row for row in tried if row.law == law]
        front, used = pareto_front(rows), min(rows, key=lambda row: row.cost)
        again = number // len(SERIES_COLOURS)
        colour, mark = SERIES_COLOURS[number % len(SERIES_COLOURS)], _MARKS[number % len(_MARKS)]
        traces += [
            _gains(front, {'name': law, 'mode': 'lines+markers',
                           'line': {'color': colour, 'width': 1.5, 'dash': _DASHES[again % 3]},
                           'marker': {'symbol': mark, 'size': 6}}),
            _gains([used], {'name': law, 'mode': 'markers', 'showlegend': False,
                            'marker': {'symbol': mark, 'size': 13, 'color': colour}})]
    return {'key': 'pareto', 'x': 'roughness of the torque [N m/s]', 'y': 'rms error [mrad]',
            'log': True, 'xaxis': {'type': 'log', 'minorloglabels': 'none'},
            'title': 'What accuracy costs',
            'caption': 'Gains of the search that no others of their law beat in error and in '
                       'roughness; the large mark is what the bench uses. Further left and down '
                       'is better.',
            'height': 520, 'least': 320, 'traces': traces}


def _gains(rows: list[Candidate], look: dict[str, Any]) -> dict[str, Any]:
    """Return candidates as a trace."""
    return look | {
        'type': 'scatter', 'x': [row.roughness for row in rows],
        'y': [1e3 * (row.rms_error or 0.0) for row in rows],
        'text': [f'{row.frequency:g} rad/s, damping {row.damping:g}, own {row.own:g}'
                 for row in rows],
        'hovertemplate': '%{text}<br>%{y:.3g} mrad, %{x:.3g} N m/s'}


def _table(rows: list[dict[str, Any]]) -> str:
    table = summary(rows).to_dicts()
    borders = [what for what in LARGEST_TRIED if what in table[0]]
    heads = ['law', 'survived', *(title for title, _, _ in _COLUMNS),
             *(f'{what} [{"kg" if what == "payload" else "ms"}]' for what in borders)]
    lines = ''
    for row in table:
        shown = [row['law'], f'{row["survived"]} of {row["runs"]}',
                 *('-' if row[key] is None else f'{factor * row[key]:.3g}'
                   for _, key, factor in _COLUMNS),
                 *(border_text(row, what) for what in borders)]
        lines += '<tr>' + ''.join(f'<td class="number">{markup(each)}</td>'
                                  for each in shown) + '</tr>\n'
    words = '<p class="soft">Medians over the runs survived.'
    if borders:
        words += (f' Payload and delay: the largest with which every joint stays within '
                  f'{SURVIVES:g} rad, in brackets within {1e3 * ACCURATE:g} mrad.')
    return (f'{words}</p>\n'
            '<table class="sortable" style="display:block;overflow-x:auto"><thead><tr>'
            + ''.join(f'<th>{markup(each)}</th>' for each in heads)
            + f'</tr></thead><tbody>{lines}</tbody></table>\n')
