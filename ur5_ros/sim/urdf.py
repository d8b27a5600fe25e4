"""The arm as a URDF: the one description that PyBullet, RViz, MuJoCo and Pinocchio share."""

import re
from collections.abc import Sequence
from html import escape  # that of xml.sax would load urllib and ssl

import numpy as np

from ur5_ros.config.worlds import World
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.urdf_shapes import COLOURS, Shape, arm_shapes
from ur5_ros.sim.world.shapes import TOOL_LINK, arm_capsules, capsule_elements, tool_elements

#: The moving links, named as in ur_description.
LINK_NAMES = ('shoulder_link', 'upper_arm_link', 'forearm_link', 'wrist_1_link', 'wrist_2_link',
              'wrist_3_link')
#: flange -> tool0 of ur_description: the flange's x is the tool's z.
_FLANGE_IN_TOOL0 = (0.0, -np.pi / 2, -np.pi / 2)
_TOOL0_IN_FLANGE = (np.pi / 2, 0.0, np.pi / 2)


def urdf_text(arm: ArmParameters, tf_prefix: str = '', bare: bool = False,
              shapes: bool = True, world: World | None = None) -> str:
    """
    Return the arm as a URDF, in the manufacturer's angles q_UR for every arm.

    Frames carry ur_description's names and places: ``base_link`` (root), ``base`` (the DH base,
    turned by Rz(pi)), ``shoulder_link`` ... ``wrist_3_link``, ``flange``, ``tool0`` (DH frame 6).
    Shapes are visual only, so that no engine adds contacts of its own.  The declared payload is
    part of ``wrist_3_link``; rotor inertia (armature) has no place in a URDF and is left out.

    ``arm``: the arm; every link needs a tensor; ``bare``: the chain that the simulator loads:
    ``base`` is the root, the massless frames are left out and the joints are continuous, because
    the plant has its own stops; ``shapes``: include the looks of the links; they take most of the
    time of loading.
    """
    if not arm.has_tensors:
        link = int(np.argmin([np.linalg.eigvalsh(tensor)[0] for tensor in arm.inertia])) + 1
        raise InputError(f'arm {arm.name}: link {link} is a point mass without a tensor, which no '
                         'simulator can turn; use it for the model only, or simulate ur5 or '
                         'ur5_real')
    if not re.fullmatch(r'[A-Za-z0-9_/]*', tf_prefix):
        raise InputError(f'tf_prefix {tf_prefix!r}; give letters, digits, _ and / only')
    root = 'base' if bare else 'base_link_inertia'
    looks = arm_shapes(arm) if shapes else {}
    solids = _solids(arm, world, bare, shapes)
    parts = [_massless_link(tf_prefix + root, looks.get('base', ()))]
    if not bare:
        parts += [
            _massless_link(tf_prefix + 'base_link'),
            _fixed_joint(tf_prefix, 'base_link', root, (0.0, 0.0, np.pi)),
            _massless_link(tf_prefix + 'base'),
            _fixed_joint(tf_prefix, 'base_link', 'base', (0.0, 0.0, np.pi)),
        ]
    bodies = link_bodies(arm)
    for i, (name, (xyz, rpy)) in enumerate(zip(LINK_NAMES, joint_origins(arm), strict=True)):
        parent = root if i == 0 else LINK_NAMES[i - 1]
        parts.append(_link(tf_prefix + name, *bodies[i],
                           _visuals(looks.get(name, ())) + solids.get(name, '')))
        parts.append(_moving_joint(tf_prefix, i, parent, name, xyz, rpy,
                                   arm, bare))
    if not bare:
        parts += [
            _massless_link(tf_prefix + 'flange'),
            _fixed_joint(tf_prefix, 'wrist_3_link', 'flange', _FLANGE_IN_TOOL0),
            _massless_link(tf_prefix + 'tool0'),
            _fixed_joint(tf_prefix, 'flange', 'tool0', _TOOL0_IN_FLANGE),
        ]
    materials = ''.join(f'  <material name="{name}"><color rgba="{_numbers(rgba)}"/></material>\n'
                        for name, rgba in COLOURS.items())
    return (f'<?xml version="1.0"?>\n<robot name="{escape(arm.name)}">\n'
            + materials + ''.join(parts) + '</robot>\n')


