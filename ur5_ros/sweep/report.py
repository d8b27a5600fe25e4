"""The page of a sweep: one HTML file with rates, heat maps and the worst runs."""

import json
from pathlib import Path
from typing import Any

import polars

from ur5_ros.analysis.report.document import html_document
from ur5_ros.analysis.report.document import markup as _text
from ur5_ros.config.records import as_data
from ur5_ros.sweep.spec import SweepSpec
from ur5_ros.sweep.summary import (
    HeatMap,
    Rate,
    discrete_keys,
    heat_maps,
    overall,
    rates_by,
    worst_runs,
)
from ur5_ros.sweep.table import SweepFolder, input_keys

#: Numbers that the maps show beside the success rate.
_MAPPED = ('final_error', 'max_torque')

_TABLE = 'style="display:block;overflow-x:auto"'


def write_report(folder: SweepFolder, path: Path) -> Rate:
    """
    Write the page of a sweep and return its success rate.

    Parameters
    ----------
    folder : SweepFolder
        The sweep.
    path : Path
        File to write.

    """
    table, spec = folder.table(), folder.spec
    maps = heat_maps(table, spec, [name for name in _MAPPED if name in table.columns])
    figures = [*_rate_figures(table, spec), *(_map_figure(i, each) for i, each in enumerate(maps))]
    rate = overall(table)
    body = ''.join([
        f'<div class="verdict"><div class="stamp">{rate.rate:.1%}</div><div><h1>{_text(spec.name)}'
        f'</h1><p>{_text(spec.question)}</p><p>{rate.successes} of {rate.runs} runs succeeded '
        f'(95 % interval {rate.low:.1%} to {rate.high:.1%}).</p></div></div>\n',
        '<h2>Figures</h2>\n<div class="plots">', *(_box(figure) for figure in figures), '</div>\n',
        _rates(table, spec), _worst(table, spec, folder.path),
        f'<h2>Specification</h2><pre>{_text(json.dumps(as_data(spec), indent=1))}'
        '</pre>',
    ])
    path.write_text(html_document(spec.name, body, figures), encoding='utf-8')
    return rate


def _rate_figures(table: polars.DataFrame, spec: SweepSpec) -> list[dict[str, Any]]:
    figures = []
    for number, key in enumerate(discrete_keys(table, spec)):
        rates = rates_by(table, key)
        if len(rates) < 2:
            continue
        shares = [rate.rate for rate in rates.values()]
        figures.append({
            'key': f'rate-{number}', 'x': key, 'y': 'success rate', 'log': False,
            'category': 'x',
            'title': f'Success over {key}', 'caption': 'Bars: 95 % interval (Wilson).',
            'traces': [{
                'type': 'scatter', 'mode': 'lines+markers', 'name': 'success rate',
                'showlegend': False, 'x': _ticks(list(rates)), 'y': shares,
                'error_y': {
                    'type': 'data', 'symmetric': False,
                    'array': [rate.high - rate.rate for rate in rates.values()],
                    'arrayminus': [rate.rate - rate.low for rate in rates.values()]},
            }]})
    return figures


def _map_figure(number: int, heat: HeatMap) -> dict[str, Any]:
    limits = {'zmin': 0, 'zmax': 1} if heat.what == 'success rate' else {}
    return {
        'key': f'map-{number}', 'x': heat.x, 'y': heat.y, 'log': False, 'category': 'xy',
        'title': f'{heat.what} over {heat.x} and {heat.y}',
        'caption': 'Mean of the runs in a cell.' if limits else 'Median of the runs in a cell.',
        'traces': [{'type': 'heatmap', 'x': _ticks(heat.x_values), 'y': _ticks(heat.y_values),
                    'z': heat.z, 'colorscale': 'Viridis', 'hoverongaps': False, **limits}]}


def _ticks(values: list[Any]) -> list[str]:
    return [_short(value) for value in values]


def _box(figure: dict[str, Any]) -> str:
    return (f'<figure><figcaption><b>{_text(figure["title"])}</b>{_text(figure["caption"])}'
            f'</figcaption><div class="plot" id="plot-{figure["key"]}"></div></figure>\n')


def _rates(table: polars.DataFrame, spec: SweepSpec) -> str:
    rows = ''.join(
        f'<tr><td>{_text(key)}</td><td>{_text(value)}</td><td class="number">{rate.successes} of '
        f'{rate.runs}</td><td class="number">{rate.rate:.1%}</td>'
        f'<td class="number">{rate.low:.1%} to {rate.high:.1%}</td></tr>\n'
        for key in discrete_keys(table, spec) for value, rate in rates_by(table, key).items())
    return ('<h2>Success rates</h2>\n<table><thead><tr><th>key</th><th>value</th><th>runs</th>'
            f'<th>rate</th><th>95 % interval</th></tr></thead><tbody>{rows}</tbody></table>\n')


def _worst(table: polars.DataFrame, spec: SweepSpec, folder: Path) -> str:
    keys = [key for key in input_keys(spec) if key in table.columns]
    head = ''.join(f'<th>{_text(name)}</th>' for name in
                   ('run', *keys, 'status', 'largest error [rad]', 'why', 'repeat it'))
    rows = ''.join(
        '<tr>' + ''.join(f'<td>{_text(cell)}</td>' for cell in (
            row['index'], *(_short(row[key]) for key in keys), row['status'],
            _short(row.get('max_error')), row.get('why') or '',
            repeat_command(folder, row['index']),
        )) + '</tr>\n' for row in worst_runs(table))
    return (f'<h2>Worst runs</h2>\n<table {_TABLE}><thead><tr>{head}</tr></thead>'
            f'<tbody>{rows}</tbody></table>\n')


def repeat_command(folder: Path, index: int) -> str:
    """Return the command that repeats one run of a sweep, with its bags."""
    return f'ur5 sweep {folder}/sweep.json --only {index}'


def _short(value: Any) -> str:
    return f'{value:.4g}' if isinstance(value, float) else str(value)
