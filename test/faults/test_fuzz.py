"""Hostile values in every field: nothing crashes, nothing but finite torques reaches the plant."""

import math
import random

import numpy as np
import pytest
from hostile import NUMBERS, TEXTS, hostile_command

from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS, complete
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.config.parameters import HOME
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.errors import InputError
from ur5_ros.nodes.ros.messages import EffortReader, StateReader
from ur5_ros.signals import JOINT_NAMES, ArmState, stamp_of_period
from ur5_ros.sim.lockstep_gate import command_gate
from ur5_ros.sim.plant import plant_from_parameters


@pytest.mark.timeout(3600)
@pytest.mark.fault(1, 2, 3, 5, 6, 7, 8, 9, 10, 18, 22, 64)
def test_no_command_brings_the_plant_out_of_the_finite(times, record_property):
    dice, now = random.Random(1), [0.0]
    parameters = SimParameters.of({'lockstep_timeout': 0.0})
    plant = plant_from_parameters(parameters)
    gate = command_gate(list(JOINT_NAMES), parameters, clock=lambda: now[0])
    reader, limit = EffortReader(JOINT_NAMES), plant.arm.limits.effort
    gate.published(1)
    count, refused, taken = times(10_000, 100_000), 0, 0
    for _ in range(count):
        now[0] += 0.001
        try:
            stamp, names, effort = reader.read(hostile_command(dice, plant.stamp))
        except InputError as refusal:
            assert '\n' not in str(refusal)
            refused += 1
            continue
        names = JOINT_NAMES if names is None else names
        refused += gate.offer_by_name('/joint_command', stamp, names, effort) is not None
        decision = gate.next()
        if decision.step:
            state = plant.step(decision.command)
            taken += 1
            assert np.isfinite(state.q).all()
            assert np.isfinite(state.qd).all()
            assert (np.abs(state.effort) <= limit).all()
            gate.published(plant.k)
            if taken % 200 == 0:
                plant.reset()
                gate.was_reset(plant.k)
        gate.drain_events()
        plant.drain_events()
    plant.close()
    record_property('hostile commands', count)
    assert sum(gate.refused.values()) > 0
    assert min(refused, taken) > count // 20


@pytest.mark.timeout(3600)
@pytest.mark.fault(19, 20, 21, 57)
def test_no_state_brings_an_answer_that_is_not_finite(times, record_property):
    dice = random.Random(2)
    layout, reader = FixedJointState(JOINT_NAMES), StateReader(list(JOINT_NAMES))
    controller = controller_from_parameters({}, 1000)
    home = np.array(HOME)
    k, answered, refused = 0, 0, 0
    count = times(2_000, 100_000)
    for _ in range(count):
        k += dice.choice([1, 1, 1, 0, 2, 500, -3])
        numbers = [home + dice.uniform(-0.01, 0.01), np.zeros(6), np.zeros(6)]
        if dice.random() < 0.3:
            numbers[dice.randrange(3)][dice.randrange(6)] = dice.choice(NUMBERS)
        stamp = stamp_of_period(max(k, 0), 1000)
        data = bytearray(layout.encode(stamp, *numbers))
        if dice.random() < 0.2:
            data[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
        try:
            answer = controller.update(reader.read(bytes(data)))
        except InputError as refusal:
            assert '\n' not in str(refusal)
            refused += 1
            continue
        answered += 1
        assert np.isfinite(answer.torque.total).all()
        assert (np.abs(answer.torque.total) <= controller.arm.limits.effort + 1e-9).all()
    record_property('hostile states', count)
    assert answered > count // 4
    assert refused > 0


@pytest.mark.fault(27, 28, 29, 30, 32)
def test_no_parameter_set_is_taken_that_is_out_of_range(times, record_property):
    dice = random.Random(3)
    values = (*NUMBERS, *TEXTS, None, True, [], [0.0] * 6, [math.nan] * 6, [1] * 3, {'a': 1},
              10**30, -1, 2, 'brake')
    tried = refused = 0
    plant = plant_from_parameters({})
    controller = controller_from_parameters({}, 1000)
    controller.update(ArmState(1_000_000, plant.state.q, plant.state.qd, plant.state.effort))
    for _ in range(times(500, 5_000)):
        for table, change in ((SIM_PARAMETERS, plant.change),
                              (CONTROL_PARAMETERS, lambda n, v: controller.change({n: v}))):
            names = [parameter.name for parameter in table] + ['no_such']
            wrong = {dice.choice(names): dice.choice(values)
                     for _ in range(dice.choice([1, 1, 2, 5]))}
            tried += 1
            try:
                complete(table, wrong)
                for name, value in wrong.items():
                    change(name, value)
            except InputError as refusal:
                assert '\n' not in str(refusal)
                refused += 1
    for _ in range(50):
        assert np.isfinite(plant.step(None).q).all()
    plant.close()
    record_property('hostile parameter sets', tried)
    assert refused > tried // 2
