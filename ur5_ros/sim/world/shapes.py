"""What touches: the capsules of the arm, the tool, and how a URDF writes them."""

from typing import NamedTuple

import numpy as np

from ur5_ros.config.worlds import Solid, base_pose
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.urdf_shapes import arm_shapes

#: Link that carries the tool.
TOOL_LINK = 'wrist_3_link'
#: Colour of the lids in :func:`~ur5_ros.sim.urdf_shapes.arm_shapes`: nothing touches them first.
_LID = 'cap_blue'


class Capsule(NamedTuple):
    """A cylinder with a half sphere on either end, in a link frame; a sphere if length is 0."""

    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    radius: float
    length: float
    """Of the cylinder alone [m]."""


def arm_capsules(arm: ArmParameters) -> dict[str, list[Capsule]]:
    """
    Return the capsules of each moving link, by link name.

    They lie within the tubes and housings that are drawn, with the same axes and radii.
    """
    found = {}
    for link, shapes in arm_shapes(arm).items():
        if link == 'base':  # it never moves; PyBullet would take the whole arm for static
            continue
        found[link] = [
            Capsule(shape.xyz, shape.rpy, min(shape.radius, shape.length / 2),
                    max(shape.length - 2 * shape.radius, 0.0))
            for shape in shapes if shape.colour != _LID]
    return found


def capsule_elements(capsule: Capsule, bare: bool) -> str:
    """
    Return the ``<collision>`` elements of a capsule.

    ``bare``: PyBullet's own element; elsewhere a cylinder and two spheres, which all URDF readers
    know.
    """
    if capsule.length == 0.0:
        return _collision(capsule.xyz, capsule.rpy, f'<sphere radius="{capsule.radius!r}"/>')
    size = f'radius="{capsule.radius!r}" length="{capsule.length!r}"'
    if bare:
        return _collision(capsule.xyz, capsule.rpy, f'<capsule {size}/>')
    along = _z_axis(capsule.rpy) * capsule.length / 2
    ends = [tuple(float(x) for x in capsule.xyz + sign * along) for sign in (-1.0, 1.0)]
    sphere = f'<sphere radius="{capsule.radius!r}"/>'
    return (_collision(capsule.xyz, capsule.rpy, f'<cylinder {size}/>')
            + ''.join(_collision(end, (0.0, 0.0, 0.0), sphere) for end in ends))


def tool_elements(tool: list[Solid], tag: str) -> str:
    """Return the ``<collision>`` or ``<visual>`` elements of a tool, in ``tool0``."""
    return ''.join(_element(tag, tuple(solid.position), tuple(np.deg2rad(solid.rpy_degrees)),
                            _geometry(solid)) for solid in tool)


def _geometry(solid: Solid) -> str:
    if solid.shape == 'sphere':
        return f'<sphere radius="{solid.radius!r}"/>'
    if solid.shape == 'cylinder':
        return f'<cylinder radius="{solid.radius!r}" length="{solid.length!r}"/>'
    return f'<box size="{" ".join(map(repr, solid.size))}"/>'


def _collision(xyz: tuple, rpy: tuple, geometry: str) -> str:
    return _element('collision', xyz, rpy, geometry)


def _element(tag: str, xyz: tuple, rpy: tuple, geometry: str) -> str:
    material = '<material name="joint_dark"/>' if tag == 'visual' else ''
    place = f'xyz="{" ".join(f"{x!r}" for x in map(float, xyz))}"'
    turn = f'rpy="{" ".join(f"{x!r}" for x in map(float, rpy))}"'
    return (f'    <{tag}>\n      <origin {place} {turn}/>\n'
            f'      <geometry>{geometry}</geometry>{material}\n    </{tag}>\n')


def _z_axis(rpy: tuple[float, float, float]) -> np.ndarray:
    turned = Solid(shape='sphere', rpy_degrees=[float(np.rad2deg(angle)) for angle in rpy])
    return base_pose(turned)[:3, 2]
