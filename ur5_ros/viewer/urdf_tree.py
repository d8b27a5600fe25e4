"""A URDF as frames and primitive shapes: what a viewer needs of it."""

import math
import xml.etree.ElementTree as ElementTree
from typing import NamedTuple

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.rotations import rotation_about, rotation_of_rpy
from ur5_ros.wording import number_of

MAX_CHARACTERS = 20_000_000

#: Attributes that hold the size of each shape, and how many numbers are in each.
_SIZES = {'cylinder': {'radius': 1, 'length': 1}, 'sphere': {'radius': 1}, 'box': {'size': 3}}


class Visual(NamedTuple):
    """A cylinder, a box, a sphere or a mesh, placed in its link's frame."""

    kind: str
    """``cylinder``, ``sphere``, ``box`` or ``mesh``."""
    size: tuple[float, ...]
    """Radius and length, radius, or three edges [m]; empty for a mesh."""
    pose: np.ndarray
    """Pose in the link, shape (4, 4)."""
    colour: tuple[int, int, int]
    triangles: np.ndarray | None = None
    """Corners of a mesh [m], shape (n, 3, 3)."""


class Joint(NamedTuple):
    """A joint and the frame that it carries."""

    name: str
    parent: str
    child: str
    pose: np.ndarray
    """Pose of the child in the parent at zero, shape (4, 4)."""
    axis: np.ndarray
    """Axis of rotation in the child's frame, shape (3,); zeros for a fixed joint."""


class UrdfTree(NamedTuple):
    """Root link, joints from the root outwards, and shapes by link."""

    root: str
    joints: tuple[Joint, ...]
    visuals: dict[str, tuple[Visual, ...]]
    name: str = ''
    """Name of the robot."""


def parse_urdf(text: str) -> UrdfTree:
    """Return frames and primitive shapes of a URDF; meshes are left out."""
    if len(text) > MAX_CHARACTERS:
        raise InputError(f'robot description of {len(text)} characters; at most {MAX_CHARACTERS}')
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(f'robot description is not XML: {error}') from None
    colours = {material.get('name'): _colour(material) for material in robot.findall('material')}
    visuals = {_text(link, 'name'): tuple(_visuals(link, colours))
               for link in robot.findall('link')}
    joints = {joint.child: joint for joint in map(_joint, robot.findall('joint'))}
    roots = [name for name in visuals if name not in joints]
    if len(roots) != 1:
        raise InputError(f'robot description has {len(roots)} root links; one is needed')
    ordered: list[Joint] = []
    known = {roots[0]}
    while len(ordered) < len(joints):
        ready = [joint for joint in joints.values()
                 if joint.parent in known and joint.child not in known]
        if not ready:
            raise InputError('robot description has joints that no link carries')
        ordered += ready
        known |= {joint.child for joint in ready}
    return UrdfTree(roots[0], tuple(ordered), visuals, robot.get('name', ''))


def link_poses(tree: UrdfTree, angles: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """
    Return the pose of every link in the root.

    ``angles`` (...): angle of each moving joint [rad], by name; zero where it is missing.
    Returned: by link name, (..., 4, 4).
    """
    poses = {tree.root: np.eye(4)}
    for joint in tree.joints:
        angle = angles.get(joint.name)
        pose = poses[joint.parent] @ joint.pose
        poses[joint.child] = pose if angle is None else pose @ turn(joint.axis, angle)
    return poses


def turn(axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """Return the pose (..., 4, 4) of a rotation by ``angle`` [rad] about a unit ``axis``."""
    return _pose(rotation_about(axis, angle))


def _pose(rotation: np.ndarray) -> np.ndarray:
    pose = np.zeros((*rotation.shape[:-2], 4, 4))
    pose[..., :3, :3], pose[..., 3, 3] = rotation, 1.0
    return pose


def _joint(joint: ElementTree.Element) -> Joint:
    kind, axis = joint.get('type'), joint.find('axis')
    if kind in ('revolute', 'continuous'):
        direction = np.array(_numbers(axis.get('xyz') if axis is not None else '1 0 0', 3))
        direction = direction / np.linalg.norm(direction)
    else:
        direction = np.zeros(3)
    parent, child = (_text(_part(joint, name), 'link') for name in ('parent', 'child'))
    return Joint(_text(joint, 'name'), parent, child, _origin(joint), direction)


def _visuals(link: ElementTree.Element, colours: dict) -> list[Visual]:
    found = []
    for visual in link.findall('visual'):
        material = visual.find('material')
        colour = (180, 180, 185)
        if material is not None:
            colour = _colour(material) or colours.get(material.get('name')) or colour
        shape = next(iter(_part(visual, 'geometry')), None)
        if shape is not None and shape.tag in _SIZES:
            size = [number for name, count in _SIZES[shape.tag].items()
                    for number in _numbers(shape.get(name), count)]
            found.append(Visual(shape.tag, tuple(size), _origin(visual), colour))
    return found


def _part(element: ElementTree.Element, name: str) -> ElementTree.Element:
    """Return the element of this name inside another one."""
    part = element.find(name)
    if part is None:
        raise InputError(f'robot description: {element.tag} {element.get("name", "")!r} has no '
                         f'{name}')
    return part


def _text(element: ElementTree.Element, name: str) -> str:
    """Return an attribute that has to be there."""
    text = element.get(name)
    if text is None:
        raise InputError(f'robot description: a {element.tag} without {name}')
    return text


def _colour(material: ElementTree.Element) -> tuple[int, int, int] | None:
    colour = material.find('color')
    if colour is None:
        return None
    red, green, blue, _ = (round(255 * value) for value in _numbers(colour.get('rgba'), 4))
    return red, green, blue


def _origin(element: ElementTree.Element) -> np.ndarray:
    origin = element.find('origin')
    if origin is None:
        return np.eye(4)
    roll, pitch, yaw = _numbers(origin.get('rpy', '0 0 0'), 3)
    pose = _pose(rotation_of_rpy(roll, pitch, yaw))
    pose[:3, 3] = _numbers(origin.get('xyz', '0 0 0'), 3)
    return pose


def _numbers(text: str | None, count: int) -> list[float]:
    try:
        numbers = [float(word) for word in (text or '').split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise InputError(f'robot description: {text!r}; needed: {number_of(count, "number")}')
    return numbers
