"""A run as a picture or a video, made off screen: ``ur5 render``."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.report import palette
from ur5_ros.errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

    from ur5_ros.viewer.picture.frame import Frames

RATE = 25
GIF_RATE = 10
#: Colours of an animation that are taken from a frame; 33 more are those with a meaning.
GIF_COLOURS = 128
GIF_SECONDS = 8.0
#: Width and height of the arm's part, and height of the curves below it [pixels].
_SIZES = {'.png': ((1200, 800), 260), '.mp4': ((800, 540), 200), '.gif': ((560, 380), 150)}
KINDS = tuple(_SIZES)


def render(run: Path, out: Path, progress: Callable[[float], None] = lambda share: None,
           reading: Mapping[str, Any] | None = None) -> Path:
    """
    Draw a recorded run; see :func:`draw`.

    ``out``: file to write; must not exist.
    """
    out = Path(out)
    check_new_file(out, KINDS)
    _require_packages()
    from ur5_ros.analysis.data.load import load_run
    return draw(load_run(run, **(reading or {})), out, progress)


def draw(run: Run, out: Path, progress: Callable[[float], None] = lambda share: None) -> Path:
    """
    Draw a run.

    A ``.png`` shows the moment in the middle of the run, an ``.mp4`` the run in real time, a
    ``.gif`` the run in eight seconds at most.
    """
    from ur5_ros.analysis.injected import injections
    from ur5_ros.viewer.picture.frame import Frames
    from ur5_ros.viewer.stage import Stage
    from ur5_ros.viewer.track import track

    stage = Stage(run)
    rows = track(run, stage.tree)
    size, strips = _SIZES[out.suffix]
    frames = Frames(rows, stage, size, strips, 2, injections(run))
    if out.suffix == '.png':
        _picture(frames.frame(len(rows.t) // 2), out)
    elif out.suffix == '.mp4':
        _video(frames, _rows(rows.t, RATE, 1.0), out, progress)
    else:
        speed = max(1.0, float(rows.t[-1]) / GIF_SECONDS)
        _animation(frames, _rows(rows.t, GIF_RATE, speed), out, progress)
    return out


def check_new_file(out: Path, kinds: Sequence[str]) -> None:
    """Refuse a file that exists, an unknown ending, and a folder that is not there."""
    if out.suffix not in kinds:
        raise InputError(f'{out}: unknown ending; give one of: {", ".join(kinds)}')
    if out.exists():
        raise InputError(f'{out} exists; remove it or name another file')
    if not out.absolute().parent.is_dir():
        raise InputError(f'{out.absolute().parent}: no such folder; make it first')


def _require_packages() -> None:
    if find_spec('imageio_ffmpeg') is None or find_spec('PIL') is None:
        raise InputError('pictures need Pillow and imageio-ffmpeg; in the checkout: '
                         "make setup, or pip install '.[view]'")


def _rows(t: np.ndarray, rate: float, speed: float) -> np.ndarray:
    """Return the row to show in each frame."""
    times = np.arange(0.0, float(t[-1]) + 0.5 * speed / rate, speed / rate)
    return np.clip(np.searchsorted(t, times), 0, len(t) - 1)


def _drawn(frames: 'Frames', rows: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the pictures of rows in order, drawn on all processors."""
    batch = 2 * (os.cpu_count() or 1)
    with ThreadPoolExecutor() as pool:
        for first in range(0, len(rows), batch):
            yield from pool.map(frames.frame, rows[first:first + batch])


def _picture(frame: np.ndarray, out: Path) -> None:
    from PIL import Image
    Image.fromarray(frame).save(out)


def _video(frames: 'Frames', rows: np.ndarray, out: Path,
           progress: Callable[[float], None]) -> None:
    import imageio_ffmpeg
    height, width = frames.frame(rows[0]).shape[:2]
    writer = imageio_ffmpeg.write_frames(
        str(out), (width, height), fps=RATE, codec='libx264', quality=7,
        macro_block_size=2, ffmpeg_log_level='error')
    writer.send(None)
    try:
        for i, frame in enumerate(_drawn(frames, rows)):
            writer.send(np.ascontiguousarray(frame))
            progress((i + 1) / len(rows))
    finally:
        writer.close()


def _animation(frames: 'Frames', rows: np.ndarray, out: Path,
               progress: Callable[[float], None]) -> None:
    from PIL import Image
    pictures, colours = [], _colours(frames.frame(rows[len(rows) // 2]))
    for i, frame in enumerate(_drawn(frames, rows)):
        pictures.append(Image.fromarray(frame).quantize(
            palette=colours, dither=Image.Dither.NONE))
        progress((i + 1) / len(rows))
    pictures[0].save(out, save_all=True, append_images=pictures[1:], loop=0, optimize=True,
                     duration=round(1000 / GIF_RATE))


def _colours(frame: np.ndarray) -> 'Picture':
    """Return a picture with the colours of an animation: those of a frame, and all that name."""
    from PIL import Image
    named = np.array([palette.rgb(each) for each in (*palette.JOINT_COLOURS, palette.MEASURED,
                                             palette.REFERENCE, *palette.AXIS_COLOURS)])
    tints = [named, np.rint(0.6 * named + 0.4 * 255), np.rint(0.3 * named + 0.7 * 255)]
    used = np.array(Image.fromarray(frame).quantize(GIF_COLOURS).getpalette())
    every = np.concatenate([*tints, used.reshape(-1, 3)[:GIF_COLOURS]]).astype(int)
    picture = Image.new('P', (1, 1))
    picture.putpalette(np.concatenate([every, np.tile(every[-1], (256 - len(every), 1))])
                       .ravel().tolist())
    return picture
