"""Hostile values in every field: nothing crashes, nothing but finite torques reaches the plant."""

import math
import random

import numpy as np
import pytest

from ur5_ros.bag.cdr import FixedJointState, encode
from ur5_ros.config import (
    CONTROL_PARAMETERS,
    SIM_PARAMETERS,
    arm_text,
    complete,
    config_folder,
    parse_arm,
)
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.controller import Controller
from ur5_ros.errors import Refusal
from ur5_ros.nodes.messages import EffortReader, StateReader
from ur5_ros.signals import JOINT_NAMES, ArmState, stamp_of_period
from ur5_ros.sim.command_gate import CommandGate
from ur5_ros.sim.plant import plant_from_parameters

NUMBERS = (0.0, -0.0, 1.0, -150.0, 1e-320, 1e30, -1e308, math.inf, -math.inf, math.nan, 5e-324)
TEXTS = ('', 'elbow_joint', 'ELBOW_JOINT', 'x' * 300, '../../etc', '<script>', '\u202e', 'a\nb')


def hostile_command(dice: random.Random, stamp: int) -> bytes:
    """Return a JointState with some fields as they should not be."""
    names = list(JOINT_NAMES)
    effort = [dice.uniform(-30.0, 30.0) for _ in names]
    for _ in range(dice.choice([0, 1, 1, 2, 5])):
        spoil = dice.randrange(6)
        if spoil == 0 and effort:
            effort[dice.randrange(len(effort))] = dice.choice(NUMBERS)
        elif spoil == 1 and names:
            names[dice.randrange(len(names))] = dice.choice(TEXTS)
        elif spoil == 2:
            dice.shuffle(names)
        elif spoil == 3:
            effort = effort[:dice.randrange(7)] + [0.0] * dice.randrange(3)
        elif spoil == 4:
            names = names[:dice.randrange(7)]
        else:
            stamp = dice.choice([0, 1, stamp + 1, -(2**31) * 10**9, (2**31 - 1) * 10**9])
    seconds, nanoseconds = divmod(stamp, 10**9)
    data = encode('sensor_msgs/msg/JointState', {
        'header': {'stamp': {'sec': seconds, 'nanosec': nanoseconds}, 'frame_id': ''},
        'name': names, 'position': [math.nan] * dice.randrange(3), 'velocity': [],
        'effort': effort})
    if dice.random() < 0.2:
        spoiled = bytearray(data)
        spoiled[dice.randrange(len(spoiled))] ^= 1 << dice.randrange(8)
        data = bytes(spoiled)
    return data


@pytest.mark.fault(1, 2, 3, 5, 6, 7, 8, 9, 10, 18, 22, 64)
def test_no_command_brings_the_plant_out_of_the_finite(often, record_property):
    dice, now = random.Random(1), [0.0]
    parameters = complete(SIM_PARAMETERS, {'lockstep_timeout': 0.0})
    plant = plant_from_parameters(parameters)
    gate = CommandGate(list(JOINT_NAMES), parameters, clock=lambda: now[0])
    reader, limit = EffortReader(JOINT_NAMES), plant.arm.limits.effort
    gate.published(1)
    count, refused, taken = 10_000 * often, 0, 0
    for _ in range(count):
        now[0] += 0.001
        try:
            stamp, names, effort = reader.read(hostile_command(dice, plant.stamp))
        except Refusal as refusal:
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


@pytest.mark.fault(19, 20, 21, 57)
def test_no_state_brings_an_answer_that_is_not_finite(often, record_property):
    dice = random.Random(2)
    layout, reader = FixedJointState(JOINT_NAMES), StateReader(list(JOINT_NAMES))
    controller = Controller(complete(CONTROL_PARAMETERS, {}), 1000)
    home = np.array(complete(SIM_PARAMETERS, {})['initial_positions'])
    k, answered, refused = 0, 0, 0
    count = 2_000 * often
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
        except Refusal as refusal:
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
def test_no_parameter_set_is_taken_that_is_out_of_range(often, record_property):
    dice = random.Random(3)
    values = (*NUMBERS, *TEXTS, None, True, [], [0.0] * 6, [math.nan] * 6, [1] * 3, {'a': 1},
              10**30, -1, 2, 'brake')
    tried = refused = 0
    plant = plant_from_parameters(complete(SIM_PARAMETERS, {}))
    controller = Controller(complete(CONTROL_PARAMETERS, {}), 1000)
    controller.update(ArmState(1_000_000, plant.state.q, plant.state.qd, plant.state.effort))
    for _ in range(1_000 * often):
        for table, change in ((SIM_PARAMETERS, plant.change),
                              (CONTROL_PARAMETERS, lambda n, v: controller.change({n: v}))):
            name = dice.choice([parameter.name for parameter in table] + ['no_such'])
            value = dice.choice(values)
            tried += 1
            try:
                complete(table, {name: value})
                change(name, value)
            except Refusal as refusal:
                assert '\n' not in str(refusal)
                refused += 1
    for _ in range(50):
        assert np.isfinite(plant.step(None).q).all()
    plant.close()
    record_property('hostile parameter sets', tried)
    assert refused > tried // 2


@pytest.mark.fault(31, 38, 39, 40, 41, 42, 44, 45)
def test_no_mutilated_file_gets_past_its_reader(often, tmp_path, record_property):
    dice = random.Random(4)
    arm = arm_text('ur5')
    experiment = (config_folder() / 'experiments' / 'kebria_fig11.yaml').read_text()
    tried = refused = 0
    for _ in range(200 * often):
        tried += 2
        try:
            parse_arm(mutilate(arm, dice), 'fuzz.yaml')
        except Refusal as refusal:
            assert '\n' not in str(refusal)
            refused += 1
        path = tmp_path / 'fuzz.yaml'
        path.write_text(mutilate(experiment, dice))
        try:
            load_experiment(str(path))
        except Refusal as refusal:
            assert '\n' not in str(refusal)
            refused += 1
    record_property('mutilated files', tried)
    assert refused > tried // 3


def mutilate(text: str, dice: random.Random) -> str:
    """Return a text with characters, numbers or lines changed."""
    for _ in range(dice.choice([1, 1, 2, 4])):
        kind = dice.randrange(5)
        lines = text.splitlines(keepends=True)
        where = dice.randrange(len(lines))
        if kind == 0:
            del lines[where]
        elif kind == 1:
            lines.insert(where, lines[dice.randrange(len(lines))])
        elif kind == 2:
            other = dice.choice(['.nan', '-1', '1e999', 'x', '&a '])
            lines[where] = lines[where].replace('0', other)
        elif kind == 3:
            lines[where] = lines[where][:dice.randrange(len(lines[where]) + 1)]
        else:
            head = dice.choice(['{', '- ', '!!python/object:os.system ', '? ', '\t'])
            lines[where] = head + lines[where]
        text = ''.join(lines) or '\n'
    return text
