"""What a closed loop did, as arrays."""

import json
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data import run as series
from ur5_ros.analysis.data.contact import contact_series
from ur5_ros.analysis.data.run import NodeRecord, Run, States, total_effort
from ur5_ros.config.worlds import world_from
from ur5_ros.loop.run_config import RunConfig
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference, Torque
from ur5_ros.sim.events import Event


class LoopRun(NamedTuple):
    """One row a control period; angles are the manufacturer's."""

    config: RunConfig
    sim_arm: ArmParameters
    control_arm: ArmParameters
    stamp: np.ndarray
    """Simulated time [ns], shape (n,)."""
    q: np.ndarray
    """Measured positions [rad], shape (n, 6)."""
    qd: np.ndarray
    """Measured velocities [rad/s], shape (n, 6)."""
    effort: np.ndarray
    """Torque that acted up to the state [N m], shape (n, 6)."""
    truth: States | None
    """The exact states where noise or delay make them differ, None elsewhere."""
    torque: np.ndarray
    """The answer to each state, rows as in Torque [N m], shape (n, 5, 6); the last one is given
    when the plant has stopped."""
    reference: Reference
    """What the law followed, shapes (n, 6)."""
    events: tuple[Event, ...]
    contact: np.ndarray | None = None
    """Joint torque of all contacts in each physics step up to each state [N m], shape (n,
    substeps, 6); None without a world."""
    reports: tuple[list[tuple[str, bytes]], ...] = ()
    """Role and bytes of each period's messages of contact."""


def as_run(loop: LoopRun, name: str = 'loop') -> Run:
    """Return what the bags of a closed loop would be read as, without bags."""
    sim, control = loop.config.sim, loop.config.control
    parts = dict(zip(Torque._fields, np.moveaxis(loop.torque, 1, 0), strict=True))
    seen = contact_series(message for period in loop.reports for message in period)
    return Run(
        name=name,
        stamp=loop.stamp,
        states=total_effort(States(loop.q, loop.qd, loop.effort), sim.by_name(), loop.sim_arm),
        control_rate=float(sim.control_rate),
        physics_rate=float(sim.physics_rate),
        truth=loop.truth,
        command=parts['total'],
        reference=loop.reference,
        parts=parts,
        contact=loop.contact,
        **seen,
        sim=NodeRecord(sim.arm, loop.sim_arm, sim.by_name(), world=world_from(sim)),
        control=NodeRecord(control.arm, loop.control_arm, control.by_name()),
        events=tuple(series.RecordedEvent(event.stamp, event.kind, event.message,
                                  {key: json.loads(value) for key, value in event.values.items()})
                     for event in loop.events),
    )
