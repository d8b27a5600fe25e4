"""Figures of keys that are drawn at random: scatter of the result, and parallel coordinates."""

import json
from typing import Any

import polars

from ur5_ros.analysis.report.palette import BAD, GOOD, SHORT_NAMES
from ur5_ros.sweep.spec import SweepSpec, is_random
from ur5_ros.sweep.units import with_unit

#: Runs that a figure shows at most.
MOST_POINTS = 5000
#: Lines of each kind that the parallel axes show at most.
MOST_LINES = 500


def drawn_figures(table: polars.DataFrame, spec: SweepSpec) -> list[dict[str, Any]]:
    """Return a scatter for each number that is drawn, and all of them side by side."""
    result = next((name for name in (*spec.success, 'final_error', 'max_error')
                   if name in table.columns), None)
    columns = _numbers(table.head(MOST_POINTS), spec)
    if result is None or not columns:
        return []
    values = table.head(MOST_POINTS)[result].to_list()
    success = table.head(MOST_POINTS)['success'].to_list()
    figures = [_scatter(number, key, drawn, result, values, success)
               for number, (key, drawn) in enumerate(columns.items())]
    if len(columns) > 1:
        figures.append(_parallel(columns, result, values, success))
    return figures


def _numbers(table: polars.DataFrame, spec: SweepSpec) -> dict[str, list[float]]:
    """Return what was drawn, number by number: a list of six becomes six columns."""
    found: dict[str, list[float]] = {}
    for key, axis in spec.vary.items():
        if not is_random(axis) or key not in table.columns:
            continue
        values = [json.loads(value) if isinstance(value, str) else value
                  for value in table[key].to_list()]
        if values and isinstance(values[0], list):
            for i in range(len(values[0])):
                word = SHORT_NAMES[i] if len(values[0]) == 6 else str(i + 1)
                unit = with_unit(key).removeprefix(key)
                found[f'{key}, {word}{unit}'] = [value[i] for value in values]
        elif values and isinstance(values[0], int | float):
            found[with_unit(key)] = values
    return found


def _scatter(number: int, key: str, drawn: list[float], result: str, values: list[Any],
             success: list[bool]) -> dict[str, Any]:
    traces = []
    for good, name, colour in ((True, 'succeeded', GOOD), (False, 'failed', BAD)):
        rows = [i for i, each in enumerate(success) if bool(each) is good]
        if rows:
            traces.append({'type': 'scatter', 'mode': 'markers', 'name': name,
                           'x': [drawn[i] for i in rows], 'y': [values[i] for i in rows],
                           'marker': {'color': colour, 'size': 6, 'opacity': _opacity(rows)}})
    return {'key': f'drawn-{number}', 'x': key, 'y': with_unit(result), 'log': False,
            'title': f'{result} over {key}', 'caption': 'One point per run.', 'traces': traces}


def _opacity(rows: list[int]) -> float:
    """Return how opaque the marks of runs are: few are seen well, many show how dense they are."""
    return max(0.5, min(0.9, 100.0 / len(rows)))


def _parallel(columns: dict[str, list[float]], result: str, values: list[Any],
              success: list[bool]) -> dict[str, Any]:
    """Return one line per run; each axis goes from the least to the greatest value."""
    axes = {**columns, with_unit(result): values}
    places, labels = [], []
    for key, numbers in axes.items():
        known = [number for number in numbers if number is not None]
        low, high = min(known, default=0.0), max(known, default=0.0)
        places.append([None if number is None else (number - low) / ((high - low) or 1.0)
                       for number in numbers])
        labels.append(f'{key.replace(", ", ",<br>")}<br>{low:.3g} to {high:.3g}')
    traces = []
    for good, name, colour in ((True, 'succeeded', GOOD), (False, 'failed', BAD)):
        rows = [i for i, each in enumerate(success) if bool(each) is good][:MOST_LINES]
        if rows:
            traces.append({
                'type': 'scatter', 'mode': 'lines', 'name': name, 'connectgaps': False,
                'x': [x for _ in rows for x in (*range(len(axes)), None)],
                'y': [y for i in rows for y in (*(column[i] for column in places), None)],
                'line': {'color': colour, 'width': 1}, 'opacity': _opacity(rows),
                'hoverinfo': 'name'})
    return {'key': 'parallel', 'x': '', 'y': 'share of the range', 'log': False,
            'title': 'All random values', 'wide': True, 'legend': 'above',  # of long labels
            'caption': 'One line per run: blue succeeded, red failed. Each axis goes from the '
                       'least to the greatest value; a click on the legend hides a kind.',
            'xaxis': {'tickvals': list(range(len(axes))), 'ticktext': labels,
                      'autotickangles': [0, 90], 'range': [-0.4, len(axes) - 0.6]},
            'traces': traces}
