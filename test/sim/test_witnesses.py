"""Two other engines and the analytic model walk beside the plant under the same torques."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pinocchio
import pytest

from ur5_ros.config import SIM_PARAMETERS, complete, load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.experiment import initial_positions
from ur5_ros.model.dynamics import forward_dynamics
from ur5_ros.sim.plant import Plant, plant_from_parameters
from ur5_ros.sim.urdf import urdf_text

RELEASED = np.radians([0.0, 80.0, 20.0, 10.0, 30.0, 0.0])


def walk_pinocchio(arm, q, qd, torques, h):
    """Return the states of a semi-implicit Euler walk with Pinocchio's ABA."""
    model = pinocchio.buildModelFromXML(urdf_text(arm))
    model.armature = np.array(arm.armature)
    data, states = model.createData(), []
    for tau in torques:
        qd = qd + h * pinocchio.aba(model, data, q, qd, tau)
        q = q + h * qd
        states.append((q, qd))
    return np.array(states)


def walk_mujoco(arm, q, qd, torques, h):
    """Return the states of MuJoCo's own semi-implicit Euler."""
    model = mujoco.MjModel.from_xml_string(urdf_text(arm))
    model.opt.timestep = h
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    model.dof_armature[:] = arm.armature
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, qd
    states = []
    for tau in torques:
        data.qfrc_applied[:] = tau
        mujoco.mj_step(model, data)
        states.append((data.qpos.copy(), data.qvel.copy()))
    return np.array(states)


WALKS = pytest.mark.parametrize('walk', [walk_pinocchio, walk_mujoco])


@cache
def the_papers_experiment():
    """Return start, torques and states of the experiment of Fig. 11 on ur5."""
    arm, spec = load_arm('ur5'), load_experiment('kebria_fig11')
    start = initial_positions(spec, arm)
    plant = plant_from_parameters(complete(SIM_PARAMETERS, {
        'initial_positions': start.tolist()}))
    controller = controller_from_parameters(
        {'experiment': 'kebria_fig11', 'autostart': True}, 1000)
    torques, states = [], []
    for _ in range(20_000):
        torques.append(controller.update(plant.state).torque.total)
        state = plant.step(torques[-1])
        states.append((state.q, state.qd))
    plant.close()
    return start, np.array(torques), np.array(states)


@WALKS
def test_the_papers_torques_move_other_engines_alike(walk):
    # The arm stands up against gravity: a rounding error grows twentyfold every half second, so
    # that no two engines stay together for 20 s.  They start anew every two seconds.
    start, torques, states = the_papers_experiment()
    arm = load_arm('ur5')
    for first in range(0, 20_000, 2000):
        q, qd = states[first - 1] if first else (start, np.zeros(6))
        other = walk(arm, q, qd, torques[first:first + 2000], 1e-3)
        assert np.abs(states[first:first + 2000, 0] - other[:, 0]).max() < 1e-6
    alone = walk(arm, start, np.zeros(6), torques[:4000], 1e-3)
    assert np.abs(states[:4000, 0] - alone[:, 0]).max() < 1e-6


@WALKS
def test_five_seconds_of_random_torques_move_the_real_arm_alike(walk, plant_of):
    hanging = [0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0]
    plant = plant_of(arm='ur5_real', initial_positions=hanging)
    rng = np.random.default_rng(41)
    torques = 0.1 * plant.arm.limits.effort * rng.uniform(-1.0, 1.0, (5000, 6))
    states = []
    for tau in torques:
        state = plant.step(tau)
        states.append((state.q, state.qd))
    assert not plant.counters['limit_position_periods'], 'no stop is reached'
    assert np.ptp(np.array(states)[:, 0], axis=0).min() > 0.1, 'every joint moves'
    other = walk(plant.arm, np.array(hanging), np.zeros(6), torques, 1e-3)
    assert np.abs(np.array(states) - other).max() < 1e-9


def fall(witness_of, rate):
    """Return the states and the largest energy drift of two seconds of free fall, no stops."""
    arm = load_arm('ur5')
    arm = replace(arm, limits=replace(arm.limits, lower=np.full(6, -np.inf),
                                      upper=np.full(6, np.inf)))
    plant = Plant(arm, complete(SIM_PARAMETERS, {
        'control_rate': rate, 'physics_rate': rate, 'fallback': 'zero_torque',
        'initial_positions': RELEASED.tolist()}))
    witness = witness_of(arm)
    before, states, energies = witness.energy(RELEASED, np.zeros(6)), [], []
    for _ in range(2 * rate):
        state = plant.step(None)
        states.append(np.concatenate([state.q, state.qd]))
        energies.append(witness.energy(state.q, state.qd))
    plant.close()
    return np.array(states), np.abs(np.array(energies) - before).max()


def test_the_energy_drift_of_a_free_fall_halves_with_the_step(witness_of):
    drifts = [fall(witness_of, rate)[1] for rate in (500, 1000, 2000, 4000)]
    assert drifts == pytest.approx([0.123, 0.063, 0.031, 0.016], abs=0.001)
    for coarse, fine in zip(drifts, drifts[1:], strict=False):
        assert fine / coarse == pytest.approx(0.5, rel=0.05)


def test_no_hidden_damping_the_analytic_model_falls_the_same_way(witness_of):
    states, drift = fall(witness_of, 1000)
    arm, q, qd = load_arm('ur5'), RELEASED, np.zeros(6)
    witness, energies = witness_of(arm), []
    for state in states:
        qd = qd + 1e-3 * forward_dynamics(q, qd, np.zeros(6), arm)
        q = q + 1e-3 * qd
        energies.append(witness.energy(q, qd))
        assert np.abs(np.concatenate([q, qd]) - state).max() < 1e-6
    own = np.abs(np.array(energies) - witness.energy(RELEASED, np.zeros(6))).max()
    assert own == pytest.approx(drift, abs=1e-6)
