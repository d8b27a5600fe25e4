"""Experiment files, ``config/experiments/<name>.yaml``; a new file is a new experiment."""

from typing import Annotated, Any, Literal, cast, get_args

import msgspec

from ur5_ros.config.records import Meta, Record, Six, Three, validate
from ur5_ros.config.strict_yaml import file_names, named_file, read_yaml
from ur5_ros.config.worlds import EMPTY
from ur5_ros.errors import InputError

Seconds = Annotated[float, Meta(gt=0.0, le=3600.0)]
Axis = Literal['x', 'y', 'z']
JointName = Literal['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint',
                    'wrist_2_joint', 'wrist_3_joint']
Pause = Annotated[float, Meta(ge=0.0, le=3600.0)]


class Wave(Record, frozen=True, kw_only=True):
    """amplitude sin(2 pi frequency t + phase)."""

    amplitude: float
    """[m] along an axis, [rad] about an axis or on a joint."""
    frequency: Annotated[float, Meta(ge=0.0, le=100.0)]
    """[Hz]."""
    phase_degrees: float = 0.0


class Figure(Record, frozen=True, kw_only=True):
    """A number that a run of the experiment should give."""

    name: str
    quantity: Literal['normal_force', 'friction_ratio', 'stiffness', 'tool_travel',
                      'tool_position', 'touch_speed', 'object_travel']
    axis: Axis = 'z'
    """Of base: along which a force or a position counts."""
    body: str = ''
    """Of the world, for ``object_travel``."""
    window: Annotated[list[Pause], Meta(min_length=2, max_length=2)]
    """From and to, since the experiment began [s]."""
    expected: float
    tolerance: Annotated[float, Meta(gt=0.0)]


class _Experiment(Record, frozen=True, kw_only=True):
    name: str
    description: str
    source: str
    start_degrees: Six
    """Manufacturer's joint angles where the motion begins."""
    start_position: Three | None = None
    """Where the tool begins in base [m]: ``start_degrees`` then only choose the branch."""
    start_rpy_degrees: Three = msgspec.field(default_factory=lambda: [180.0, 0.0, 0.0])
    """Roll, pitch, yaw of the tool there."""
    world: str = EMPTY
    """What the arm touches: a name of ``config/worlds`` or a file."""
    sim: dict[str, Any] = {}
    """Further parameters of the simulator."""
    control: dict[str, Any] = {}
    """Further parameters of the controller."""
    figures: list[Figure] = []
    initial_error: Six = msgspec.field(default_factory=lambda: [0.0] * 6)
    """q(0) - q*(0) [rad]: where the arm stands when the experiment is to show the transient."""


class ToolWaves(_Experiment, frozen=True, kw_only=True):
    """
    The tool swings about its start: p0 + w(t) waves(t), R0 Rz Ry Rx of w(t) waves(t).

    w rises from 0 to 1 over ``ramp`` and falls over the last ``ramp_down`` seconds.

    """

    kind: Literal['tool_waves']
    duration: Seconds
    ramp: Pause
    ramp_down: Pause = 0.0
    position: dict[Axis, list[Wave]] = {}
    """Along the axes of base [m]."""
    rotation: dict[Axis, list[Wave]] = {}
    """Angles of R0 Rz(c) Ry(b) Rx(a) [rad]."""


class ToolCircle(_Experiment, frozen=True, kw_only=True):
    """The tool runs around a circle, at rest at both ends, without turning."""

    kind: Literal['tool_circle']
    duration: Seconds
    centre: Three
    """Centre of the circle from the start, axes of base [m]."""
    normal: Three
    """Axis of the turn in base; made perpendicular to ``centre``."""
    turns: Annotated[float, Meta(gt=0.0, le=100.0)] = 1.0


class ToolPolygon(_Experiment, frozen=True, kw_only=True):
    """The tool visits corners in straight lines, at rest in each."""

    kind: Literal['tool_polygon']
    leg_time: Seconds | None = None
    """Of every leg [s]; or:"""
    leg_times: list[Seconds] = []
    """Of each leg [s]; the tool waits where two corners are the same."""
    corners: Annotated[list[Three], Meta(min_length=2, max_length=100)]
    """Positions from the start, axes of base [m]; the first is where it begins."""

    @property
    def duration(self) -> float:
        """Seconds from the first corner to the last."""
        return float(sum(self.times))

    @property
    def times(self) -> list[float]:
        """Time of each leg [s]."""
        return self.leg_times or [self.leg_time or 0.0] * (len(self.corners) - 1)


class JointWaves(_Experiment, frozen=True, kw_only=True):
    """Joints swing about the start: q0 + w(t) waves(t), w as in :class:`ToolWaves`."""

    kind: Literal['joint_waves']
    duration: Seconds
    ramp: Pause
    ramp_down: Pause = 0.0
    joints: dict[JointName, list[Wave]]


class JointStep(_Experiment, frozen=True, kw_only=True):
    """The reference stands still and jumps once, on purpose: the step response of the law."""

    kind: Literal['joint_step']
    duration: Seconds
    at: Pause
    """Time of the jump [s]."""
    step: Six
    """Jump of the reference [rad]."""


Experiment = ToolWaves | ToolCircle | ToolPolygon | JointWaves | JointStep
_KINDS = {get_args(kind.__annotations__['kind'])[0]: kind for kind in get_args(Experiment)}


def list_experiments() -> list[str]:
    """Return the names of the experiments that come with the package."""
    return file_names('experiment')


def load_experiment(name: str) -> Experiment:
    """Return an experiment from its file."""
    path = named_file('experiment', name)
    return _record(read_yaml(path), str(path))


def _record(data: Any, source: str) -> Experiment:
    kind = data.get('kind') if isinstance(data, dict) else None
    if not isinstance(kind, str) or kind not in _KINDS:
        raise InputError(f'{source}: kind is {kind!r}; give one of: {", ".join(_KINDS)}')
    experiment = cast(Experiment, validate(_KINDS[kind], data, source))
    if isinstance(experiment, ToolPolygon):
        _check_legs(experiment, source)
    ramps = getattr(experiment, 'ramp', 0.0) + getattr(experiment, 'ramp_down', 0.0)
    if ramps > experiment.duration:
        raise InputError(f'{source}: ramp and ramp_down take {ramps:g} s of '
                         f'{experiment.duration:g} s; make the duration longer')
    return experiment


def _check_legs(experiment: ToolPolygon, source: str) -> None:
    legs, times = len(experiment.corners) - 1, len(experiment.leg_times)
    if (experiment.leg_time is None) == (not times):
        raise InputError(f'{source}: give leg_time, or leg_times for each leg')
    if times and times != legs:
        raise InputError(f'{source}: {times} leg_times for {legs} legs; give {legs}')
