"""What to do with the first state, and with any after which the motion cannot go on."""

import numpy as np

from ur5_ros.control.experiment import ExperimentTrajectory
from ur5_ros.control.planning import Plan, plan_experiment, plan_stop
from ur5_ros.control.settings import Settings
from ur5_ros.control.trajectory import Hold
from ur5_ros.signals import ArmState, Reference

#: An autostarted experiment begins at once when the arm stands this near to it [rad]; from further
#: away the arm first moves there.
START_DISTANCE = 0.5
#: Speed below which an arm counts as standing [rad/s].
_STANDING_SPEED = 0.01


def plan_rest(settings: Settings, state: ArmState) -> Plan:
    """Return the motion that takes over a measured state and comes to rest."""
    speed, zero = np.abs(state.qd), np.zeros(6)
    if speed.max() < _STANDING_SPEED or (speed > 2.0 * settings.arm.limits.velocity).any():
        return Plan(Hold(state.q))
    return plan_stop(settings, Reference(state.q.copy(), state.qd.copy(), zero))


def plan_autostart(settings: Settings, start: Reference, experiment: ExperimentTrajectory) -> Plan:
    """Return the experiment begun now, or approached where the arm stands far from it."""
    first = experiment.trajectory.at(0).q
    if np.abs(start.q - first).max() <= START_DISTANCE:
        return Plan(experiment.trajectory, experiment.branch)
    return plan_experiment(settings, start, experiment)
