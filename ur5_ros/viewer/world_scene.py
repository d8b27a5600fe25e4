"""What the arm touches, in a viser scene: the bodies of a world, and forces as arrows."""

import numpy as np
import viser

from ur5_ros.analysis.data.run import Run
from ur5_ros.cdr.contact_messages import ARROW_SCALE, ContactForce
from ur5_ros.config.worlds import NOTHING, Body, base_pose
from ur5_ros.model.rotations import quaternion_of

#: Colours of normal force and friction, as those of ``~/contacts``.
NORMAL, FRICTION = (31, 119, 180), (230, 97, 1)
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
        self._server = server
        world = NOTHING if run.sim is None else run.sim.world
        # base is base_link, the root of the scene, turned by Rz(pi)
        server.scene.add_frame('/world', show_axes=False, wxyz=(0.0, 0.0, 0.0, 1.0))
        self._free = []
        for body in world.bodies:
            frame = server.scene.add_frame(f'/world/{body.name}', show_axes=False)
            pose = base_pose(body, world.frame)
            frame.position, frame.wxyz = pose[:3, 3], _wxyz(quaternion_of(pose[:3, :3]))
            self._draw(f'/world/{body.name}/shape', body)
            if body.free:
                self._free.append(frame)
        self._objects = np.array([stamp for stamp, _ in run.objects], dtype=np.int64)
        self._poses = [poses for _, poses in run.objects]
        self._felt = np.array([stamp for stamp, _ in run.contact_forces], dtype=np.int64)
        self._forces = [contacts for _, contacts in run.contact_forces]
        self._first = int(run.stamp[0])

    def show(self, t: float) -> None:
        """Show the newest poses and forces at a time since the first state [s]."""
        stamp = self._first + round(t * 1e9)
        row = int(np.searchsorted(self._objects, stamp, side='right')) - 1
        if row >= 0:
            for frame, pose in zip(self._free, self._poses[row], strict=True):
                frame.position, frame.wxyz = pose[:3], _wxyz(pose[3:])
        row = int(np.searchsorted(self._felt, stamp, side='right')) - 1
        arrows = force_arrows(self._forces[row] if row >= 0 else [])
        self._server.scene.add_line_segments(
            '/world/forces', points=arrows[0], colors=arrows[1], thickness=0.004,
            visible=len(arrows[0]) > 0)

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


def force_arrows(contacts: list[ContactForce]) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the lines that stand for forces, 10 mm a newton, and their colours.

    Parameters
    ----------
    contacts : list of ContactForce
        Of one instant.

    Returns
    -------
    points : numpy.ndarray, shape (2 n, 2, 3)
        Begin and end of normal force and friction of each, in base [m].
    colours : numpy.ndarray, shape (2 n, 2, 3)
        Red, green, blue.

    """
    points = [[each.place, each.place + ARROW_SCALE * force]
              for each in contacts for force in (each.normal, each.lateral)]
    colours = [[colour, colour] for _ in contacts for colour in (NORMAL, FRICTION)]
    return (np.array(points, dtype=np.float32).reshape(-1, 2, 3),
            np.array(colours, dtype=np.uint8).reshape(-1, 2, 3))


def _wxyz(quaternion: np.ndarray) -> np.ndarray:
    return np.roll(quaternion, 1)
