"""Arm files: ``config/arms/<name>.yaml`` to :class:`~ur5_ros.model.parameters.ArmParameters`."""

from functools import cache
from typing import Annotated, Any

import msgspec
import numpy as np
import yaml

from ur5_ros.config.records import Meta, Record, Six, Three, validate
from ur5_ros.config.solids import Solid, check_tool
from ur5_ros.config.strict_yaml import file_names, named_file, parse_yaml, read_text, read_yaml
from ur5_ros.errors import InputError
from ur5_ros.model.calibration import transform
from ur5_ros.model.friction import JointFriction
from ur5_ros.model.parameters import ArmParameters, Limits, Payload

#: Behind the name of an arm: use the rotor inertia that its file assumes.
ASSUMED = '+armature_assumed'

Range = Annotated[list[float], Meta(min_length=2, max_length=2)]


class _Geometry(Record, frozen=True, kw_only=True):
    source: str
    a: Six
    d: Six
    alpha: Six


class _Link(Record, frozen=True, kw_only=True):
    name: str
    mass: float
    com: Three
    inertia: Six  # xx, yy, zz, xy, xz, yz
    source: str


class _Sourced(Record, frozen=True, kw_only=True):
    source: str
    value: Six


class _Gravity(Record, frozen=True, kw_only=True):
    source: str
    value: Three


class _Limits(Record, frozen=True, kw_only=True):
    source: str
    position: Annotated[list[Range | None], Meta(min_length=6, max_length=6)]
    velocity: Six
    effort: Six


class _Payload(Record, frozen=True, kw_only=True):
    mass: float = 0.0
    com: Three = msgspec.field(default_factory=lambda: [0.0] * 3)
    inertia: Six = msgspec.field(default_factory=lambda: [0.0] * 6)
    source: str = ''


class _CalibratedJoint(Record, frozen=True, kw_only=True):
    xyz: Three
    rpy: Three


class _Calibration(Record, frozen=True, kw_only=True):
    source: str
    joints: Annotated[list[_CalibratedJoint], Meta(min_length=6, max_length=6)]


class _Friction(Record, frozen=True, kw_only=True):
    viscous: _Sourced | None = None
    coulomb: _Sourced | None = None
    static: _Sourced | None = None
    stribeck_velocity: _Sourced | None = None
    load_factor: _Sourced | None = None
    viscous_quadratic: _Sourced | None = None
    viscous_cubic: _Sourced | None = None
    asymmetry: _Sourced | None = None


class _Motors(Record, frozen=True, kw_only=True):
    torque_constant: _Sourced | None = None
    unexplained_torque: _Sourced | None = None


class _ArmFile(Record, frozen=True, kw_only=True):
    name: str
    description: str
    warnings: list[str] = []
    dh: _Geometry
    angle_offset: _Sourced
    links: Annotated[list[_Link], Meta(min_length=6, max_length=6)]
    armature: _Sourced
    armature_assumed: _Sourced | None = None
    gravity: _Gravity
    limits: _Limits
    payload: _Payload = _Payload()
    calibration: _Calibration | None = None
    friction: _Friction = _Friction()
    motors: _Motors = _Motors()
    tool: list[Solid] = []


def list_arms() -> list[str]:
    """Return the names of the arms that come with the package."""
    return file_names('arm')


def arm_tool(name: str) -> list[Solid]:
    """Return the shapes on the flange that an arm's file has, in ``tool0``; empty for none."""
    return tool_of(arm_text(name), name)


def tool_of(text: str, source: str) -> list[Solid]:
    """Return the shapes on the flange that the text of an arm's file has, as :func:`arm_tool`."""
    if '\ntool:' not in text:
        return []
    tool = validate(_ArmFile, parse_yaml(text, source), source).tool
    check_tool(tool, source)
    return tool


def arm_text(name: str) -> str:
    """Return the YAML text of an arm, to be stored beside what was done with it."""
    base = name.removesuffix(ASSUMED)
    path = named_file('arm', base)
    if base == name:
        return read_text(path)
    data = read_yaml(path)
    file = validate(_ArmFile, data, str(path))
    if file.armature_assumed is None:
        raise InputError(f'{path}: it has no armature_assumed; give {base}, or an arm that has '
                         f'one: {", ".join(arms_with_assumed_armature())}')
    data = {**data, 'name': name, 'armature': data['armature_assumed']}
    del data['armature_assumed']
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True)


def arms_with_assumed_armature() -> list[str]:
    """Return the names of the arms without measured rotor inertia that have an assumed one."""
    return [name + ASSUMED for name in list_arms()
            if '\narmature_assumed:' in read_text(named_file('arm', name))]


def load_arm(name: str) -> ArmParameters:
    """
    Return an arm from its file.

    Parameters
    ----------
    name : str
        A name of :func:`list_arms`, or the path of a YAML file of the same form. With
        ``+armature_assumed`` behind it the rotor inertia that the file assumes is used.

    Returns
    -------
    ArmParameters
        The record, checked to be physical.

    Raises
    ------
    InputError
        If there is no such arm, or its file has a missing, unknown or non-physical value.

    Examples
    --------
    >>> from ur5_ros import load_arm
    >>> arm = load_arm('ur5')
    >>> arm.name, arm.mass.shape
    ('ur5', (6,))

    """
    if name.endswith(ASSUMED):
        return parse_arm(arm_text(name), name)
    path = named_file('arm', name)
    return _arm_record(read_yaml(path), str(path))


@cache
def known_arms() -> dict[str, ArmParameters]:
    """Return the arms that come with the package, by name."""
    return {name: load_arm(name) for name in list_arms()}


def parse_arm(text: str, source: str) -> ArmParameters:
    """Return an arm from the text of its file, as stored in a bag."""
    return _arm_record(parse_yaml(text, source), source)


def _arm_record(data: Any, source: str) -> ArmParameters:
    file = validate(_ArmFile, data, source)
    position = [limit if limit is not None else (-np.inf, np.inf)
                for limit in file.limits.position]
    try:
        return ArmParameters(
            name=file.name,
            a=np.array(file.dh.a),
            d=np.array(file.dh.d),
            alpha=np.array(file.dh.alpha),
            angle_offset=np.array(file.angle_offset.value),
            mass=np.array([link.mass for link in file.links]),
            com=np.array([link.com for link in file.links]),
            inertia=np.array([_tensor(link.inertia) for link in file.links]),
            armature=np.array(file.armature.value),
            gravity=np.array(file.gravity.value),
            limits=Limits(
                lower=np.array([low for low, _ in position], dtype=float),
                upper=np.array([high for _, high in position], dtype=float),
                velocity=np.array(file.limits.velocity),
                effort=np.array(file.limits.effort),
            ),
            calibration=None if file.calibration is None else np.array(
                [transform(joint.xyz, joint.rpy) for joint in file.calibration.joints]),
            payload=Payload(file.payload.mass, np.array(file.payload.com),
                            _tensor(file.payload.inertia)),
            friction=JointFriction(**{
                name: np.array(part.value) for name in file.friction.__struct_fields__
                if (part := getattr(file.friction, name)) is not None}),
            **{name: np.array(part.value) for name in file.motors.__struct_fields__
               if (part := getattr(file.motors, name)) is not None},
        )
    except ValueError as error:
        raise InputError(f'{source}: {error}') from None


def _tensor(components: list[float]) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = components
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