def link_turns(arm: ArmParameters) -> np.ndarray:
    """
    Return phi (6,): URDF link i = DH frame i-1, then Rz(theta_i) Tz(d_i) Rz(-phi_i).

    phi takes the record's angle offsets out again, so that the links of an arm written with
    positive a2 and a3 stand as the manufacturer's do.

    """
    phi = np.zeros(6)
    for i in range(6):
        carried = phi[i - 1] if i > 0 and arm.alpha[i - 1] == 0.0 else 0.0
        phi[i] = arm.angle_offset[i] + carried
    return phi


def joint_origins(arm: ArmParameters) -> list[tuple[tuple, tuple]]:
    """Return xyz [m] and roll, pitch, yaw [rad] of each joint in its parent link."""
    phi = link_turns(arm)
    origins: list[tuple[tuple, tuple]] = [((0.0, 0.0, _snap(arm.d[0])),
                (0.0, 0.0, _snap(arm.angle_offset[0] - phi[0])))]
    for i in range(1, 6):
        along = np.array([arm.a[i - 1], 0.0, 0.0])
        before = _rz(phi[i - 1])
        twist = before @ _rx(arm.alpha[i - 1])
        xyz = before @ along + twist @ np.array([0.0, 0.0, arm.d[i]])
        turn = twist @ _rz(arm.angle_offset[i] - phi[i])
        origins.append((tuple(_snap(x) for x in xyz), _roll_pitch_yaw(turn)))
    return origins


def link_bodies(arm: ArmParameters) -> list[tuple[float, tuple, tuple, np.ndarray]]:
    """
    Return mass, centre of mass, principal axes (rpy) and principal moments of each URDF link.

    The tensor is written in its principal axes: PyBullet would otherwise turn it itself, to six
    digits only.

    """
    phi = link_turns(arm)
    bodies = []
    for i, (mass, com, tensor) in enumerate(zip(*arm.bodies, strict=True)):
        turn = _rz(phi[i]) @ _rx(arm.alpha[i])  # link frame <- DH frame i
        centre = _rz(phi[i]) @ np.array([arm.a[i], 0.0, 0.0]) + turn @ com
        tensor = turn @ tensor @ turn.T
        off_diagonal = np.abs(tensor - np.diag(np.diag(tensor))).max()
        if off_diagonal < 1e-15 * np.abs(tensor).max() or off_diagonal < 1e-18:
            axes, moments = np.eye(3), np.diag(tensor)
        else:
            moments, axes = np.linalg.eigh((tensor + tensor.T) / 2)
            axes = axes * [1.0, 1.0, np.sign(np.linalg.det(axes))]  # right-handed
        bodies.append((float(mass), tuple(_snap(x) for x in centre), _roll_pitch_yaw(axes),
                       _of_a_body(moments)))
    return bodies


def _of_a_body(moments: np.ndarray) -> np.ndarray:
    """
    Return principal moments of which rounding makes none larger than the sum of the others.

    Of a flat body it does; PyBullet would then take all three for zero.
    """
    largest = int(np.argmax(moments))
    most = float(np.nextafter(moments.sum() - moments[largest], 0.0))
    if moments[largest] <= most:
        return moments
    moments = moments.copy()
    moments[largest] = most
    return moments


def _link(name: str, mass: float, xyz: tuple, rpy: tuple, moments: np.ndarray,
          shapes: str) -> str:
    ixx, iyy, izz = (repr(float(value)) for value in moments)
    return (
        f'  <link name="{name}">\n    <inertial>\n'
        f'      <origin xyz="{_numbers(xyz)}" rpy="{_numbers(rpy)}"/>\n'
        f'      <mass value="{mass!r}"/>\n'
        f'      <inertia ixx="{ixx}" ixy="0.0" ixz="0.0" iyy="{iyy}" iyz="0.0" izz="{izz}"/>\n'
        f'    </inertial>\n{shapes}  </link>\n'
    )


