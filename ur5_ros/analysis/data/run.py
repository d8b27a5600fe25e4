"""What one run recorded, as plain arrays; made from bags, or in memory by the loop."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from ur5_ros.cdr.contact_messages import ContactForce
from ur5_ros.config.worlds import EMPTY_WORLD, World
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference

#: Effort parts that the law records, in the order of the report.
PARTS = ('inertial', 'feedback', 'coriolis', 'gravity')

_Part = TypeVar('_Part')


class States(NamedTuple):
    """Joint states, row k at ``stamp[k]``; angles are the manufacturer's."""

    q: np.ndarray
    """Positions [rad], shape (n, 6)."""
    qd: np.ndarray
    """Velocities [rad/s], shape (n, 6)."""
    effort: np.ndarray
    """Torque that acted up to this state [N m], shape (n, 6); NaN where none is recorded."""


class RecordedEvent(NamedTuple):
    """An event of the plant, read from a bag."""

    stamp: int
    """Stamp of the state from which it acts [ns]."""
    kind: str
    """``parameter``, ``reset``, ``wrench``, ``fallback``, ``limit``, ..."""
    message: str
    """The sentence that was logged."""
    values: dict[str, Any]
    """Its data, by name."""


class ParameterChange(NamedTuple):
    """Parameters of the law that were changed during the run."""

    stamp: int
    """Stamp of the last state that was answered before [ns]; 0 where none was."""
    values: Mapping[str, Any]
    """New values by name."""


class TargetWrench(NamedTuple):
    """A desired wrench of the tool on its surroundings."""

    stamp: int
    """Stamp of the first state whose answer it is part of [ns]."""
    wrench: np.ndarray
    """Force [N] and torque [N m] at the origin of ``tool0``, in base, shape (6,)."""


def total_effort(states: States, parameters: Mapping[str, Any], arm: ArmParameters) -> States:
    """Return states whose effort is the whole torque that acted, whatever the drives report."""
    feedback = parameters.get('effort_feedback', 'total')
    if feedback == 'total':
        return states
    if feedback == 'current':
        return states._replace(effort=states.effort * np.array(parameters['torque_constant']))
    effort = states.effort.copy()
    effort[1:] += gravity_torque(states.q[:-1] + arm.angle_offset, arm)
    return states._replace(effort=effort)


@dataclass(frozen=True, eq=False)
class NodeRecord:
    """What one node's bag states about the node."""

    arm_name: str
    arm: ArmParameters
    parameters: Mapping[str, Any]
    """Every parameter at the start."""
    versions: Mapping[str, str] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict)
    """What the node wrote when it closed the bag; empty when it did not close it."""
    fingerprint: Mapping[str, Any] = field(default_factory=dict)
    """What repeatability to the last bit depends on."""
    changes: tuple[ParameterChange, ...] = ()
    """Later changes of the law's parameters, in order of time; the simulator's are events."""
    world: World = EMPTY_WORLD
    """What the simulated arm can touch."""


class _Required(Generic[_Part]):
    """A part of a run; InputError where it is missing."""

    def __init__(self, field: str, missing: str) -> None:
        self._field, self._missing = field, missing

    def __get__(self, run: 'Run', owner: type) -> _Part:
        part: _Part | None = getattr(run, self._field)
        if part is None:
            raise InputError(f'{run.name}: {self._missing}; record it, or choose another run')
        return part


