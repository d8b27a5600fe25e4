"""The page of a sweep: one HTML file with rates, heat maps and the worst runs."""

import json
from pathlib import Path
from typing import Any

import polars

from ur5_ros.analysis.report.document import html_document
from ur5_ros.analysis.report.document import markup as _text
from ur5_ros.config.records import as_data
from ur5_ros.sweep.drawn_figures import drawn_figures
from ur5_ros.sweep.spec import SweepSpec, has_drawn_keys
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
from ur5_ros.sweep.units import quantity, shown, table_shown, with_unit
from ur5_ros.wording import number_of

#: Numbers that the maps show beside the success rate.
_MAPPED = ('final_error', 'max_torque')

#: Rows of the table of runs at most, the worst first.
MOST_RUNS = 1000

#: One scale from bad (red) to good (blue), also for readers who cannot distinguish red from green.
HIGH_IS_GOOD: list[tuple[float, str]] = [(0.0, '#b2182b'), (0.5, '#f7f7f7'), (1.0, '#2166ac')]
LOW_IS_GOOD = [(1.0 - at, colour) for at, colour in reversed(HIGH_IS_GOOD)]

_TABLE = 'class="sortable" style="display:block;overflow-x:auto"'


def write_report(folder: SweepFolder, path: Path) -> Rate:
    """Write the page of a sweep and return its success rate."""
    table, spec = table_shown(folder.table()), folder.spec
    maps = heat_maps(table, spec, [name for name in _MAPPED if name in table.columns])
    figures = [*_rate_figures(table, spec), *drawn_figures(table, spec),
               *(_map_figure(i, each) for i, each in enumerate(maps))]
    rate = overall(table)
    interval = (f' (95 % interval {rate.low:.1%} to {rate.high:.1%})' if has_drawn_keys(spec)
                else '')
    body = ''.join([
        f'<div class="verdict"><div class="stamp">{rate.rate:.1%}</div><div><h1>{_text(spec.name)}'
        f'</h1><p>{_text(spec.question)}</p><p>{rate.successes} of {number_of(rate.runs, "run")} '
        f'succeeded{interval}. {_criterion(spec)}</p></div></div>\n',
        '<h2>Figures</h2>\n<div class="plots">', *(_box(figure) for figure in figures), '</div>\n',
        _rates(table, spec), _runs(table, spec, folder.path),
        f'<h2>Specification</h2><pre>{_text(json.dumps(as_data(spec), indent=1))}'
        '</pre>',
    ])
    path.write_text(html_document(spec.name, body, figures), encoding='utf-8')
    return rate


def _rate_figures(table: polars.DataFrame, spec: SweepSpec) -> list[dict[str, Any]]:
    figures, random = [], has_drawn_keys(spec)
    for number, key in enumerate(discrete_keys(table, spec)):
        rates = rates_by(table, key)
        if len(rates) < 2:
            continue
        shares = [rate.rate for rate in rates.values()]
        figures.append({
            'key': f'rate-{number}', 'x': with_unit(key), 'y': 'success rate', 'log': False,
            'category': 'x', 'yaxis': {'range': [-0.05, 1.05], 'tickformat': '.0%'},
            'title': f'Success over {key}',
            'caption': 'Bars: 95 % interval (Wilson).' if random else 'Share of the runs.',
            'traces': [{
                'type': 'scatter', 'mode': 'lines+markers', 'name': 'success rate',
                'showlegend': False, 'x': _ticks(list(rates)), 'y': shares,
                'error_y': {
                    'type': 'data', 'symmetric': False, 'visible': random,
                    'array': [rate.high - rate.rate for rate in rates.values()],
                    'arrayminus': [rate.rate - rate.low for rate in rates.values()]},
            }]})
    return figures


