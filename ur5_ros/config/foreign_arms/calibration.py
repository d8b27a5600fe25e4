"""A robot's own calibration, as ur_calibration writes it, into an arm."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np

from ur5_ros.config.arms import arm_text, list_arms, load_arm
from ur5_ros.config.records import Meta, Record, validate
from ur5_ros.config.strict_yaml import read_yaml
from ur5_ros.errors import InputError
from ur5_ros.model.calibration import chain_frames, nominal_chain, transform
from ur5_ros.model.parameters import ArmParameters

#: Links of a calibration file, base to wrist.
LINKS = ('shoulder', 'upper_arm', 'forearm', 'wrist_1', 'wrist_2', 'wrist_3')

#: Farthest that the tool of a calibrated arm is from that of its DH table [m].
LARGEST_TOOL_OFFSET = 0.05

Metres = Annotated[float, Meta(ge=-1e4, le=1e4)]


class _Joint(Record, frozen=True, kw_only=True):
    x: Metres
    y: Metres
    z: Metres
    roll: Metres
    pitch: Metres
    yaw: Metres


class _Kinematics(Record, frozen=True, kw_only=True):
    shoulder: _Joint
    upper_arm: _Joint
    forearm: _Joint
    wrist_1: _Joint
    wrist_2: _Joint
    wrist_3: _Joint
    hash: str | int = ''


class _File(Record, frozen=True, kw_only=True, forbid_unknown_fields=False):
    kinematics: _Kinematics


def calibrated_arm_text(calibration: Path, arm: str | None = None) -> tuple[str, list[str]]:
    """
    Return the text of an arm file with a calibration in it, and what was done in sentences.

    ``calibration``: YAML file of ur_calibration: ``kinematics`` with x, y, z, roll, pitch and yaw
    of six links; ``arm``: the arm that was calibrated; by default the known one that it is nearest
    to.
    """
    data = read_yaml(calibration)
    if not isinstance(data, dict) or not isinstance(data.get('kinematics'), dict):
        raise InputError(f'{calibration}: no kinematics in it; give the file that ur_calibration '
                         'wrote')
    found = validate(_File, data, str(calibration)).kinematics
    joints = [getattr(found, link) for link in LINKS]
    chain = np.array([transform((joint.x, joint.y, joint.z), (joint.roll, joint.pitch, joint.yaw))
                      for joint in joints])
    names = [arm] if arm is not None else list_arms()
    away = {name: distance(chain, load_arm(name)) for name in names}
    best = min(away, key=lambda name: (away[name], name))
    if away[best] > LARGEST_TOOL_OFFSET:
        way_out = 'give the arm that was calibrated: --arm NAME' if arm else (
            'no known arm is nearer')
        raise InputError(f'{calibration}: the tool is up to {away[best]:.3g} m from that of arm '
                         f'{best}; at most {LARGEST_TOOL_OFFSET} m are a calibration: {way_out}')
    text = arm_text(best)
    if any(line.startswith('calibration:') for line in text.splitlines()):
        raise InputError(f'arm {best} is calibrated already; give the arm that it is made of')
    lines = ['calibration:', f'  source: "{calibration.name}, hash {found.hash or "none"}"',
             '  joints:']
    for joint in joints:
        lines.append(f'    - {{xyz: {_row((joint.x, joint.y, joint.z))}, '
                     f'rpy: {_row((joint.roll, joint.pitch, joint.yaw))}}}')
    return text.rstrip('\n') + '\n' + '\n'.join(lines) + '\n', [
        f'arm {best}, calibrated: the tool moves by up to {away[best] * 1e3:.3g} mm; poses and '
        'inverse kinematics follow the calibration, the dynamics the DH table']


def _row(values: tuple[float, ...]) -> str:
    return '[' + ', '.join(repr(float(value)) for value in values) + ']'


def distance(chain: np.ndarray, arm: ArmParameters) -> float:
    """Return how far the tools of a chain and of a DH table are apart, over spread postures."""
    if np.any(arm.angle_offset):
        return np.inf
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (200, 6))
    tools = [chain_frames(q, each)[:, 5, :3, 3] for each in
             (chain, nominal_chain(replace(arm, calibration=None)))]
    return float(np.linalg.norm(tools[0] - tools[1], axis=1).max())