@dataclass(frozen=True, eq=False)
class Run:
    """
    One run: rows are states in the order of their stamps, each with its answer and reference.

    Where a state has no answer or no reference the row holds NaN.  What a recording may lack is
    None; the attributes ``required_...`` raise InputError then and name what is missing.

    """

    name: str
    """The run's name."""
    stamp: np.ndarray
    """Simulated time of each state [ns], shape (n,), strictly increasing."""
    states: States
    """The states as published: with noise and delay, if any."""
    control_rate: float
    """States a second."""
    physics_rate: float = 0.0
    """Physics steps a second; 0 where the plant is not this package's simulator."""
    truth: States | None = None
    """The exact states, recorded while noise or delay are on; NaN elsewhere."""
    command: np.ndarray | None = None
    """The answer to each state [N m], shape (n, 6)."""
    reference: Reference | None = None
    """What the law followed, shapes (n, 6)."""
    parts: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Parts of the command by name of :data:`PARTS` and ``total``, each (n, 6) [N m]."""
    sim: NodeRecord | None = None
    control: NodeRecord | None = None
    events: tuple[RecordedEvent, ...] = ()
    state_time: np.ndarray | None = None
    """Wall clock at which each state was sent [ns], shape (n,)."""
    command_time: np.ndarray | None = None
    """Wall clock at which its answer arrived [ns], shape (n,); 0 where none did."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """Irregularities met while pairing: copies, answers without a state, steps back, ..."""
    problems: tuple[str, ...] = ()
    """Why the recording is not whole, one sentence each; empty where it is."""
    remarks: tuple[str, ...] = ()
    """What was passed over, dropped or assumed while reading, one sentence each."""
    dropped: np.ndarray | None = None
    """Stamps of messages that do not count [ns]; a gap that they fill is none of the recorder."""
    jumps: np.ndarray | None = None
    """Rows that begin after a jump of the positions."""
    folder: str = ''
    follows_reference: bool = False
    """Whether the effort is a robot's own target torque, which belongs to the reference."""
    current: np.ndarray | None = None
    """Motor currents [A], shape (n, 6), of a real robot's log."""
    temperature: np.ndarray | None = None
    """Temperatures of the joints [deg C], shape (n, 6), of a real robot's log."""
    contact: np.ndarray | None = None
    """Joint torque of all contacts in each physics step up to each state [N m], shape (n,
    substeps, 6); None without a world."""
    contact_forces: tuple[tuple[int, list[ContactForce]], ...] = ()
    """Stamp [ns] and forces of the contacts, at the simulator's ``monitor_rate``."""
    objects: tuple[tuple[int, np.ndarray], ...] = ()
    """Stamp [ns] and pose of every free body of the world, position [m] and quaternion (x, y, z,
    w) in base, shape (bodies, 7), likewise."""
    target_wrenches: tuple[TargetWrench, ...] = ()
    """Desired wrenches that the controller received, in order; before the first there is none."""
    effort_meaning: str = 'total'
    """What the recorded effort was stated to be: one of ``EFFORT_MEANINGS``."""
    described_arm: str = ''
    """What a recorded robot description is of, in a sentence, where that is no known arm."""

    required_reference = _Required[Reference]('reference', 'no reference is recorded')
    required_command = _Required[np.ndarray]('command', 'no stamped commands are recorded')
    required_sim = _Required[NodeRecord]('sim', 'the simulator is not described')
    required_control = _Required[NodeRecord]('control', 'the controller is not described')
    required_contact = _Required[np.ndarray]('contact', 'there was no world to touch')

    @property
    def law_record(self) -> NodeRecord | None:
        """The controller's record, or the simulator's where there is no controller."""
        return self.control or self.sim

    @property
    def has_reference(self) -> np.ndarray:
        """Which states have a reference, shape (n,)."""
        if self.reference is None:
            return np.zeros(len(self.stamp), dtype=bool)
        return np.isfinite(np.hstack([*self.reference])).all(axis=1)

    @property
    def t(self) -> np.ndarray:
        """Simulated time since the first state [s], shape (n,)."""
        return (self.stamp - self.stamp[0]) * 1e-9

    @property
    def h(self) -> float:
        """Control period [s]."""
        return 1.0 / self.control_rate

    @property
    def substeps(self) -> int:
        """Physics steps a control period; 0 where the plant is not this package's simulator."""
        return round(self.physics_rate / self.control_rate)

    @property
    def exact(self) -> States:
        """The exact states where they are recorded, else the published ones."""
        if self.truth is None:
            return self.states
        known = np.isfinite(self.truth.q).all(axis=1)[:, None]
        return States(*(np.where(known, true, published)
                        for true, published in zip(self.truth, self.states, strict=True)))

    def target_wrench_at(self, rows: np.ndarray) -> np.ndarray:
        """Return the desired wrench in the answers to some states, (m, 6) [N], [N m]."""
        wrenches = np.vstack([np.zeros(6), *(each.wrench for each in self.target_wrenches)])
        begins = np.array([each.stamp for each in self.target_wrenches], dtype=np.int64)
        return wrenches[np.searchsorted(begins, self.stamp[rows], side='right')]

    def applied(self, rows: np.ndarray) -> np.ndarray:
        """
        Return what motors and contacts put on the joints in each physics step after some rows.

        Rows that are followed by the state one period later, shape (m,); (m, substeps, 6) [N m].

        """
        effort = np.repeat(self.exact.effort[rows + 1][:, None], max(self.substeps, 1), axis=1)
        return effort if self.contact is None else effort + self.contact[rows + 1]

    @property
    def jitter(self) -> float:
        """Share of the period by which steps of the stamps may differ; more on a robot's clock."""
        return 1e-3 if self.sim is not None else 0.3

    @property
    def noisy(self) -> bool:
        """Whether the states carry noise and the exact ones are not recorded."""
        if self.truth is not None or self.sim is None:
            return self.sim is None
        given = [self.sim.parameters] + [
            {event.values.get('name'): event.values.get('value')}
            for event in self.events if event.kind == 'parameter']
        return any(each.get(name) for each in given
                   for name in ('noise.position', 'noise.velocity'))

    @property
    def steps(self) -> np.ndarray:
        """
        Which rows k are followed by the state one period later, shape (n - 1,).

        False across gaps and across a reset.

        """
        period = 1e9 / self.control_rate
        whole = np.abs(np.diff(self.stamp) - period) <= max(2.0, self.jitter * period)
        if self.jumps is not None:
            whole[self.jumps - 1] = False
        for event in self.events:
            if event.kind == 'reset':
                row = np.searchsorted(self.stamp, event.stamp)
                if 0 < row < len(self.stamp):
                    whole[row - 1] = False
        return whole
