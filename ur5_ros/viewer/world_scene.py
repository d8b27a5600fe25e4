"""What the arm touches, in a viser scene: the bodies of a world, and forces as arrows."""

import numpy as np
import viser

from ur5_ros.analysis.data.run import Run
from ur5_ros.config.worlds import Body
from ur5_ros.model.rotations import position_and_quaternion
from ur5_ros.viewer.world_track import WorldTrack, force_arrows

#: Edge of the square that stands for a plane [m].
_PLANE = 4.0


class WorldScene:
    """
    The bodies of a run's world and the forces on them; all in ``base``.

    Parameters
    ----------
    server : viser.ViserServer
        Where to draw.
    run : Run
        Whose world.

    """

    def __init__(self, server: viser.ViserServer, run: Run):
        self._server, self._track = server, WorldTrack(run)
        # base is base_link, the root of the scene, turned by Rz(pi)
        server.scene.add_frame('/world', show_axes=False, wxyz=(0.0, 0.0, 0.0, 1.0))
        self._frames = []
        for body in self._track.bodies:
            self._frames.append(server.scene.add_frame(f'/world/{body.name}', show_axes=False))
            self._draw(f'/world/{body.name}/shape', body)
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

    def _draw(self, path: str, body: Body) -> None:
        scene, colour = self._server.scene, np.array(body.colour)
        if body.shape == 'box':
            scene.add_box(path, dimensions=np.array(body.size), color=colour)
        elif body.shape == 'plane':
            scene.add_box(path, dimensions=(_PLANE, _PLANE, 1e-3), color=colour)
        elif body.shape == 'sphere':
            scene.add_icosphere(path, radius=body.radius, color=colour)
        elif body.shape == 'cylinder':
            scene.add_cylinder(path, radius=body.radius, height=body.length, color=colour)
