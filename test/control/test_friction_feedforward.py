"""Friction fed forward: tracking with friction comes near that without."""

import numpy as np
import pytest

from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm
from ur5_ros.control.controller import Controller
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config


def tracked(arm, **control):
    """Return a run of smooth sines of all joints on an arm that rubs."""
    return run_closed_loop(run_config(
        'multi_sine', arm, duration=4.0, initial_error=0.0, sim={'friction.from_arm': True},
        control={'kp': [100.0], 'kd': [20.0], **control}))


def rms_error(run):
    return float(np.sqrt(np.mean((run.q - run.reference.q)[500:]**2)))


def test_feedforward_makes_the_error_thousands_of_times_smaller():
    assert load_arm('ur5_real').friction.coulomb.min() > 1.0
    without, with_ = (tracked('ur5_real', friction_feedforward=on) for on in (False, True))
    ratio = rms_error(without) / rms_error(with_)
    print(f'RMS error {rms_error(without):.3g} rad without friction feed-forward, '
          f'{rms_error(with_):.3g} rad with it: {ratio:.3g} times less')
    assert ratio == pytest.approx(3000, rel=0.2)


def test_a_law_that_knows_its_friction_is_the_plant_and_is_computed_again():
    checks = {check.name: check.verdict for check in validate(as_run(
        tracked('ur5_real', friction_feedforward=True))).checks}
    assert checks['residual, controller arm'] == checks['law'] == 'pass'
    blind = {check.name: check.verdict for check in validate(as_run(tracked('ur5_real'))).checks}
    assert blind['residual, controller arm'] == 'fail' and blind['law'] == 'pass'


def test_an_arm_without_friction_cannot_be_fed_forward():
    with pytest.raises(InputError, match='arm ur5 has no friction; give one') as error:
        Controller(load_arm('ur5'), {'friction_feedforward': True})
    assert '\n' not in str(error.value)


def test_it_can_be_switched_while_the_law_runs_and_limits_still_hold():
    law = Controller(load_arm('ur5e_real'), {'torque_rate_limit': 100.0})
    law.change({'friction_feedforward': True})
    with pytest.raises(InputError):
        Controller(load_arm('ur5')).change({'friction_feedforward': True})
