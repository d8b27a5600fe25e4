"""Runs made in memory: the law on its own model, and the scheme of the simulator in a for loop."""

import itertools
import json

import numpy as np
import pytest
from foreign_recordings import STATES, motion, write_bag

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.run import NodeRecord, ParameterChange, RecordedEvent, Run, States
from ur5_ros.analysis.validate import validate
from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS, complete, load_arm
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.dynamics import forward_dynamics, inverse_dynamics
from ur5_ros.signals import Reference, stamp_of_period
from ur5_ros.sim.plant import Plant

HOME = np.radians([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
START_ERROR = np.array([0.10, -0.08, 0.06, 0.10, -0.10, 0.15])


def reference_at(t):
    """Return a smooth motion that starts and stays away from singularities."""
    t = np.asarray(t, dtype=float)[..., None]
    w = np.array([0.8, 1.1, 1.4, 1.7, 2.0, 2.3])
    a = 0.15
    return Reference(HOME + a * np.sin(w * t), a * w * np.cos(w * t),
                     -a * w**2 * np.sin(w * t))


def make_run(seconds=4.0, rate=1000, substeps=1, sim_arm='ur5', control_arm='ur5', kp=10.0,
             kd=10.0, plant=None, sim_parameters=None):
    """Return a run of the law on ``control_arm`` against the scheme of ``plant``."""
    arm, own = load_arm(sim_arm), load_arm(control_arm)
    if plant is not None:
        arm = plant
    n, h = int(seconds * rate) + 1, 1.0 / (rate * substeps)
    stamp = np.array([stamp_of_period(k, rate) for k in range(1, n + 1)])
    star = reference_at((stamp - stamp[0]) * 1e-9)
    q, qd, effort, command = np.zeros((4, n, 6))
    q[0], qd[0] = star.q[0] + START_ERROR, 0.0
    for k in range(n):
        a = star.qdd[k] - kd * (qd[k] - star.qd[k]) - kp * (q[k] - star.q[k])
        command[k] = inverse_dynamics(q[k] + own.angle_offset, qd[k], a, own)
        if k + 1 < n:
            position, velocity = q[k], qd[k]
            for _ in range(substeps):
                velocity = velocity + h * forward_dynamics(
                    position + arm.angle_offset, velocity, command[k], arm)
                position = position + h * velocity
            q[k + 1], qd[k + 1], effort[k + 1] = position, velocity, command[k]
    sim = complete(SIM_PARAMETERS, {'control_rate': rate, 'physics_rate': rate * substeps,
                                    **(sim_parameters or {})})
    control = complete(CONTROL_PARAMETERS, {'kp': [kp], 'kd': [kd]})
    return Run('in memory', stamp, States(q, qd, effort), rate, rate * substeps, None, command,
               star, {}, NodeRecord(sim_arm, load_arm(sim_arm), sim),
               NodeRecord(control_arm, own, control))


@pytest.fixture(scope='session')
def simulated():
    """Return :func:`make_run`."""
    return make_run


@pytest.fixture(scope='session')
def clean_run():
    """Return a run in which model and plant agree."""
    return make_run(seconds=9.0)


@pytest.fixture(scope='session')
def looped():
    """Return a function that runs PyBullet against the law, kept by its arguments."""
    known = {}

    def run(experiment='multi_sine', arm='ur5_real', duration=3.0, sim=None, control=None, **more):
        key = repr((experiment, arm, duration, sim, control, more))
        if key not in known:
            known[key] = as_run(run_closed_loop(run_config(
                experiment=experiment, arm=arm, duration=duration, sim=sim, control=control,
                **more)))
        return known[key]

    return run


@pytest.fixture(scope='session')
def stepped():
    """Return a function that runs plant and law and lets a test meddle with both."""
    def run(meddle=lambda k, plant, torque: torque, duration=0.6, experiment='multi_sine',
            steer=None, **given):
        plan = run_config(experiment=experiment, arm='ur5_real', duration=duration, **given)
        rate = plan.sim.control_rate
        plant = Plant(load_arm('ur5_real'), plan.sim)
        law = controller_from_parameters(plan.control, rate)
        states, truths, answers, events, changes = [], [], [], [], []
        state = plant.state
        try:
            for k in range(plan.periods):
                if steer and (values := steer(k)):
                    law.change(values)
                    changes.append(ParameterChange(states[-1].stamp if states else 0, values))
                states.append(state)
                truths.append(plant.truth)
                answers.append(law.update(state))
                state = plant.step(meddle(k, plant, answers[-1].torque.total))
                events += plant.drain_events()
        finally:
            plant.close()
        seen, true = (States(*(np.array([getattr(each, part) for each in many])
                               for part in ('q', 'qd', 'effort'))) for many in (states, truths))
        star = Reference(*(np.array([answer.reference[i] for answer in answers])
                           for i in range(3)))
        return Run('stepped', np.array([each.stamp for each in states]), seen, float(rate),
                   float(plan.sim.physics_rate), None if plant.exact_sensing else true,
                   np.array([answer.torque.total for answer in answers]), star, {},
                   NodeRecord('ur5_real', load_arm('ur5_real'), plan.sim.by_name()),
                   NodeRecord('ur5_real', law.arm, plan.control.by_name(),
                              changes=tuple(changes)),
                   tuple(RecordedEvent(each.stamp, each.kind, each.message,
                               {key: json.loads(value) for key, value in each.values.items()})
                         for each in events))

    return run


@pytest.fixture(scope='session')
def swapped(stepped):
    """Return a function that runs the loop with the torques handed over in another order."""
    return lambda order: stepped(lambda k, plant, torque: torque[order], 0.4)


@pytest.fixture(scope='session')
def recorded(tmp_path_factory):
    """Return the folder of a short run of the paper's experiment, both bags."""
    folder = tmp_path_factory.mktemp('bags') / 'short'
    run_closed_loop(run_config(duration=1.5), folder)
    return folder


@pytest.fixture(scope='session')
def made():
    """States of an arm ur5e in motion, as :func:`foreign_recordings.motion` gives them."""
    return motion()


@pytest.fixture
def judged(tmp_path):
    """Return a function that writes topics as a bag and judges it as arm ur5e."""
    count = itertools.count()

    def judge(messages, types=None, arm='ur5e', **options):
        if not isinstance(messages, dict):
            messages = {STATES: messages}
        folder = write_bag(tmp_path / f'bag_{next(count)}', messages, types)
        return validate(load_run(folder, arm=arm, **options))
    return judge
