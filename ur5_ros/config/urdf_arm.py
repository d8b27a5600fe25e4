"""An arm from the URDF of a robot of the UR family: axes to a DH table, links to bodies."""

import re
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.calibration import transform
from ur5_ros.model.parameters import UR_TWIST, ArmParameters, Limits
from ur5_ros.signals import JOINT_NAMES

#: Largest URDF [bytes].
MAX_BYTES = 20 << 20

#: How far axes may be from parallel, perpendicular or intersecting [rad, m].
ANGLE, DISTANCE = 1e-6, 1e-6

#: Gravity in base where the robot stands upright [m/s^2].
GRAVITY = (0.0, 0.0, -9.81)


class _Joint(NamedTuple):
    name: str
    kind: str
    parent: str
    child: str
    origin: np.ndarray
    axis: np.ndarray
    limit: dict[str, str]


class _Robot(NamedTuple):
    name: str
    joints: list[_Joint]
    links: dict[str, Any]


def arm_of_urdf(path: Path, name: str | None = None) -> ArmParameters:
    """
    Return the arm that a URDF describes.

    Parameters
    ----------
    path : pathlib.Path
        URDF with six revolute joints, axes 2 to 4 parallel and the others perpendicular, as the
        robots of the UR family have them; a xacro file is to be expanded before.
    name : str, optional
        Name of the arm; that of the robot by default.

    Raises
    ------
    InputError
        If it is no URDF, or of another kind of robot.

    """
    robot = _parse(path)
    chain = _six_joints(robot, path)
    base = _base_frame(robot, chain[0])
    frames, poses = [], base
    for joint in chain:
        poses = poses @ joint.origin
        frames.append(poses)
    tool = frames[-1] @ _tool(robot, chain[-1].child)
    axes = np.array([frame[:3, :3] @ joint.axis for frame, joint in zip(frames, chain,
                                                                        strict=True)])
    points = np.array([frame[:3, 3] for frame in frames])
    dh, offset = _dh_frames(axes, points, tool, path)
    bodies = [_body(robot, joint.child, frame, dh[i], path)
              for i, (joint, frame) in enumerate(zip(chain, frames, strict=True))]
    steps = [np.linalg.inv(before) @ after for before, after in
             zip([np.eye(4), *dh[:-1]], dh, strict=True)]
    a = np.array([np.cos(turn) * step[0, 3] + np.sin(turn) * step[1, 3]
                  for turn, step in zip(offset, steps, strict=True)])
    d = np.array([step[2, 3] for step in steps])
    a[[0, 3, 4, 5]], d[[1, 2]] = 0.0, 0.0
    try:
        return ArmParameters(
            name=name or robot.name, a=a, d=d, alpha=np.array(UR_TWIST), angle_offset=offset,
            mass=np.array([mass for mass, _, _ in bodies]),
            com=np.array([com for _, com, _ in bodies]),
            inertia=np.array([tensor for _, _, tensor in bodies]), armature=np.zeros(6),
            gravity=np.array(GRAVITY), limits=_limits(chain, path))
    except ValueError as error:
        raise InputError(f'{path}: {error}') from None


def _parse(path: Path) -> _Robot:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f'{path}: cannot be read: {error.strerror}') from None
    if len(data) > MAX_BYTES:
        raise InputError(f'{path}: {len(data)} bytes; at most {MAX_BYTES} are read')
    if b'<!DOCTYPE' in data or b'<!ENTITY' in data:
        raise InputError(f'{path}: declares entities, which no URDF needs; remove them')
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f'{path}: no XML: {error}') from None
    if root.tag != 'robot':
        raise InputError(f'{path}: no URDF: its root is <{root.tag[:40]}>, not <robot>')
    if any('xacro' in each.tag for each in root.iter()) or b'${' in data:
        raise InputError(f'{path}: a xacro file; expand it before: xacro {path.name} > arm.urdf')
    joints = [_joint(each, path) for each in root.findall('joint')]
    links = {str(each.get('name')): each for each in root.findall('link')}
    name = re.sub(r'[^A-Za-z0-9_]', '_', root.get('name') or 'arm')
    return _Robot(name, joints, links)


