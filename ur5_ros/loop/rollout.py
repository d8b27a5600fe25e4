"""
The ordinary run in few calls: PyBullet and the compiled law, checked when it is over.

A second form of Plant and Controller, kept because a run takes a quarter of the time with it. A
run with another law, one that touches a limit, or one that does not follow an experiment goes
through Plant and Controller; the bits and events are the same, which test/loop proves.
"""

from functools import lru_cache

import numpy as np

from ur5_ros.analysis.data.run import States
from ur5_ros.config.experiments import load_experiment
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.worlds import EMPTY
from ur5_ros.control.experiment import experiment_trajectory
from ur5_ros.control.kernel import TOTAL
from ur5_ros.control.laws.registry import is_compiled
from ur5_ros.control.settings import settings_from
from ur5_ros.loop.loop_run import LoopRun
from ur5_ros.loop.rollout_engine import Rollout, RolloutEngine
from ur5_ros.loop.run_config import RunConfig, arm_named
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference, stamp_of_period
from ur5_ros.sim.limits import check_initial_state, state_bounds


def rollout(config: RunConfig) -> LoopRun | None:
    """Return the run of a configuration; None where it needs the full loop."""
    sim, control = config.sim, config.control
    conventions = sim.effort_convention, control.effort_convention
    if sim.gui or sim.world != EMPTY or 'gravity_excluded' in conventions or not (
            control.mode == 'computed_torque' and is_compiled(control)
            and control.autostart and control.experiment
            and control.torque_rate_limit == 0.0 and not control.friction_feedforward
    ) or _robot_acts(sim):
        return None
    sim_arm, arm = arm_named(sim.arm), arm_named(control.arm)
    rate = sim.control_rate
    stamp, table = _table(control.experiment, control.arm, rate,
                          control.singularity_margin)
    if config.periods > len(stamp):
        return None
    settings = settings_from(control, arm, rate)  # refuses what cannot run
    check_initial_state(sim_arm, sim.initial_positions)
    stamp, table = stamp[:config.periods], Reference(*(part[:config.periods] for part in table))
    run = RolloutEngine(config, sim_arm).run(settings, table)
    if run is None or not _within_limits(run, sim_arm):
        return None
    states = run.states[::sim.physics_rate // rate]
    effort = np.vstack([np.zeros((1, 6)), run.effort])
    exact = not (sim.delay_state_periods or sim.noise_position or sim.noise_velocity)
    return LoopRun(config, sim_arm, arm, stamp, run.measured[:, :6], run.measured[:, 6:],
                   effort[run.late],
                   None if exact else States(states[:, :6], states[:, 6:], effort),
                   run.torque, table, run.events)


def _robot_acts(sim: SimParameters) -> bool:
    """Return whether the robot changes a command, or reports another torque than acted."""
    return bool(sim.effort_feedback != 'total' or sim.torque_limit or sim.torque_rate_limit or any(
        sim.friction_compensation_viscous_scale + sim.friction_compensation_coulomb_scale))


def _within_limits(run: Rollout, arm: ArmParameters) -> bool:
    """Return whether nothing came near what the plant would have acted upon."""
    least, most = state_bounds(arm)
    return bool(((least <= run.states) & (run.states <= most)).all()
                and (np.abs(run.torque[:, TOTAL]) <= arm.limits.effort).all())


@lru_cache(maxsize=32)
def _table(experiment: str, arm: str, control_rate: int,
           margin: float) -> tuple[np.ndarray, Reference]:
    """Return stamp and reference of every period of an experiment, from state 1 on."""
    motion = experiment_trajectory(load_experiment(experiment), arm_named(arm), control_rate,
                                   margin).trajectory
    first = stamp_of_period(1, control_rate)
    stamps, rows, k = [], [], 1
    while (stamp := stamp_of_period(k, control_rate)) - first <= motion.duration:
        stamps.append(stamp)
        rows.append(motion.at(stamp - first))
        k += 1
    return np.array(stamps), Reference(*np.moveaxis(np.array(rows), 1, 0).copy())
