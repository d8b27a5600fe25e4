"""A recorded run in the browser: a timeline over arm, paths and curves."""

import math
import threading
import time
from typing import Any

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.injected import injections
from ur5_ros.cdr.contact_messages import FORCE_COLOURS
from ur5_ros.viewer.arm_scene import MEASURED, REFERENCE
from ur5_ros.viewer.curves import colour_key
from ur5_ros.viewer.page import MARKS, Page
from ur5_ros.viewer.track import arm_of, track, tree_of
from ur5_ros.viewer.world_scene import WorldScene
from ur5_ros.viewer.world_track import FORCE_NAMES
from ur5_ros.wording import run_title

FRAME = 1 / 25


class RecordedView:
    """
    The page of one run.

    ``port``: port on 127.0.0.1; the next free one where it is taken.

    """

    def __init__(self, run: Run, port: int = 8080):
        tree = tree_of(arm_of(run), run.sim.world if run.sim else None)
        self.track = track(run, tree)
        self.page = Page(tree, self.track, f'ur5 {run_title(run.folder, run.name)}', port,
                         injections(run)[:MARKS])
        self.page.arm.path('measured', self.track.tool, MEASURED)
        self.page.arm.path('reference', self.track.tool_reference, REFERENCE)
        self.world = WorldScene(self.page.server, run)
        end = float(self.track.t[-1])
        gui = self.page.server.gui
        with self.page.controls:
            self.time: Any = gui.add_slider('t [s]', 0.0, end, step=_step(end), initial_value=0.0)
            self.play = gui.add_button('Play')
            self.speed = gui.add_dropdown('Speed', ('0.25', '0.5', '1', '2', '5'),
                                          initial_value='1')
            self.page.add_key()
            if run.contact_forces:
                colours = {name: f'rgb{colour}' for name, colour in zip(
                    FORCE_NAMES, FORCE_COLOURS, strict=True)}
                gui.add_markdown(f'contact, 10 mm a newton: {colour_key(colours)}')
        self._playing = False
        self._lock = threading.Lock()
        self.time.on_update(lambda _: self._show())
        self.play.on_click(lambda _: self.play_or_pause())
        gui.add_command('Play or pause', hotkey='P').on_trigger(lambda _: self.play_or_pause())
        self._show()

    def serve(self) -> None:
        """Move the timeline while it plays, until interrupted."""
        last = time.monotonic()
        try:
            while True:
                time.sleep(FRAME)
                now = time.monotonic()
                self.advance(now - last)
                last = now
        except KeyboardInterrupt:
            pass
        finally:
            self.page.close()

    def advance(self, seconds: float) -> None:
        """Move the timeline by wall-clock seconds if it plays."""
        if not self._playing:
            return
        end = float(self.track.t[-1])
        t = self.time.value + seconds * float(self.speed.value)
        self.time.value = min(t, end)
        if t >= end:
            self.play_or_pause()

    def play_or_pause(self) -> None:
        """Start or stop the timeline; at its end, start again from the beginning."""
        self._playing = not self._playing
        if self._playing and self.time.value >= float(self.track.t[-1]) - 1e-9:
            self.time.value = 0.0
        self.play.label = 'Pause' if self._playing else 'Play'

    def _show(self) -> None:
        with self._lock:
            self.page.show(self.track, self.track.row(self.time.value))
            self.world.show(self.time.value)


def _step(end: float) -> float:
    """Return a round step of about a thousandth of the time [s]."""
    power = 10.0**math.floor(math.log10(end / 1000))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0)
                if factor * power >= end / 1000)