def _joint(element: Any, path: Path) -> _Joint:
    name = str(element.get('name'))
    parent, child = element.find('parent'), element.find('child')
    if parent is None or child is None:
        raise InputError(f'{path}: joint {name!r} has no parent or no child')
    axis_element, limit = element.find('axis'), element.find('limit')
    axis = _three(axis_element, 'xyz', '1 0 0', f'{path}: joint {name!r}')
    length = float(np.linalg.norm(axis))
    return _Joint(name, str(element.get('type')), str(parent.get('link')), str(child.get('link')),
                  _origin(element, f'{path}: joint {name!r}'), axis / (length or 1.0),
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


def _origin(element: Any, where: str) -> np.ndarray:
    origin = element.find('origin')
    return transform(_three(origin, 'xyz', '0 0 0', where), _three(origin, 'rpy', '0 0 0', where))


def _six_joints(robot: _Robot, path: Path) -> list[_Joint]:
    """Return the six joints of the arm, with the fixed ones between them taken in."""
    moving = [joint for joint in robot.joints if joint.kind in ('revolute', 'continuous')]
    named = [joint for joint in moving if joint.name.endswith(JOINT_NAMES)]
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
    ordered: list[_Joint] = []
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


def _fixed_to(robot: _Robot, link: str) -> dict[str, np.ndarray]:
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


def _base_frame(robot: _Robot, first: _Joint) -> np.ndarray:
    """Return the parent of the first joint as seen from ``base``; the same where there is none."""
    for link, pose in _fixed_to(robot, first.parent).items():
        if link == 'base' or link.endswith('_base') and 'link' not in link:
            return np.linalg.inv(pose)
    if first.parent.endswith('base_link'):  # REP-103: base is turned by half a turn
        return transform((0.0, 0.0, 0.0), (0.0, 0.0, np.pi))
    return np.eye(4)


def _tool(robot: _Robot, last: str) -> np.ndarray:
    """Return ``tool0`` in the last moving link; the link itself where there is none."""
    poses = _fixed_to(robot, last)
    return next((pose for link, pose in poses.items() if link.endswith('tool0')), np.eye(4))


def _dh_frames(z: np.ndarray, p: np.ndarray, tool: np.ndarray,
               path: Path) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the six DH frames and the joint angles of the DH table, both at q = 0."""
    for i, j, parallel in ((0, 1, False), (1, 2, True), (2, 3, True), (3, 4, False),
                           (4, 5, False)):
        sine = float(np.linalg.norm(np.cross(z[i], z[j])))
        error = sine if parallel else abs(float(z[i] @ z[j]))
        if error > ANGLE or (parallel and z[i] @ z[j] < 0.0):
            kind = 'parallel, in one direction' if parallel else 'perpendicular'
            raise InputError(f'{path}: axes {i + 1} and {j + 1} are not {kind}; the closed form '
                             'holds for the UR family only')
    o1 = _meet(p[0], z[0], p[1], z[1], (1, 2), path)
    a2, a3 = (_across(p[2] - o1, z[1]), _across(p[3] - p[2], z[1]))
    o2, o3 = o1 + a2, o1 + a2 + a3
    o4 = _meet(p[3], z[3], p[4], z[4], (4, 5), path)
    o5 = _meet(p[4], z[4], p[5], z[5], (5, 6), path)
    o6 = tool[:3, 3]
    if np.linalg.norm(_across(o6 - p[5], z[5])) > DISTANCE or tool[:3, 2] @ z[5] < 1.0 - ANGLE:
        raise InputError(f'{path}: tool0 is not on axis 6, or does not point along it')
    x2, x3 = (-part / np.linalg.norm(part) for part in (a2, a3))
    x = [np.cross(z[0], z[1]), x2, x3, np.cross(z[3], z[4]), -np.cross(z[4], z[5]), tool[:3, 0]]
    frames = []
    for origin, x_axis, z_axis in zip((o1, o2, o3, o4, o5, o6), x, (*z[1:], z[5]), strict=True):
        frame = np.eye(4)
        frame[:3, :3] = np.column_stack([x_axis, np.cross(z_axis, x_axis), z_axis])
        frame[:3, 3] = origin
        frames.append(frame)
    before = np.eye(3)
    offset = np.zeros(6)
    for i, frame in enumerate(frames):
        turn = before.T @ frame[:3, :3]
        offset[i] = np.arctan2(turn[1, 0], turn[0, 0])
        before = frame[:3, :3]
    offset[np.abs(offset) < 1e-12] = 0.0
    return frames, offset


def _across(vector: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the part of a vector that is perpendicular to an axis."""
    return vector - (vector @ axis) * axis


def _meet(p: np.ndarray, z: np.ndarray, q: np.ndarray, w: np.ndarray, which: tuple[int, int],
          path: Path) -> np.ndarray:
    """Return where two perpendicular axes meet."""
    point = p + ((q - p) @ z) * z
    gap = float(np.linalg.norm(_across(point - q, w)))
    if gap > DISTANCE:
        raise InputError(f'{path}: axes {which[0]} and {which[1]} pass each other by {gap:.3g} m; '
                         'the closed form holds where they meet')
    return point


def _body(robot: _Robot, link: str, frame: np.ndarray, dh: np.ndarray,
          path: Path) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, centre and tensor, in a DH frame, of a moving link and what is fixed to it."""
    to_dh = np.linalg.inv(dh) @ frame
    masses, centres, tensors = [], [], []
    for name, pose in _fixed_to(robot, link).items():
        inertial = robot.links[name].find('inertial') if name in robot.links else None
        mass = inertial.find('mass') if inertial is not None else None
        if inertial is None or mass is None or float(mass.get('value', 0.0)) <= 0.0:
            continue
        where = to_dh @ pose @ _origin(inertial, f'{path}: link {name!r}')
        moments = inertial.find('inertia')
        xx, xy, xz, yy, yz, zz = (float(moments.get(key, 0.0)) if moments is not None else 0.0
                                  for key in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'))
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        masses.append(float(mass.get('value')))
        centres.append(where[:3, 3])
        tensors.append(where[:3, :3] @ tensor @ where[:3, :3].T)
    if not masses:
        raise InputError(f'{path}: link {link!r} has no mass; the URDF needs <inertial> for each '
                         'moving link')
    total = sum(masses)
    centre = sum(m * c for m, c in zip(masses, centres, strict=True)) / total
    whole = np.zeros((3, 3))
    for m, c, tensor in zip(masses, centres, tensors, strict=True):
        r = c - centre
        whole += tensor + m * ((r @ r) * np.eye(3) - np.outer(r, r))
    return total, centre, 0.5 * (whole + whole.T)


def _limits(chain: list[_Joint], path: Path) -> Limits:
    lower, upper, velocity, effort = np.zeros((4, 6))
    for i, joint in enumerate(chain):
        try:
            velocity[i], effort[i] = (float(joint.limit[key]) for key in ('velocity', 'effort'))
            lower[i], upper[i] = (-np.inf, np.inf) if joint.kind == 'continuous' else (
                float(joint.limit['lower']), float(joint.limit['upper']))
        except (KeyError, ValueError):
            raise InputError(f'{path}: joint {joint.name!r} needs <limit> with lower, upper, '
                             'velocity and effort') from None
    return Limits(lower, upper, velocity, effort)
