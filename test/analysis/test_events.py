"""What happens to the plant during a run is in the bag, and the residual stays exact."""

import numpy as np
import pytest

from ur5_ros.analysis.validate import validate


def at(row, act, until=None):
    """Return a meddler that acts before the step of one row."""
    def meddle(k, plant, torque):
        if k == row:
            act(plant)
        return torque
    return meddle


@pytest.mark.parametrize('rate', [1000, 500])
@pytest.mark.parametrize('name, value', [
    ('payload.mass', 2.0), ('friction.viscous', [5.0] * 6), ('friction.coulomb', [2.0] * 6),
    ('gravity', [0.0, 1.0, -9.0])])
def test_a_live_change_of_the_plant(stepped, name, value, rate):
    run = stepped(at(200, lambda plant: plant.change(name, value)), control_rate=rate)
    assert any(event.kind == 'parameter' for event in run.events)
    result = validate(run)
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('residual, controller arm').verdict == 'fail'


def test_a_wrench_on_the_tool(stepped):
    run = stepped(at(200, lambda plant: plant.apply_wrench([10.0, 0.0, -5.0], [0.5, 0.0, 1.0])))
    result = validate(run)
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('residual, controller arm').value > 1.0


def test_a_wrench_that_ends_by_itself(stepped):
    run = stepped(at(200, lambda plant: plant.apply_wrench([10.0, 0.0, 0.0], [0.0, 0.0, 1.0])),
                  sim={'wrench_duration': 0.1})
    assert validate(run).check('residual, simulator arm').value < 1e-9


def test_a_reset(stepped):
    run = stepped(at(300, lambda plant: plant.reset()))
    result = validate(run)
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('residual, controller arm').value < 1e-9


def test_the_brake_of_a_plant_without_commands(stepped):
    run = stepped(lambda k, plant, torque: None if 200 <= k < 260 else torque)
    result = validate(run)
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('command acts').details['differing'] >= 59


def test_torque_limits_are_no_false_alarm_but_are_reported(stepped):
    run = stepped(lambda k, plant, torque: torque, experiment='kebria_fig11',
                  control={'kp': [2000.0], 'kd': [90.0]})
    result = validate(run)
    assert np.abs(run.states.effort).max() >= 28.0
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('command acts').verdict == 'pass'
    assert result.check('limits').verdict == 'fail'


def test_a_joint_at_its_stop(stepped):
    push = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 6.0])
    run = stepped(lambda k, plant, torque: torque + push, duration=1.0,
                  sim={'initial_velocities': [0.0] * 5 + [2.5],
                       'initial_positions': [0.0, -1.4, 1.4, -1.5, -1.5, 5.8]})
    result = validate(run)
    assert result.check('limits').verdict == 'fail'
    assert 'wrist_3_joint position' in result.check('limits').sentence
    assert result.check('residual, simulator arm').value < 1e-9
    assert result.check('passivity').verdict == result.check('energy balance').verdict == 'pass'
