"""What runs now, in the browser: the arm of /robot_description with its newest states."""

import time
from collections import deque

import numpy as np

from ur5_ros.analysis.injected import Injection, injected_by
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.nodes.listener import Listener, Sample
from ur5_ros.nodes.ros.diagnostics import network
from ur5_ros.viewer.arm_scene import MEASURED, REFERENCE
from ur5_ros.viewer.page import MARKS, Page, numbers
from ur5_ros.viewer.track import Track, number_frame, tool_positions, tree_of
from ur5_ros.viewer.urdf_tree import UrdfTree, parse_urdf

FRAME = 1 / 25
KEPT = 500
DESCRIPTION_TIMEOUT = 10.0


class LiveView:
    """
    The page of the running system; waits for the first joint state.

    ``port``: port on 127.0.0.1; the next free one where it is taken.

    """

    def __init__(self, port: int = 8080):
        self._listener = Listener()
        self.tree = self._described()
        self._samples: deque[Sample] = deque(maxlen=KEPT)
        self.injected: list[Injection] = []
        """What was added to the plant since the page was opened, at its stamp [s]."""
        self.page = Page(self.tree, _empty(), f'{self.tree.name or "robot"}, live', port,
                         controls='Colours')
        with self.page.controls:
            self.page.add_key()
        self.page.numbers.content = f'waiting for /joint_states ({network()})'
        self._drawn = 0.0

    @property
    def newest(self) -> Sample | None:
        """Return the newest sample; None before the first."""
        return self._samples[-1] if self._samples else None

    def serve(self) -> None:
        """Follow until interrupted."""
        try:
            while True:
                self.update()
                time.sleep(FRAME)
        except KeyboardInterrupt:
            pass
        finally:
            self.close()

    def update(self) -> bool:
        """Show the newest state; return whether there was one."""
        sample = self._listener.sample()
        if sample is None or not np.isfinite(sample.q).all():
            return False
        if self._samples and sample.t < self._samples[-1].t:
            self._samples.clear()  # another run
            self.injected.clear()
        self.injected += [Injection(t, text) for t, kind, values in self._listener.events()
                          if (text := injected_by(kind, values))]
        self._samples.append(sample)
        track = self._track()
        row = len(track.t) - 1
        self.page.arm.pose(track.q[row])
        self.page.numbers.content = numbers(track, row)
        if time.monotonic() - self._drawn > 0.2 and len(self._samples) > 1:
            self._drawn = time.monotonic()
            self.page.curves.show(track, self.injected[-MARKS:])
            self.page.arm.path('measured', track.tool, MEASURED)
            self.page.arm.path('reference', track.tool_reference, REFERENCE)
        return True

    def close(self) -> None:
        """Stop serving and leave the graph."""
        self.page.close()
        self._listener.close()

    def _described(self) -> UrdfTree:
        end = time.monotonic() + DESCRIPTION_TIMEOUT
        while time.monotonic() < end:
            text = self._listener.description()
            if text is not None:
                try:
                    return parse_urdf(text)
                except InputError:
                    self._listener.close()
                    raise
            time.sleep(0.05)
        print(f'waiting for /joint_states and /robot_description ({network()}); drawing a ur5',
              flush=True)
        return tree_of(load_arm('ur5'))

    def _track(self) -> Track:
        q = np.array([sample.q for sample in self._samples])
        reference = np.array([sample.reference for sample in self._samples])
        return Track(np.array([sample.t for sample in self._samples]), q,
                     np.array([sample.effort for sample in self._samples]), q - reference,
                     tool_positions(self.tree, q), tool_positions(self.tree, reference),
                     *number_frame(self.tree))


def _empty() -> Track:
    joints, point = np.full((1, 6), np.nan), np.full((1, 3), np.nan)
    return Track(np.zeros(1), joints, joints, joints, point, point)
