"""An arm from the URDF of a robot of the UR family: axes to a DH table, links to bodies."""

from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.config.foreign_arms.urdf_chain import (
    UrdfJoint,
    UrdfRobot,
    fixed_to,
    origin_of,
    parse_urdf,
    six_joints,
)
from ur5_ros.errors import InputError
from ur5_ros.model.calibration import transform
from ur5_ros.model.parameters import UR_TWIST, ArmParameters, Limits

#: How far axes may be from parallel, perpendicular or intersecting [rad, m].
ANGLE, DISTANCE = 1e-6, 1e-6

#: Gravity in base where the robot stands upright [m/s^2].
GRAVITY = (0.0, 0.0, -9.81)


def arm_of_urdf(path: Path, name: str | None = None, data: bytes | None = None,
                prefix: str | None = None) -> ArmParameters:
    """
    Return the arm that a URDF describes.

    ``path``: URDF with six revolute joints, axes 2 to 4 parallel and the others perpendicular, as
    the robots of the UR family have them; a xacro file is to be expanded before; ``name``: name of
    the arm; that of the robot by default; ``data``: its text, where ``path`` only says whose it
    is; ``prefix``: text before the names of the joints.
    """
    robot = parse_urdf(path, data)
    chain = six_joints(robot, path, prefix)
    base = base_frame(robot, chain[0])
    frames, poses = [], base
    for joint in chain:
        poses = poses @ joint.origin
        frames.append(poses)
    tool = frames[-1] @ _tool(robot, chain[-1].child)
    axes = np.array([frame[:3, :3] @ joint.axis for frame, joint in zip(frames, chain,
                                                                        strict=True)])
    points = np.array([frame[:3, 3] for frame in frames])
    dh, offset = _dh_frames(axes, points, tool, path)
    bodies = [body_of(robot, joint.child, frame, dh[i], path)
              for i, (joint, frame) in enumerate(zip(chain, frames, strict=True))]
    steps = [np.linalg.inv(before) @ after for before, after in
             zip([np.eye(4), *dh[:-1]], dh, strict=True)]
    a = np.array([np.cos(turn) * step[0, 3] + np.sin(turn) * step[1, 3]
                  for turn, step in zip(offset, steps, strict=True)])
    d = np.array([step[2, 3] for step in steps])
    a[[0, 3, 4, 5]], d[[1, 2]] = 0.0, 0.0
    limits = _limits(chain, path)
    try:
        return ArmParameters(
            name=name or robot.name, a=a, d=d, alpha=np.array(UR_TWIST), angle_offset=offset,
            mass=np.array([mass for mass, _, _ in bodies]),
            com=np.array([com for _, com, _ in bodies]),
            inertia=np.array([tensor for _, _, tensor in bodies]), armature=np.zeros(6),
            gravity=np.array(GRAVITY), limits=limits)
    except ValueError as error:
        raise InputError(f'{path}: {error}') from None


def mass_beyond_tool(path: Path, data: bytes | None = None) -> float:
    """Return the mass of the links of a URDF that move on behind the six joints [kg]."""
    robot = parse_urdf(path, data)
    chain = six_joints(robot, path)
    own = {link for joint in chain for link in fixed_to(robot, joint.child)}
    moving, beyond = set(own), set[str]()
    for _ in robot.joints:
        for joint in robot.joints:
            if joint.parent in moving and joint.child not in moving:
                moving.add(joint.child)
                beyond.add(joint.child)
    return sum(_number(robot.links[link].find('inertial/mass'), 'value', f'{path}: link {link!r}')
               for link in beyond if link in robot.links)


def base_frame(robot: UrdfRobot, first: UrdfJoint) -> np.ndarray:
    """Return the parent of the first joint as seen from ``base``; the same where there is none."""
    for link, pose in fixed_to(robot, first.parent).items():
        if link == 'base' or link.endswith('_base') and 'link' not in link:
            return np.linalg.inv(pose)
    if first.parent.endswith('base_link'):  # REP-103: base is turned by half a turn
        return transform((0.0, 0.0, 0.0), (0.0, 0.0, np.pi))
    return np.eye(4)


