"""The bodies of a world in PyBullet, which finds where they touch and solves nothing."""

from struct import pack

import numpy as np

from ur5_ros.config.worlds import Body, World, base_pose
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.sim.pybullet_import import pybullet
from ur5_ros.sim.urdf import LINK_NAMES
from ur5_ros.sim.world.contact_rows import FIRST_BODY, POINT

#: Stiffness and so on of the arm and its tool: what is written for a body is that of the pair.
_ARM = (1.0, 1.0, 0.0, 0.0)
#: Links that are nearer to each other on the chain do not touch.
_SELF_CONTACT_LINKS = 3

#: No contact at all.
NO_POINTS = np.zeros((0, POINT))


class BulletScene:
    """The bodies of a world beside an arm, in the arm's PyBullet world."""

    def __init__(self, world: World):
        self.world = world
        free = [body for body in world.bodies if body.free]
        self.names = [*LINK_NAMES, *(body.name for body in free)]
        """Names by body index; those of fixed bodies are looked up by :meth:`name`."""
        self._free = [body.name for body in free]

    def build(self, client: int, arm: int) -> None:
        """Add the bodies to a PyBullet world; the cache of contacts is empty then."""
        self._client, self._arm = client, arm
        self._pairs: dict[tuple[int, int, int, int], tuple] = {}
        self._bodies = {self._create(body): body for body in self.world.bodies}
        number = {body.name: key for key, body in self._bodies.items()}
        self._moving = [number[name] for name in self._free]
        if self.world.self_contact:
            self._keep_neighbours_apart()

    def points(self) -> tuple[np.ndarray, list[tuple[str, str]]]:
        """
        Return where bodies touch or soon will, in the present poses.

        Returned: ``points`` (n, POINT): rows as ``contact_kernel`` lays them out.
        """
        pybullet.performCollisionDetection(self._client)
        rows: list[float] = []
        pairs: list[tuple[str, str]] = []
        known = self._pairs.get
        for point in pybullet.getContactPoints(physicsClientId=self._client):
            ends = point[1:5]
            first, second, properties, names = known(ends) or self._pair(*ends)
            if first >= 0 or second >= 0:
                rows += first, second, *point[6], *point[7], point[8], *properties
                pairs.append(names)
        if not pairs:
            return NO_POINTS, pairs
        return np.ndarray((len(pairs), POINT), buffer=pack(f'{len(rows)}d', *rows)), pairs

    def move(self, poses: np.ndarray) -> None:
        """Put the free bodies at positions [m] and quaternions (x, y, z, w), shape (n, 7)."""
        for body, pose in zip(self._moving, poses.tolist(), strict=True):
            pybullet.resetBasePositionAndOrientation(body, pose[:3], pose[3:], self._client)

    def _pair(self, a: int, b: int, link_a: int, link_b: int) -> tuple:
        """Return indices, common properties and names of a pair of PyBullet's bodies."""
        first, second = self._index(a, link_a), self._index(b, link_b)
        one, other = self._properties(a), self._properties(b)
        stiffness = [k for k in (one[2], other[2]) if k > 0.0]
        properties = (one[0] * other[0], one[1] * other[1],
                      1.0 / sum(1.0 / k for k in stiffness) if stiffness else 0.0,
                      one[3] + other[3])
        names = (self._name(a, link_a), self._name(b, link_b))
        pair = self._pairs[a, b, link_a, link_b] = (first, second, properties, names)
        return pair

    def _index(self, body: int, link: int) -> int:
        if body == self._arm:
            return link
        name = self._bodies[body].name
        return FIRST_BODY + self._free.index(name) if name in self._free else -1

    def _name(self, body: int, link: int) -> str:
        if body != self._arm:
            return self._bodies[body].name
        return LINK_NAMES[link] if link >= 0 else 'base'

    def _properties(self, body: int) -> tuple[float, float, float, float]:
        if body == self._arm:
            return _ARM
        each = self._bodies[body]
        return each.friction, each.restitution, each.stiffness, each.damping

    def _create(self, body: Body) -> int:
        pose, client = base_pose(body, self.world.frame), self._client
        try:
            shape = pybullet.createCollisionShape(physicsClientId=client, **_shape(body))
            number = pybullet.createMultiBody(
                body.mass, shape, basePosition=pose[:3, 3].tolist(),
                baseOrientation=quaternion_of(pose[:3, :3]).tolist(), physicsClientId=client)
        except pybullet.error as error:
            what = f'mesh {body.file}' if body.file else f'shape {body.shape}'
            raise InputError(f'world {self.world.name}: body {body.name}: {what} cannot be read '
                             f'({error}); give an OBJ or STL file with faces') from None
        pybullet.changeVisualShape(number, -1, rgbaColor=[*body.colour, 1.0],
                                   physicsClientId=client)
        return number

    def _keep_neighbours_apart(self) -> None:
        for i in range(len(LINK_NAMES)):
            for j in range(i, len(LINK_NAMES)):
                touch = int(j - i >= _SELF_CONTACT_LINKS)
                pybullet.setCollisionFilterPair(self._arm, self._arm, i, j, touch,
                                                physicsClientId=self._client)


def _shape(body: Body) -> dict:
    """Return the arguments of createCollisionShape."""
    if body.shape == 'plane':
        return {'shapeType': pybullet.GEOM_PLANE, 'planeNormal': [0.0, 0.0, 1.0]}
    if body.shape == 'box':
        return {'shapeType': pybullet.GEOM_BOX, 'halfExtents': [edge / 2 for edge in body.size]}
    if body.shape == 'sphere':
        return {'shapeType': pybullet.GEOM_SPHERE, 'radius': body.radius}
    if body.shape == 'cylinder':
        return {'shapeType': pybullet.GEOM_CYLINDER, 'radius': body.radius,
                'height': body.length}
    return {'shapeType': pybullet.GEOM_MESH, 'fileName': body.file,
            'flags': 0 if body.free else pybullet.GEOM_FORCE_CONCAVE_TRIMESH}