def _massless_link(name: str, shapes: Sequence[Shape] = ()) -> str:
    return (  # a mass of zero, written out: PyBullet gives a link without an inertial 1 kg
        f'  <link name="{name}">\n    <inertial><mass value="0.0"/>'
        '<inertia ixx="0.0" ixy="0.0" ixz="0.0" iyy="0.0" iyz="0.0" izz="0.0"/></inertial>\n'
        f'{_visuals(shapes)}  </link>\n'
    )


def _solids(arm: ArmParameters, world: World | None, bare: bool, shapes: bool) -> dict[str, str]:
    """Return what touches, by link: nothing without a world."""
    if world is None or not (world.bodies or world.self_contact or world.tool):
        return {}
    found = {link: ''.join(capsule_elements(capsule, bare) for capsule in capsules)
             for link, capsules in arm_capsules(arm).items()}
    found[TOOL_LINK] += tool_elements(world.tool, 'collision')
    if shapes:
        found[TOOL_LINK] += tool_elements(world.tool, 'visual')
    return found


def _visuals(shapes: Sequence[Shape]) -> str:
    return ''.join(
        f'    <visual>\n      <origin xyz="{_numbers(shape.xyz)}" rpy="{_numbers(shape.rpy)}"/>\n'
        f'      <geometry>{shape.geometry()}</geometry>\n'
        f'      <material name="{shape.colour}"/>\n    </visual>\n'
        for shape in shapes)


def _moving_joint(prefix: str, i: int, parent: str, child: str, xyz: tuple, rpy: tuple,
                  arm: ArmParameters, bare: bool) -> str:
    limits = arm.limits
    free = bare or np.isinf(limits.lower[i]) or np.isinf(limits.upper[i])
    low, high = float(limits.lower[i]), float(limits.upper[i])
    kind, span = ('continuous', '') if free else ('revolute', f'lower="{low!r}" upper="{high!r}" ')
    return (
        f'  <joint name="{prefix}{JOINT_NAMES[i]}" type="{kind}">\n'
        f'    <parent link="{prefix}{parent}"/>\n    <child link="{prefix}{child}"/>\n'
        f'    <origin xyz="{_numbers(xyz)}" rpy="{_numbers(rpy)}"/>\n    <axis xyz="0 0 1"/>\n'
        f'    <limit {span}effort="{float(limits.effort[i])!r}" '
        f'velocity="{float(limits.velocity[i])!r}"/>\n'
        f'    <dynamics damping="0.0" friction="0.0"/>\n  </joint>\n'
    )


def _fixed_joint(prefix: str, parent: str, child: str, rpy: tuple) -> str:
    return (
        f'  <joint name="{prefix}{parent}-{child}" type="fixed">\n'
        f'    <parent link="{prefix}{parent}"/>\n    <child link="{prefix}{child}"/>\n'
        f'    <origin xyz="0.0 0.0 0.0" rpy="{_numbers(rpy)}"/>\n  </joint>\n'
    )


def _numbers(values: tuple) -> str:
    return ' '.join(repr(float(value)) for value in values)


def _snap(value: float) -> float:
    return 0.0 if abs(value) < 1e-15 else float(value)


def _rx(angle: float) -> np.ndarray:
    c, s = _cos_sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _rz(angle: float) -> np.ndarray:
    c, s = _cos_sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _cos_sin(angle: float) -> tuple[float, float]:
    """Return cosine and sine, exact for quarter turns."""
    quarter = round(angle / (np.pi / 2))
    if abs(angle - quarter * np.pi / 2) < 1e-12:
        return [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarter % 4]
    return float(np.cos(angle)), float(np.sin(angle))


def _roll_pitch_yaw(turn: np.ndarray) -> tuple[float, float, float]:
    """Return roll, pitch, yaw with turn = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = np.arctan2(-turn[2, 0], np.hypot(turn[0, 0], turn[1, 0]))
    if np.hypot(turn[0, 0], turn[1, 0]) < 1e-12:  # only yaw - roll is determined
        return 0.0, float(pitch), float(np.arctan2(-turn[0, 1], turn[1, 1]))
    roll = np.arctan2(turn[2, 1], turn[2, 2])
    yaw = np.arctan2(turn[1, 0], turn[0, 0])
    return _snap(roll), _snap(pitch), _snap(yaw)
