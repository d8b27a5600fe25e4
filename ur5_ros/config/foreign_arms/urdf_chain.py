"""A URDF parsed, and the chain of its six revolute joints."""

import re
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.calibration import transform
from ur5_ros.signals import JOINT_NAMES

#: A right angle that was rounded has so many digits behind its point, or more.
FEWEST_DIGITS = 2

#: Largest URDF [bytes].
MAX_BYTES = 20 << 20


class UrdfJoint(NamedTuple):
    """A joint as the URDF has it."""

    name: str
    kind: str
    parent: str
    child: str
    origin: np.ndarray
    axis: np.ndarray
    limit: dict[str, str]


class UrdfRobot(NamedTuple):
    """A URDF: its joints, and its links as XML."""

    name: str
    joints: list[UrdfJoint]
    links: dict[str, Any]


def parse_urdf(path: Path, data: bytes | None = None) -> UrdfRobot:
    """Return the joints and links of a URDF; InputError if it is none; ``data``: its text."""
    if data is None:
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(f'{path}: cannot be read: {error.strerror}') from None
    if len(data) > MAX_BYTES:
        raise InputError(f'{path}: {len(data)} bytes; at most {MAX_BYTES} are read')
    ascii_only = data.replace(b'\0', b'')  # whatever the encoding
    if b'<!DOCTYPE' in ascii_only or b'<!ENTITY' in ascii_only:
        raise InputError(f'{path}: declares entities, which no URDF needs; remove them')
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f'{path}: not XML: {error}') from None
    if root.tag != 'robot':
        raise InputError(f'{path}: not a URDF: its root is <{root.tag[:40]}>, not <robot>')
    if any('xacro' in each.tag for each in root.iter()) or b'${' in ascii_only:
        raise InputError(f'{path}: a xacro file; expand it before: xacro {path.name} > arm.urdf')
    joints = [_joint(each, path) for each in root.findall('joint')]
    links = {str(each.get('name')): each for each in root.findall('link')}
    name = re.sub(r'[^A-Za-z0-9_]', '_', root.get('name') or 'arm')
    return UrdfRobot(name, joints, links)


def _joint(element: Any, path: Path) -> UrdfJoint:
    name = str(element.get('name'))
    parent, child = element.find('parent'), element.find('child')
    if parent is None or child is None:
        raise InputError(f'{path}: joint {name!r} has no parent or no child')
    axis_element, limit = element.find('axis'), element.find('limit')
    axis = _three(axis_element, 'xyz', '1 0 0', f'{path}: joint {name!r}')
    length = float(np.linalg.norm(axis))
    if not length:
        raise InputError(f'{path}: joint {name!r}: its axis is 0 0 0; give a direction')
    return UrdfJoint(
        name, str(element.get('type')), str(parent.get('link')), str(child.get('link')),
        origin_of(element, f'{path}: joint {name!r}'), axis / length,
        {} if limit is None else dict(limit.attrib))


def _three(element: Any, key: str, default: str, where: str) -> np.ndarray:
    text = default if element is None else element.get(key, default)
    try:
        values = np.array([float(part) for part in text.split()])
    except ValueError:
        values = np.zeros(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise InputError(f'{where}: {key}={text[:60]!r}; give three finite numbers')
    return values


def origin_of(element: Any, where: str) -> np.ndarray:
    """Return the transform of an element's <origin>."""
    origin = element.find('origin')
    rpy = _three(origin, 'rpy', '0 0 0', where)
    if origin is not None:
        rpy = np.array([_right_angle(angle, text) for angle, text in
                        zip(rpy, origin.get('rpy', '0 0 0').split(), strict=True)])
    return transform(_three(origin, 'xyz', '0 0 0', where), rpy)


def _right_angle(angle: float, text: str) -> float:
    """Return the multiple of a right angle that was written with a few digits, as 1.57 or 3.14."""
    digits = len(text.partition('.')[2])
    nearest = round(angle / (np.pi / 2)) * np.pi / 2
    rounded = text.lstrip('+-').replace('.', '').isdecimal() and digits >= FEWEST_DIGITS and (
        abs(angle - nearest) < 10.0**-digits)
    return nearest if rounded else angle


def six_joints(robot: UrdfRobot, path: Path, prefix: str | None = None) -> list[UrdfJoint]:
    """
    Return the six joints of the arm, with the fixed ones between them taken in.

    ``prefix``: text before their names, where the robot may have several arms.
    """
    moving = [joint for joint in robot.joints if joint.kind in ('revolute', 'continuous')]
    named = [joint for joint in moving if (
        joint.name.endswith(JOINT_NAMES) if prefix is None
        else joint.name in [prefix + name for name in JOINT_NAMES])]
    if len(named) > 6:
        raise InputError(f'{path}: {len(named)} joints of the six names: several arms; give the '
                         'URDF of one')
    arm = named if len(named) == 6 else moving
    if len(arm) != 6:
        raise InputError(f'{path}: {len(moving)} revolute joints, of the names '
                         f'{", ".join(joint.name for joint in moving)[:120] or "-"}; an arm of '
                         'the UR family has six')
    before = {joint.child: joint for joint in robot.joints}
    links = {joint.child: joint for joint in arm}
    ordered: list[UrdfJoint] = []
    for joint in arm:
        steps, link = joint.origin, joint.parent
        while link not in links and link in before and before[link].kind == 'fixed':
            if not any(other.child == before[link].child for other in arm):
                steps, link = before[link].origin @ steps, before[link].parent
        ordered.append(joint._replace(origin=steps if link in links else joint.origin,
                                      parent=link if link in links else joint.parent))
    first = [joint for joint in ordered if joint.parent not in links]
    if len(first) != 1:
        raise InputError(f'{path}: its six revolute joints are no single chain')
    chain = first
    while len(chain) < 6:
        after = [joint for joint in ordered if joint.parent == chain[-1].child]
        if len(after) != 1:
            raise InputError(f'{path}: its six revolute joints are no single chain')
        chain.append(after[0])
    return chain


def fixed_to(robot: UrdfRobot, link: str) -> dict[str, np.ndarray]:
    """Return the links that are fixed to a link, itself too, with their poses in it."""
    found, open_links = {link: np.eye(4)}, [link]
    while open_links:
        here = open_links.pop()
        for joint in robot.joints:
            if joint.kind != 'fixed':
                continue
            for child, parent, step in ((joint.child, joint.parent, joint.origin),
                                        (joint.parent, joint.child,
                                         np.linalg.inv(joint.origin))):
                if parent == here and child not in found:
                    found[child] = found[here] @ step
                    open_links.append(child)
    return found
