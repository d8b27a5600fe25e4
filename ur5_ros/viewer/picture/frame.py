"""One picture of a run: the arm in its world with both tool paths, and curves below it."""

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ur5_ros.analysis.injected import Injection
from ur5_ros.analysis.report import palette
from ur5_ros.analysis.report.palette import rgb
from ur5_ros.cdr.contact_messages import FORCE_COLOURS
from ur5_ros.viewer.picture.camera import Camera
from ur5_ros.viewer.picture.ray_caster import Picture, cast, seen_through
from ur5_ros.viewer.picture.strips import INK, PAPER, SOFT, Strips
from ur5_ros.viewer.stage import Stage
from ur5_ros.viewer.track import Track
from ur5_ros.viewer.world_track import FORCE_NAMES

MEASURED, REFERENCE = rgb(palette.MEASURED), rgb(palette.REFERENCE)
COLOURS = tuple(map(rgb, palette.JOINT_COLOURS))
#: Red, green and blue of the axes x, y and z.
AXES = tuple(map(rgb, palette.AXIS_COLOURS))
_GRID, _HALF, _CELL = (206, 210, 215), 1.5, 0.25
#: How dark a shadow makes the floor.
_SHADOW = 0.14
#: What a line loses of its colour behind a body.
_BEHIND = 0.72


