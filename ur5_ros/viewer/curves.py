"""Curves beside the arm: torques, joint errors, tool error, with a mark at the time shown."""

from collections.abc import Mapping, Sequence

import numpy as np
import viser
from viser import uplot

from ur5_ros.analysis.injected import Injection
from ur5_ros.analysis.report.palette import JOINT_COLOURS, MEASURED, SHORT_NAMES
from ur5_ros.viewer.track import Track

MARK = '#888888'
#: Ranges below this are rounding, in N m, mrad and mm: drawn as a straight line.
SMALLEST = 1e-6
#: Of a chart [pixels].
_HEIGHT = 170


def colour_key(colours: Mapping[str, str]) -> str:
    """Return Markdown that shows which name has which CSS colour."""
    return ' '.join(f'<span style="color:{colour}">&#9632;</span> {name}'
                    for name, colour in colours.items())


class Curve:
    """
    One chart over time with a mark that can be moved.

    ``t`` (n,): time [s]; ``values`` (n, len(names)): what is drawn; NaN leaves a gap;
    ``instants``: times [s] with a numbered line, numbered from 1.

    """

    def __init__(self, server: viser.ViserServer, title: str, names: tuple[str, ...],
                 t: np.ndarray, values: np.ndarray, instants: Sequence[float] = ()):
        self._t, self._values, self._row, self._names = t, values, 0, names
        self._lines = self._numbered(instants)
        self._chart = server.gui.add_uplot(
            data=self._data(0), series=self._series([True] * len(names)), title=title,
            scales=self._scales(), height=_HEIGHT, legend=uplot.Legend(show=True, live=True),
            axes=_axes(self._lines))

    def select(self, shown: Sequence[bool]) -> None:
        """Draw these of the curves only."""
        self._chart.series = self._series(shown)

    def mark(self, row: int) -> None:
        """Put the mark at a row of the data."""
        if row != self._row:
            self._row = row
            self._chart.data = self._data(row)

    def show(self, t: np.ndarray, values: np.ndarray, instants: Sequence[float] = ()) -> None:
        """
        Draw other data, with the mark at their end.

        ``t`` (n,): time [s]; ``values`` (n, number of names): what is drawn; NaN leaves a gap;
        ``instants``: times [s] with a numbered line.
        """
        self._t, self._values, self._row = t, values, len(t) - 1
        if (lines := self._numbered(instants)) != self._lines:
            self._lines = lines
            self._chart.axes = _axes(lines)
        self._chart.scales = self._scales()
        self._chart.data = self._data(self._row)

    def _numbered(self, instants: Sequence[float]) -> dict[int, float]:
        """Return the instants within the time shown, by their number."""
        return {i: at for i, at in enumerate(instants, start=1)
                if self._t[0] <= at <= self._t[-1]}

    def _series(self, shown: Sequence[bool]) -> tuple[uplot.Series, ...]:
        colours = JOINT_COLOURS if self._names == SHORT_NAMES else (MEASURED,)
        lines = [uplot.Series(label=name, stroke=colours[i], width=1.5, show=shown[i])
                 for i, name in enumerate(self._names)]
        mark = uplot.Series(label='now', stroke=MARK, width=1.0,
                            points=uplot.Series_Points(show=True, size=7.0, fill=MARK))
        return (uplot.Series(label='t [s]'), *lines, mark)

    def _scales(self) -> dict[str, uplot.Scale]:
        """Return the ranges, stated because gaps would leave uPlot without any."""
        known = self._values[np.isfinite(self._values)]
        low, high = (known.min(), known.max()) if len(known) else (0.0, 1.0)
        margin = 0.06 * (high - low) if high - low > SMALLEST else 0.5
        return {'x': uplot.Scale(time=False, range=(float(self._t[0]), float(self._t[-1]))),
                'y': uplot.Scale(range=(float(low - margin), float(high + margin)))}

    def _data(self, row: int) -> tuple[np.ndarray, ...]:
        mark = np.full(len(self._t), np.nan)
        shown = self._values[row]
        if np.isfinite(shown).any():
            mark[row] = shown[np.nanargmax(np.abs(shown))]
        return (self._t, *np.ascontiguousarray(self._values.T), mark)


class Curves:
    """
    The three charts of a track.

    ``injected``: what was added to the plant: a numbered line in every chart at each instant.

    """

    def __init__(self, server: viser.ViserServer, track: Track,
                 injected: Sequence[Injection] = ()):
        instants = _instants(injected)
        self.added = server.gui.add_markdown(_injected_list(instants, injected))
        self._charts = [Curve(server, title, names, track.t, values, instants)
                        for (title, names), values in zip(_CHARTS, _values(track), strict=True)]
        with server.gui.add_folder('Joints'):
            self.joints = [server.gui.add_checkbox(name, True) for name in SHORT_NAMES]
        for joint in self.joints:
            joint.on_update(lambda _: self._select())

    def _select(self) -> None:
        shown = [joint.value for joint in self.joints]
        for chart, (_, names) in zip(self._charts, _CHARTS, strict=True):
            if names == SHORT_NAMES:
                chart.select(shown)

    def mark(self, row: int) -> None:
        """Put the mark of every chart at a row."""
        for chart in self._charts:
            chart.mark(row)

    def show(self, track: Track, injected: Sequence[Injection] = ()) -> None:
        """Draw another track, and what was added to its plant."""
        instants = _instants(injected)
        if (added := _injected_list(instants, injected)) != self.added.content:
            self.added.content = added
        for chart, values in zip(self._charts, _values(track), strict=True):
            chart.show(track.t, values, instants)


def _instants(injected: Sequence[Injection]) -> list[float]:
    return sorted({each.t for each in injected})


def _axes(lines: Mapping[int, float]) -> tuple[uplot.Axis, ...]:
    """Return both axes, and above a third with a dotted line at each numbered instant [s]."""
    axes = (uplot.Axis(stroke=MARK), uplot.Axis(stroke=MARK, size=62.0))
    if not lines:
        return axes
    return (*axes, uplot.Axis(
        scale='x', side=0, size=20.0, stroke=MARK, splits=tuple(lines.values()),
        values=tuple(map(str, lines)), ticks=uplot.Axis_Ticks(show=False),
        grid=uplot.Axis_Grid(stroke=MARK, width=1.0, dash=(3.0, 3.0))))


def _injected_list(instants: Sequence[float], injected: Sequence[Injection]) -> str:
    """Return Markdown that says what acts from each numbered line on; empty for nothing."""
    if not injected:
        return ''
    lines = [f'{i}. from {t:.4g} s: ' + '; '.join(each.text[:60] for each in injected
                                                   if each.t == t)
             for i, t in enumerate(instants, start=1)]
    return '\n'.join(['added to the plant\n', *lines])


_CHARTS = (
    ('Torque [N m]', SHORT_NAMES),
    ('Joint error [mrad]', SHORT_NAMES),
    ('Tool error [mm]', ('tool',)),
)


def _values(track: Track) -> tuple[np.ndarray, ...]:
    return track.effort, 1e3 * track.error, 1e3 * track.tool_error[:, None]
