"""What the arm touches over a run: bodies, their poses, and forces as arrows; all in ``base``."""

from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.cdr.contact_messages import ARROW_SCALE, FORCE_COLOURS, ContactForce
from ur5_ros.config.worlds import EMPTY_WORLD, Body, base_pose
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import rotation_of_quaternion
from ur5_ros.viewer.urdf_tree import Visual

#: What the colours of forces stand for.
FORCE_NAMES = ('normal force', 'friction')
#: Edges of the plate that stands for a plane [m].
_PLANE = (4.0, 4.0, 1e-3)


class WorldTrack:
    """The bodies of a run's world, and the recorded poses and forces by time."""

    def __init__(self, run: Run):
        world = EMPTY_WORLD if run.sim is None else run.sim.world
        self.bodies = world.bodies
        """What stands there; :meth:`poses` has their order."""
        self.visuals = [body_visual(body) for body in world.bodies]
        """What they look like, each in its own frame."""
        self._start = np.array([base_pose(body, world.frame)
                                for body in world.bodies]).reshape(-1, 4, 4)
        self._free = [i for i, body in enumerate(world.bodies) if body.free]
        self._objects = np.array([stamp for stamp, _ in run.objects], dtype=np.int64)
        self._poses = [poses for _, poses in run.objects]
        self._felt = np.array([stamp for stamp, _ in run.contact_forces], dtype=np.int64)
        self._forces = [contacts for _, contacts in run.contact_forces]
        self._first = int(run.stamp[0])

    def poses(self, t: float) -> np.ndarray:
        """Return the newest poses at a time since the first state [s], shape (n, 4, 4)."""
        poses, row = self._start.copy(), self._row(self._objects, t)
        if row >= 0:
            for i, pose in zip(self._free, self._poses[row], strict=True):
                poses[i, :3, :3] = rotation_of_quaternion(pose[3:])
                poses[i, :3, 3] = pose[:3]
        return poses

    def contacts(self, t: float) -> list[ContactForce]:
        """Return the newest forces at a time since the first state [s]."""
        row = self._row(self._felt, t)
        return self._forces[row] if row >= 0 else []

    def _row(self, stamps: np.ndarray, t: float) -> int:
        return int(np.searchsorted(stamps, self._first + round(t * 1e9), side='right')) - 1


def body_visual(body: Body) -> Visual:
    """Return what a body of a world looks like."""
    red, green, blue = (round(255 * share) for share in body.colour)
    kind, size, triangles = body.shape, tuple(body.size), None
    if kind == 'plane':
        kind, size = 'box', _PLANE
    elif kind == 'sphere':
        size = (body.radius,)
    elif kind == 'cylinder':
        size = (body.radius, body.length)
    elif kind == 'mesh':
        triangles = _triangles(body.file)
    return Visual(kind, size, np.eye(4), (red, green, blue), triangles)


def _triangles(path: str) -> np.ndarray:
    """Return the corners of a mesh file (n, 3, 3); none where the file is gone."""
    import trimesh
    if not Path(path).is_file():  # a bag is read on another machine
        return np.zeros((0, 3, 3))
    try:
        mesh = trimesh.load_mesh(path)
    except Exception as error:
        raise InputError(f'{path}: this mesh cannot be read: {error}') from None
    return np.asarray(mesh.triangles, dtype=float)


def force_arrows(contacts: list[ContactForce]) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the lines that stand for forces, 10 mm a newton, and their colours.

    Returned: ``points`` (2 n, 2, 3): begin and end of normal force and friction of each, in base
    [m]; ``colours`` (2 n, 2, 3): red, green, blue.
    """
    points = [[each.place, each.place + ARROW_SCALE * force]
              for each in contacts for force in (each.normal, each.lateral)]
    colours = [[colour, colour] for _ in contacts for colour in FORCE_COLOURS]
    return (np.array(points, dtype=np.float32).reshape(-1, 2, 3),
            np.array(colours, dtype=np.uint8).reshape(-1, 2, 3))