class Frames:
    """
    Draws rows of a track.

    ``size``: width and height of the upper part of the picture [pixels]; ``strips``: height of the
    lower part [pixels]; ``fine``: pixels that are drawn along each side of one of the picture; 2
    makes edges smooth.

    """

    def __init__(self, track: Track, stage: Stage, size: tuple[int, int], strips: int,
                 fine: int = 2, injected: Sequence[Injection] = ()):
        self._track, self._stage, self._fine = track, stage, fine
        self._width, self._height = size
        self.camera = Camera(fine * size[0], fine * size[1], stage.reach)
        self._size = max(10, size[1] // 36)
        self._font = ImageFont.load_default(self._size)
        self._strips = Strips(track, size[0], strips, self._size, injected)
        self._injected = injected
        self._key = [(name, colour) for name, colour, points in (
            ('measured', MEASURED, track.tool), ('reference', REFERENCE, track.tool_reference))
            if np.isfinite(points).any()]
        if stage.has_forces:
            self._key += zip(FORCE_NAMES, FORCE_COLOURS, strict=True)
        self._ground = self._grid()

    def frame(self, row: int) -> np.ndarray:
        """Return one row as an image (height, width, 3) of bytes."""
        t = float(self._track.t[row])
        picture, hides = self._cast(row, t)
        scene = self._scene(picture)
        lines = _Lines(scene, self.camera, hides)
        lines.path(self._track.tool_reference, REFERENCE)
        lines.path(self._track.tool[:row + 1], MEASURED)
        frames = self._stage.frames(self._track.q[row])
        for _, pose, length in frames:
            for axis, colour in enumerate(AXES):
                lines.path(np.stack([pose[:3, 3], pose[:3, 3] + length * pose[:3, axis]]), colour,
                           1.6)
        for points, colours in zip(*self._stage.forces(t), strict=True):
            lines.path(points, tuple(colours[0].tolist()), 2.5, through=True)
        whole = Image.new('RGB', (self._width, self._height + self._strips.picture.height), PAPER)
        whole.paste(scene.reduce(self._fine), (0, 0))
        self._words(ImageDraw.Draw(whole), row, frames)
        whole.paste(self._strips.marked(row), (0, self._height))
        return np.asarray(whole)

    def _cast(self, row: int, t: float) -> tuple[Picture, np.ndarray]:
        """
        Return what the camera sees, and the depth of what hides lines.

        Where the world hides the arm, the arm shows through; the world hides no line.
        """
        links, world = self._stage.arm(self._track.q[row]), self._stage.world(t)
        arm = cast(self.camera, links, self._stage.floor)
        if not world:
            return arm, arm.depth
        return seen_through(cast(self.camera, links + world, self._stage.floor), arm), arm.depth

    def _grid(self) -> np.ndarray:
        """Return the floor with squares of a quarter of a metre."""
        ground = Image.new('RGB', (self.camera.width, self.camera.height), PAPER)
        draw = ImageDraw.Draw(ground)
        floor = self._stage.floor
        for at in np.arange(-_HALF, _HALF + 1e-9, _CELL):
            for ends in ([[at, -_HALF, floor], [at, _HALF, floor]],
                         [[-_HALF, at, floor], [_HALF, at, floor]]):
                line = np.linspace(np.array(ends[0]), np.array(ends[1]), 60)
                ahead = self.camera.depth(line) > 0.1
                spots = self.camera.pixels(line[ahead])
                draw.line([tuple(spot) for spot in spots.tolist()], _GRID, self._fine)
        return np.asarray(ground)

    def _scene(self, picture: Picture) -> Image.Image:
        """Return the floor, shadows on it, and the bodies."""
        colour = self._ground.copy()
        dark = picture.shadow > 0
        colour[dark] = (1.0 - _SHADOW) * colour[dark]
        bodies = np.isfinite(picture.depth)
        colour[bodies] = picture.colour[bodies]
        return Image.fromarray(colour)

    def _words(self, draw: ImageDraw.ImageDraw, row: int, frames: Sequence) -> None:
        """Write what is shown: time, error, legends, and the names of frames and axes."""
        track, width, size = self._track, self._width, self._size
        edge, line = self._height // 40, 1.5 * size
        text = f't = {track.t[row]:.2f} s'
        if np.isfinite(track.tool_error[row]):
            text += f'    tool error {1e3 * track.tool_error[row]:.2f} mm'
        self._write(draw, (edge, edge), text, INK)
        x = float(edge)
        for name, colour in self._key:
            self._write(draw, (x, edge + line), name, colour)
            x += draw.textlength(name, self._font) + 1.2 * size
        added = [each.text for each in self._injected if each.t <= track.t[row]]
        for i, words in enumerate(added[-4:]):
            self._write(draw, (edge, edge + (2 + i) * line), words[:60], SOFT)
        for i, (name, colour) in enumerate(zip(palette.SHORT_NAMES, COLOURS, strict=True)):
            self._write(draw, (width - edge, edge + i * line), name, colour, anchor='ra')
        for name, pose, length in frames:
            ends = pose[:3, 3] + 1.25 * length * pose[:3, :3].T
            places = self.camera.pixels(np.vstack([ends, pose[:3, 3]])) / self._fine
            for axis, (place, colour) in enumerate(zip(places, AXES, strict=False)):
                self._write(draw, (place[0], place[1]), 'xyz'[axis], colour, anchor='mm')
            self._write(draw, (places[3, 0], places[3, 1] + 0.9 * size), name, SOFT,
                      anchor='ma')

    def _write(self, draw: ImageDraw.ImageDraw, place: tuple[float, float], text: str,
               colour: tuple[int, int, int], anchor: str = 'la') -> None:
        """Write with an edge of paper, to be read before a body too."""
        draw.text(place, text, colour, self._font, anchor, stroke_width=max(1, self._size // 10),
                  stroke_fill=PAPER)


class _Lines:
    """Draws lines into a scene; what is behind a body is faint."""

    def __init__(self, scene: Image.Image, camera: Camera, depth: np.ndarray):
        self._draw, self._camera = ImageDraw.Draw(scene), camera
        self._depth, self._thick = depth, 2.0 * camera.height / 800

    def path(self, points: np.ndarray, colour: tuple[int, int, int], thick: float = 1.0,
             through: bool = False) -> None:
        """Draw a line through points (n, 3) [m]; ``through`` bodies it is not faint."""
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) < 2:
            return
        points = _dense(points)
        spots = self._camera.pixels(points)
        place = np.floor(spots).astype(int)
        x = np.clip(place[:, 0], 0, self._camera.width - 1)
        y = np.clip(place[:, 1], 0, self._camera.height - 1)
        # a tool's own path touches its surface: a few millimetres decide nothing
        seen = through | (self._camera.depth(points) < self._depth[y, x] + 0.006)
        faint = tuple(round(_BEHIND * 255 + (1 - _BEHIND) * each) for each in colour)
        cuts = np.nonzero(np.diff(seen))[0] + 1
        for runs, tone in ((False, faint), (True, colour)):
            for part in np.split(np.arange(len(points)), cuts):
                if seen[part[0]] == runs:
                    part = np.append(part, min(part[-1] + 1, len(points) - 1))
                    self._draw.line([tuple(spot) for spot in spots[part].tolist()], tone,
                                    max(1, round(thick * self._thick)), joint='curve')


def _dense(points: np.ndarray, step: float = 0.01) -> np.ndarray:
    """Return points along the same way, at most a step apart [m]."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    places = np.unique(np.append(along, np.arange(0.0, along[-1], step)))
    return np.stack([np.interp(places, along, column) for column in points.T], axis=-1)