def _map_figure(number: int, heat: HeatMap) -> dict[str, Any]:
    limits: dict[str, Any] = {'colorscale': LOW_IS_GOOD}
    rate = heat.what == 'success rate'
    if rate:
        limits = {'zmin': 0, 'zmax': 1, 'colorscale': HIGH_IS_GOOD}
    return {
        'key': f'map-{number}', 'x': with_unit(heat.x), 'y': with_unit(heat.y), 'log': False,
        'category': 'xy',
        'title': f'{with_unit(heat.what)} over {heat.x} and {heat.y}',
        'caption': ('Mean' if rate else 'Median') + ' of the runs in a cell; blue is good.',
        'traces': [{'type': 'heatmap', 'x': _ticks(heat.x_values), 'y': _ticks(heat.y_values),
                    'z': heat.z, 'hoverongaps': False, **limits}]}


def _ticks(values: list[Any]) -> list[str]:
    return [_short(value) for value in values]


def _box(figure: dict[str, Any]) -> str:
    wide = ' class="wide"' if figure.get('wide') else ''
    return (f'<figure{wide}><figcaption><b>{_text(figure["title"])}</b>{_text(figure["caption"])}'
            f'</figcaption><div class="plot" id="plot-{figure["key"]}"></div></figure>\n')


def _rates(table: polars.DataFrame, spec: SweepSpec) -> str:
    random = has_drawn_keys(spec)

    def interval(rate: Rate) -> str:
        return (f'<td class="number">{rate.low:.1%} to {rate.high:.1%}</td>' if random else '')

    rows = ''.join(
        f'<tr><td>{_text(with_unit(key))}</td><td>{_text(_short(value))}</td>'
        f'<td class="number">{rate.successes} of {rate.runs}</td>'
        f'<td class="number">{rate.rate:.1%}</td>'
        f'{interval(rate)}</tr>\n'
        for key in discrete_keys(table, spec) for value, rate in rates_by(table, key).items())
    if not rows:
        return ''
    return ('<h2>Success rates</h2>\n<table><thead><tr><th>key</th><th>value</th><th>runs</th>'
            f'<th>rate</th>{"<th>95 % interval</th>" if random else ""}</tr></thead>'
            f'<tbody>{rows}</tbody></table>\n')


def _criterion(spec: SweepSpec) -> str:
    """Return what counts as success."""
    if not spec.success:
        return 'Success: no check fails.'
    limits = ', '.join(f'{name} at most {quantity(name, limit)}'
                       for name, limit in spec.success.items())
    return _text(f'Success: {limits}.')


def _runs(table: polars.DataFrame, spec: SweepSpec, folder: Path) -> str:
    """Return the table of the runs, the worst first."""
    keys = [key for key in input_keys(spec) if key in table.columns]
    numbers = list(dict.fromkeys(
        [name for name in (*spec.success, 'max_error') if name in table.columns]))
    limits = {name: shown(name, limit) for name, limit in spec.success.items()}
    head = ''.join(f'<th>{_text(name)}</th>' for name in (
        'run', *map(with_unit, keys), 'status', *map(with_unit, numbers), 'why', 'repeat it'))
    rows = ''.join(
        '<tr>' + ''.join(f'<td>{_text(cell)}</td>' for cell in (
            row['index'], *(_short(row[key]) for key in keys), row['status'],
            *(_short(row.get(name)) for name in numbers), row.get('why') or '',
        )) + f'<td class="whole">{_text(repeat_command(folder, row["index"]))}</td></tr>\n'
        for row in worst_runs(table, MOST_RUNS, limits))
    more = f' (the worst {MOST_RUNS} of {table.height})' if table.height > MOST_RUNS else ''
    return (f'<h2>Runs, the worst first{more}</h2>\n<table {_TABLE}><thead><tr>{head}</tr></thead>'
            f'<tbody>{rows}</tbody></table>\n')


def repeat_command(folder: Path, index: int) -> str:
    """Return the command that repeats one run of a sweep, with its bags."""
    return f'ur5 sweep {folder}/sweep.json --only {index}'


def _short(value: Any) -> str:
    if isinstance(value, str) and value.startswith('['):  # as the table holds lists
        value = json.loads(value)
    if isinstance(value, list):
        return ', '.join(map(_short, value))
    return f'{value:.4g}' if isinstance(value, float) else str(value)
