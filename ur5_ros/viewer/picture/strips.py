"""The curves below a picture: one chart a quantity over time, with a mark that moves."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ur5_ros.analysis.injected import Injection
from ur5_ros.analysis.report.palette import JOINT_COLOURS, MEASURED, rgb
from ur5_ros.viewer.track import Track

INK, SOFT, FAINT, PAPER = (40, 44, 50), (105, 112, 120), (222, 225, 229), (255, 255, 255)
#: Curves are drawn at so many times their size, and made smaller: smooth lines.
_FINE = 3


class Box(NamedTuple):
    """The inside of a chart [pixels]."""

    left: float
    top: float
    right: float
    bottom: float


class Strips:
    """
    Torque, joint error and tool error side by side; quantities that a run lacks have no chart.

    ``width``, ``height``: size of all charts together [pixels]; ``size``: of the letters [pixels].

    """

    def __init__(self, track: Track, width: int, height: int, size: int,
                 injected: Sequence[Injection] = ()):
        self._track, self._size, self._injected = track, size, injected
        self._font = ImageFont.load_default(size)
        charts = [each for each in (
            ('torque [N m]', track.effort, JOINT_COLOURS),
            ('joint error [mrad]', 1e3 * track.error, JOINT_COLOURS),
            ('tool error [mm]', 1e3 * track.tool_error[:, None], (MEASURED,)))
            if np.isfinite(each[1]).any()]
        self._end = max(float(track.t[-1]), 1e-9)
        self.picture = Image.new('RGB', (width, height), PAPER)
        self._boxes = []
        for i, chart in enumerate(charts):
            left = i * width / len(charts)
            self._boxes.append(self._chart(left, width / len(charts), height, *chart))

    def marked(self, row: int) -> Image.Image:
        """Return the charts with a line at a row of the track."""
        picture = self.picture.copy()
        draw = ImageDraw.Draw(picture)
        for box in self._boxes:
            x = round(box.left + self._track.t[row] / self._end * (box.right - box.left))
            draw.line([(x, box.top), (x, box.bottom)], INK, max(1, self._size // 12))
        return picture

    def _chart(self, begin: float, width: float, height: int, title: str, values: np.ndarray,
               colours: Sequence[str]) -> Box:
        size = self._size
        levels = ticks(*_range(values))
        low, high = levels[0], levels[-1]
        draw = ImageDraw.Draw(self.picture)
        room = max(draw.textlength(_text(level), self._font) for level in levels)
        box = Box(begin + room + size, 1.9 * size, begin + width - 1.1 * size, height - 2.9 * size)

        def y(value):
            return box.bottom - (value - low) / (high - low) * (box.bottom - box.top)

        draw.text((box.left, 0.4 * size), title, INK, self._font)
        for level in levels:
            draw.line([(box.left, y(level)), (box.right, y(level))], FAINT, 1)
            draw.text((box.left - 0.4 * size, y(level)), _text(level), SOFT, self._font, 'rm')
        times = [time for time in ticks(0.0, self._end, 5) if time <= 1.01 * self._end]
        for time in times:
            x = box.left + min(time / self._end, 1.0) * (box.right - box.left)
            draw.line([(x, box.bottom), (x, box.bottom + 0.3 * size)], SOFT, 1)
            draw.text((x, box.bottom + 0.4 * size), _text(time), SOFT, self._font, 'ma')
        draw.text((box.right, box.bottom + 1.6 * size), 'time [s]', SOFT, self._font, 'ra')
        self._curves(box, values, colours, y)
        self._marks(draw, box)
        return box

    def _curves(self, box: Box, values: np.ndarray, colours: Sequence[str], y) -> None:
        """Draw the curves large, and put them into the picture smaller."""
        area = tuple(round(each) for each in box)
        wide, tall = area[2] - area[0] + 1, area[3] - area[1] + 1
        large = self.picture.crop((area[0], area[1], area[0] + wide, area[1] + tall)).resize(
            (_FINE * wide, _FINE * tall), Image.Resampling.NEAREST)
        draw = ImageDraw.Draw(large)
        x = self._track.t / self._end * (box.right - box.left)
        thick = max(2, round(_FINE * self._size / 9))
        for column, colour in zip(values.T, colours, strict=True):
            good = np.isfinite(column)
            if good.sum() > 1:
                points = np.c_[x[good], y(column[good]) - area[1]] * _FINE
                draw.line([tuple(point) for point in points.tolist()], rgb(colour), thick,
                          joint='curve')
        self.picture.paste(large.resize((wide, tall), Image.Resampling.BOX),
                           (area[0], area[1]))

    def _marks(self, draw: ImageDraw.ImageDraw, box: Box) -> None:
        for each in self._injected:
            x = box.left + each.t / self._end * (box.right - box.left)
            for top in np.arange(box.top, box.bottom, 6.0):
                draw.line([(x, top), (x, min(top + 3.0, box.bottom))], SOFT, 1)


def ticks(low: float, high: float, most: int = 4) -> list[float]:
    """
    Return round numbers that hold a range between them.

    ``low``, ``high``: the range; ``high`` is greater.
    """
    rough = (high - low) / most
    power = 10.0**math.floor(math.log10(rough))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0)
                if factor * power >= rough * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [round(each * step, 12) for each in range(first, last + 1)]


def _range(values: np.ndarray) -> tuple[float, float]:
    """Return the least and the greatest value, zero among them, never the same."""
    known = values[np.isfinite(values)]
    low, high = min(float(known.min()), 0.0), max(float(known.max()), 0.0)
    return (low, high) if high - low > 1e-6 else (low, low + 1e-6)


def _text(value: float) -> str:
    return f'{value:.4g}'
