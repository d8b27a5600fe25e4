"""
The ordinary run in few calls: PyBullet and the compiled law, checked when it is over.

Whoever asks for friction, noise, delays, limits touched or a motion that is not the experiment's
gets None and takes the long way through Plant and Controller; the bits are the same either way.
"""

from functools import lru_cache

import numpy as np

from ur5_ros.config.experiments import load_experiment
from ur5_ros.control import law_kernel
from ur5_ros.control.beginning import START_DISTANCE
from ur5_ros.control.experiment import experiment_motion
from ur5_ros.control.gains import gains_from
from ur5_ros.control.settings import settings_from
from ur5_ros.loop.loop_run import LoopRun
from ur5_ros.loop.plan import Plan, arm_named
from ur5_ros.model import dynamics_kernels
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import Reference, stamp_of_period
from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.limits import check_initial_state
from ur5_ros.sim.payload import loaded_arm

#: What the short way leaves to the long one: the value that each parameter has to have.
_SIM_PLAIN = {
    'effort_convention': 'total', 'gui': False, 'friction.viscous': [0.0] * 6,
    'friction.coulomb': [0.0] * 6, 'noise.position': 0.0, 'noise.velocity': 0.0,
    'delay.command_periods': 0, 'delay.state_periods': 0,
}
_CONTROL_PLAIN = {'effort_convention': 'total', 'mode': 'computed_torque', 'autostart': True,
                  'torque_rate_limit': 0.0}


def fast_lane(plan: Plan) -> LoopRun | None:
    """
    Return the run of a plan, or None where it is not an ordinary one.

    Parameters
    ----------
    plan : Plan
        Parameters of both sides.

    Raises
    ------
    Refusal
        As :class:`~ur5_ros.sim.plant.Plant` and :class:`~ur5_ros.control.controller.Controller`.

    """
    sim, control = plan.sim, plan.control
    if any(sim[key] != value for key, value in _SIM_PLAIN.items()) or any(
            control[key] != value for key, value in _CONTROL_PLAIN.items()):
        return None
    sim_arm, arm = arm_named(sim['arm']), arm_named(control['arm'])
    table = _table(control['experiment'], control['arm'], sim['control_rate'],
                   control['singularity_margin']) if control['experiment'] else None
    start = np.array(sim['initial_positions'])
    if (sim_arm.armature.any() or table is None or plan.periods > len(table.q)
            or np.abs(start - table.q[0]).max() > START_DISTANCE):
        return None
    settings_from(control, arm, sim['control_rate'])  # refuses what cannot run
    check_initial_state(sim_arm, sim['initial_positions'])
    table = Reference(*(part[:plan.periods] for part in table))
    states, torque = _go_round(plan, sim_arm, arm, table)
    substeps = sim['physics_rate'] // sim['control_rate']
    seen = states[::substeps]
    if not _ordinary(states, seen, torque, sim_arm, arm, control['max_state_jump']):
        return None
    effort = np.vstack([np.zeros((1, 6)), torque[:-1, law_kernel.TOTAL]])
    stamp = np.array([stamp_of_period(k, sim['control_rate'])
                      for k in range(1, plan.periods + 1)])
    return LoopRun(plan, sim_arm, arm, stamp, seen[:, :6], seen[:, 6:], effort, None, torque,
                   table, ())


def _go_round(plan: Plan, sim_arm: ArmParameters, arm: ArmParameters,
              table: Reference) -> tuple[np.ndarray, np.ndarray]:
    """Return q, qd of every physics step (n, 12) and the torque with its parts (m, 5, 6)."""
    sim = plan.sim
    substeps = range(sim['physics_rate'] // sim['control_rate'])
    gains = gains_from(plan.control['kp'], plan.control['kd'])
    kp, kd, offset, constants = gains.kp, gains.kd, arm.angle_offset, arm.constants
    dynamics_kernels.terms.prepare()
    law_kernel.parts.prepare()
    terms, law = dynamics_kernels.terms.single, law_kernel.parts.single
    m, c, g = np.empty((6, 6)), np.empty((6, 6)), np.empty(6)
    torque = np.empty((plan.periods, 5, 6))
    array, last = np.array, plan.periods - 1
    bullet = _world(1.0 / sim['physics_rate'])
    bullet.load(loaded_arm(sim_arm, sim['payload.mass'], sim['payload.com']),
                np.array(sim['gravity'] or sim_arm.gravity))
    bullet.place(sim['initial_positions'], sim['initial_velocities'])
    advance = bullet.advance
    values = array(sim['initial_positions'] + sim['initial_velocities'])
    states = [values]
    keep = states.append
    for k, (wanted, out) in enumerate(zip(zip(*table, strict=True), torque, strict=True)):
        q, qd = values[:6], values[6:]
        if terms(q + offset, qd, constants, m, c, g):
            break  # not finite: nothing ordinary, the long way says what
        law(m, c, g, q, qd, *wanted, kp, kd, out)
        if k == last:
            break
        tau = out[0].tolist()
        for _ in substeps:
            joints = advance(tau)
            values = array(joints[0] + joints[1])
            keep(values)
    return np.array(states), torque


def _ordinary(states: np.ndarray, seen: np.ndarray, torque: np.ndarray, sim_arm: ArmParameters,
              arm: ArmParameters, largest_jump: float) -> bool:
    """Tell whether nothing came near what Plant or Controller would have acted upon."""
    if len(seen) != len(torque) or not np.isfinite(states).all():
        return False
    q, qd = states[:, :6], np.abs(states[:, 6:])
    for limits in (sim_arm.limits, arm.limits):
        if ((q < limits.lower) | (q > limits.upper) | (qd > limits.velocity)).any():
            return False
        if (np.abs(torque[:, law_kernel.TOTAL]) > limits.effort).any():
            return False
    return bool((np.abs(np.diff(seen[:, :6], axis=0)) <= largest_jump).all())


@lru_cache(maxsize=1)
def _world(step_time: float) -> BulletArm:
    """Return a world that is kept: opening one takes as long as a second of simulated time."""
    arm = arm_named('ur5')
    return BulletArm(arm, arm.gravity, step_time)


@lru_cache(maxsize=32)
def _table(experiment: str, arm: str, control_rate: int, margin: float) -> Reference:
    """Return the reference of every period of an experiment, from state 1 on."""
    motion = experiment_motion(load_experiment(experiment), arm_named(arm), control_rate,
                               margin).motion
    first = stamp_of_period(1, control_rate)
    rows, k = [], 1
    while (time := stamp_of_period(k, control_rate) - first) <= motion.duration:
        rows.append(motion.at(time))
        k += 1
    return Reference(*np.moveaxis(np.array(rows), 1, 0).copy())
