"""One picture of a run: the arm with both tool paths, and three strips of curves below it."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ur5_ros.analysis.report import palette
from ur5_ros.analysis.report.palette import rgb
from ur5_ros.sim.camera import Camera
from ur5_ros.viewer.track import Track
from ur5_ros.viewer.world_track import WorldTrack, force_arrows

MEASURED, REFERENCE = rgb(palette.MEASURED), rgb(palette.REFERENCE)
COLOURS = tuple(map(rgb, palette.JOINT_COLOURS))
INK, FAINT, PAPER = (40, 40, 40), (205, 205, 205), (255, 255, 255)
FLOOR = (214, 217, 221)


class Frames:
    """
    Draws rows of a track.

    Parameters
    ----------
    track : Track
        The run.
    camera : Camera
        Takes the upper part of the picture.
    strips : int
        Height of the lower part [pixels].
    fine : int
        Pixels of the camera along each side of one of the picture; 2 makes edges smooth.
    world : WorldTrack, optional
        What stands around the arm, and the forces on it.

    """

    def __init__(self, track: Track, camera: Camera, strips: int, fine: int = 1,
                 world: WorldTrack | None = None):
        self._world = world
        self._track, self._camera, self._strips, self._fine = track, camera, strips, fine
        self._width, self._height = camera.width // fine, camera.height // fine
        self._measured = camera.pixels(track.tool) / fine
        self._reference = camera.pixels(track.tool_reference) / fine
        self._size = max(10, self._height // 34)
        self._font = ImageFont.load_default(self._size)
        self._ground = self._floor()
        self._charts = Image.new('RGB', (self._width, strips), PAPER)
        self._inside = []
        draw = ImageDraw.Draw(self._charts)
        columns = (('torque [N m]', track.effort), ('joint error [mrad]', 1e3 * track.error),
                   ('tool error [mm]', 1e3 * track.tool_error[:, None]))
        for i, (title, values) in enumerate(columns):
            self._inside.append(self._chart(draw, i, title, values))

    def frame(self, row: int) -> np.ndarray:
        """Return one row as an image (height, width, 3) of bytes."""
        track, width, height = self._track, self._width, self._height
        whole = Image.new('RGB', (width, height + self._strips), PAPER)
        whole.paste(self._ground, (0, 0))
        poses = None if self._world is None else self._world.poses(track.t[row])
        arm = Image.fromarray(self._camera.cutout(track.q[row], poses)).reduce(self._fine)
        whole.paste(arm, (0, 0), arm)
        draw = ImageDraw.Draw(whole)
        self._path(draw, self._reference, REFERENCE)
        self._path(draw, self._measured[:row + 1], MEASURED)
        self._forces(draw, track.t[row])
        text = f't = {track.t[row]:6.2f} s'
        if np.isfinite(track.tool_error[row]):
            text += f'    tool error {1e3 * track.tool_error[row]:.2f} mm'
        edge = height // 40
        draw.text((edge, edge), text, INK, self._font)
        line = 1.5 * self._size
        draw.text((edge, edge + line), 'reference', REFERENCE, self._font)
        draw.text((edge + 5 * self._size, edge + line), 'measured', MEASURED, self._font)
        for i, (name, colour) in enumerate(zip(palette.SHORT_NAMES, COLOURS, strict=True)):
            draw.text((width - edge, edge + i * line), name, colour, self._font,
                      anchor='ra')
        whole.paste(self._charts, (0, height))
        for left, top, right, bottom in self._inside:
            share = track.t[row] / max(track.t[-1], 1e-9)
            x = left + share * (right - left)
            draw.line([(x, height + top), (x, height + bottom)], INK, 1)
        return np.asarray(whole)

    def _forces(self, draw: ImageDraw.ImageDraw, t: float) -> None:
        """Draw the forces of contact, 10 mm a newton, normal and friction in their colours."""
        if self._world is None:
            return
        lines, colours = force_arrows(self._world.contacts(t))
        for line, colour in zip(lines, colours, strict=True):
            ends = self._camera.pixels(line * [-1.0, -1.0, 1.0]) / self._fine  # base_link
            draw.line([tuple(end) for end in ends.tolist()], tuple(colour[0].tolist()),
                      max(2, self._size // 5))

    def _floor(self) -> Image.Image:
        """Return the floor as the camera sees it, with squares of a quarter of a metre."""
        floor = Image.new('RGB', (self._width, self._height), PAPER)
        draw = ImageDraw.Draw(floor)
        lines = np.arange(-4, 5) * 0.25
        for at in lines:
            for ends in ([[at, -1, 0], [at, 1, 0]], [[-1, at, 0], [1, at, 0]]):
                spots = self._camera.pixels(np.array(ends, dtype=float)) / self._fine
                draw.line([tuple(spot) for spot in spots.tolist()], FLOOR, 1)
        return floor

    @staticmethod
    def _path(draw: ImageDraw.ImageDraw, points: np.ndarray, colour: tuple) -> None:
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) > 1:
            draw.line([tuple(point) for point in points.tolist()], colour, 2)

    def _chart(self, draw: ImageDraw.ImageDraw, i: int, title: str, values: np.ndarray) -> tuple:
        """Draw the curves of one strip; return its inside (left, top, right, bottom)."""
        size = self._size
        width = self._width / 3
        left, right = i * width + 3.2 * size, (i + 1) * width - 0.6 * size
        top, bottom = 1.8 * size, self._strips - 0.7 * size
        known = values[np.isfinite(values)]
        low, high = (known.min(), known.max()) if len(known) else (0.0, 1.0)
        low, high = min(low, 0.0), max(high, low + 1e-9, 0.0)
        draw.text((left, 0.3 * size), title, INK, self._font)
        for level in (low, 0.0, high):
            y = bottom - (level - low) / (high - low) * (bottom - top)
            draw.line([(left, y), (right, y)], FAINT, 1)
            if level == 0.0 or abs(level) > 0.15 * (high - low):
                draw.text((left - 0.3 * size, y), f'{level:.3g}', INK, self._font, anchor='rm')
        x = left + self._track.t / max(self._track.t[-1], 1e-9) * (right - left)
        for column, colour in zip(values.T, COLOURS, strict=False):
            good = np.isfinite(column)
            y = bottom - (column[good] - low) / (high - low) * (bottom - top)
            if good.sum() > 1:
                draw.line(np.c_[x[good], y].ravel().tolist(), colour, 1 + self._size // 18)
        return left, top, right, bottom
