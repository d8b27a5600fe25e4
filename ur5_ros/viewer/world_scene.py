"""What the arm touches, in a viser scene: the bodies of a world, and forces as arrows."""

import numpy as np
import viser

from ur5_ros.analysis.data.run import Run
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.viewer.arm_scene import draw_visual
from ur5_ros.viewer.world_track import WorldTrack, force_arrows

#: Opacity of what stands fixed, so that it hides neither arm nor tool.
_VEIL = 0.5


class WorldScene:
    """The bodies of a run's world and the forces on them; all in ``base``."""

    def __init__(self, server: viser.ViserServer, run: Run):
        self._server, self._track = server, WorldTrack(run)
        # base is base_link, the root of the scene, turned by Rz(pi)
        server.scene.add_frame('/world', show_axes=False, wxyz=(0.0, 0.0, 0.0, 1.0))
        self._frames = []
        for body, visual in zip(self._track.bodies, self._track.visuals, strict=True):
            self._frames.append(server.scene.add_frame(f'/world/{body.name}', show_axes=False))
            draw_visual(server.scene, f'/world/{body.name}/shape', visual,
                        None if body.free else _VEIL)
        self.show(0.0)

    def show(self, t: float) -> None:
        """Show the newest poses and forces at a time since the first state [s]."""
        for frame, pose in zip(self._frames, self._track.poses(t), strict=True):
            frame.position, quaternion = position_and_quaternion(pose)
            frame.wxyz = np.roll(quaternion, 1)
        points, colours = force_arrows(self._track.contacts(t))
        self._server.scene.add_line_segments(
            '/world/forces', points=points, colors=colours, thickness=0.004,
            visible=len(points) > 0)