def _tool(robot: UrdfRobot, last: str) -> np.ndarray:
    """Return ``tool0`` in the last moving link; the link itself where there is none."""
    poses = fixed_to(robot, last)
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
    o1 = _intersection(p[0], z[0], p[1], z[1], (1, 2), path)
    a2, a3 = (_perpendicular(p[2] - o1, z[1]), _perpendicular(p[3] - p[2], z[1]))
    o2, o3 = o1 + a2, o1 + a2 + a3
    o4 = _intersection(p[3], z[3], p[4], z[4], (4, 5), path)
    o5 = _intersection(p[4], z[4], p[5], z[5], (5, 6), path)
    o6 = tool[:3, 3]
    off_axis = np.linalg.norm(_perpendicular(o6 - p[5], z[5]))
    if off_axis > DISTANCE or tool[:3, 2] @ z[5] < 1.0 - ANGLE:
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


def _perpendicular(vector: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the part of a vector that is perpendicular to an axis."""
    return vector - (vector @ axis) * axis


def _intersection(p: np.ndarray, z: np.ndarray, q: np.ndarray, w: np.ndarray,
                  which: tuple[int, int], path: Path) -> np.ndarray:
    """Return where two perpendicular axes meet."""
    point = p + ((q - p) @ z) * z
    gap = float(np.linalg.norm(_perpendicular(point - q, w)))
    if gap > DISTANCE:
        raise InputError(f'{path}: axes {which[0]} and {which[1]} pass each other by {gap:.3g} m; '
                         'the closed form holds where they meet')
    return point


def body_of(robot: UrdfRobot, link: str, frame: np.ndarray, dh: np.ndarray,
          path: Path) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, centre and tensor, in a DH frame, of a moving link and what is fixed to it."""
    to_dh = np.linalg.inv(dh) @ frame
    masses, centres, tensors = [], [], []
    for name, pose in fixed_to(robot, link).items():
        inertial = robot.links[name].find('inertial') if name in robot.links else None
        here = f'{path}: link {name!r}'
        mass = 0.0 if inertial is None else _number(inertial.find('mass'), 'value', here)
        if inertial is None or mass <= 0.0:
            continue
        where = to_dh @ pose @ origin_of(inertial, here)
        moments = inertial.find('inertia')
        xx, xy, xz, yy, yz, zz = (_number(moments, key, here)
                                  for key in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'))
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        masses.append(mass)
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


def _number(element: Any, key: str, where: str) -> float:
    """Return a number of an element, zero where there is none; InputError for what is none."""
    text = '0' if element is None else element.get(key, '0')
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f'{where}: {key}={text[:60]!r}; give a finite number')
    return value


def _limits(chain: list[UrdfJoint], path: Path) -> Limits:
    lower, upper, velocity, effort = np.zeros((4, 6))
    for i, joint in enumerate(chain):
        try:
            velocity[i], effort[i] = (float(joint.limit[key]) for key in ('velocity', 'effort'))
            lower[i], upper[i] = (-np.inf, np.inf) if joint.kind == 'continuous' else (
                float(joint.limit['lower']), float(joint.limit['upper']))
        except (KeyError, ValueError):
            raise InputError(f'{path}: joint {joint.name!r} needs <limit> with lower, upper, '
                             'velocity and effort') from None
        if not (0.0 < velocity[i] < np.inf and 0.0 < effort[i] < np.inf and lower[i] < upper[i]):
            stated = ', '.join(f'{key}={value!r}' for key, value in joint.limit.items())[:120]
            raise InputError(f'{path}: joint {joint.name!r}: {stated}; a limit needs lower below '
                             'upper, and velocity and effort above zero and finite')
    return Limits(lower, upper, velocity, effort)
