"""Which known arm a URDF describes, by its kinematics and its inertias."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.config.arms import known_arms
from ur5_ros.config.foreign_arms.calibration import LARGEST_TOOL_OFFSET, distance
from ur5_ros.config.foreign_arms.urdf_arm import arm_of_urdf, base_frame, body_of
from ur5_ros.config.foreign_arms.urdf_chain import parse_urdf, six_joints
from ur5_ros.errors import InputError
from ur5_ros.model.calibration import chain_frames, nominal_chain
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.kinematics import forward_kinematics, link_transforms
from ur5_ros.model.parameters import ArmParameters

#: Torques of two arms that differ by less, as a share of each joint's, are those of one.
SAME_TORQUE = 0.01

#: The tool of an arm is the same within this distance [m].
SAME_PLACE = 1e-3


class KnownArm(NamedTuple):
    """The known arm that a URDF is nearest to."""

    names: tuple[str, ...]
    """Known arms that agree in kinematics and inertias, those without rotors first."""
    like: str
    """The known arm with the same lengths; empty where there is none."""
    away: float
    """How far the tools of both are apart at most [m]."""
    found: ArmParameters
    """The arm of the URDF; its lengths are those of ``like`` where it is calibrated."""


def known_arm(path: Path, data: bytes, prefix: str | None = None) -> KnownArm:
    """
    Return which known arm a URDF describes.

    ``path``: whose URDF it is; ``data``: its text; ``prefix``: text before the names of its
    joints.  InputError where it is no robot of the UR family.
    """
    arms = known_arms()
    try:
        found = arm_of_urdf(path, data=data, prefix=prefix)
        away = {name: _apart(found, arm) for name, arm in arms.items()}
    except InputError:
        like, distances = _nearest_chain(path, data, prefix, arms)
        if distances[like] > LARGEST_TOOL_OFFSET:
            raise
        found, away = _with_bodies(path, data, prefix, arms[like]), distances
    least = min(away.values())
    nearest = min(least + SAME_PLACE, LARGEST_TOOL_OFFSET)
    near = [name for name, each in away.items() if each < nearest]
    agree = [name for name in near if _same_torque(found, arms[name])]
    agree.sort(key=lambda name: bool(arms[name].armature.any()))
    like = near[0] if near else ''
    return KnownArm(tuple(agree), agree[0] if agree else like, least, found)


def _apart(one: ArmParameters, other: ArmParameters) -> float:
    """Return how far the tools of two arms are apart at most, over spread postures [m]."""
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (200, 6))
    here, there = (forward_kinematics(q + arm.angle_offset, replace(arm, calibration=None))
                   for arm in (one, other))
    return float(np.linalg.norm(here[:, :3, 3] - there[:, :3, 3], axis=1).max())


def _same_torque(one: ArmParameters, other: ArmParameters) -> bool:
    """Return whether two arms need the same torque, rotors aside."""
    q, qd, qdd = np.random.default_rng(2).uniform(-np.pi, np.pi, (3, 200, 6))
    a, b = (inverse_dynamics(q + arm.angle_offset, qd, qdd, replace(
        arm, gravity=one.gravity)) - arm.armature * qdd for arm in (one, other))
    size = np.sqrt(np.mean(b**2, axis=0))
    return bool((np.sqrt(np.mean((a - b)**2, axis=0)) < SAME_TORQUE * size).all())


def _nearest_chain(path: Path, data: bytes, prefix: str | None,
                   arms: dict[str, ArmParameters]) -> tuple[str, dict[str, float]]:
    """Return the arm that a calibrated chain is nearest to, and the distances of all [m]."""
    robot = parse_urdf(path, data)
    joints = six_joints(robot, path, prefix)
    chain = np.array([joint.origin for joint in joints])
    chain[0] = base_frame(robot, joints[0]) @ chain[0]
    away = {name: distance(chain, arm) for name, arm in arms.items()}
    return min(away, key=lambda name: (away[name], name)), away


def _with_bodies(path: Path, data: bytes, prefix: str | None,
                 like: ArmParameters) -> ArmParameters:
    """Return an arm with the bodies of a URDF whose joints stand nearly as the arm's do."""
    robot = parse_urdf(path, data)
    frames = chain_frames(np.zeros(6), nominal_chain(replace(like, calibration=None)))
    dh = link_transforms(np.zeros(6), replace(like, calibration=None))
    bodies = [body_of(robot, joint.child, frame, each, path) for joint, frame, each in
              zip(six_joints(robot, path, prefix), frames, dh, strict=True)]
    return replace(like, name=robot.name, armature=np.zeros(6),
                   mass=np.array([mass for mass, _, _ in bodies]),
                   com=np.array([com for _, com, _ in bodies]),
                   inertia=np.array([tensor for _, _, tensor in bodies]))
