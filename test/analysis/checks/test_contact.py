"""Checks of contact: cone, passivity, the momentum observer."""

from dataclasses import replace

import numpy as np
import pytest

from ur5_ros.analysis.checks.contact import contact_checks
from ur5_ros.analysis.momentum_observer import external_torque, first_order
from ur5_ros.config import load_arm
from ur5_ros.config.validation import load_marks
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.dynamics import forward_dynamics, gravity_torque


@pytest.fixture(scope='module')
def tapped():
    return as_run(run_closed_loop(run_config('tap_wall', duration=1.2)))


def checks_of(run):
    return {check.name: check for check in contact_checks(run, load_marks())[0]}


def test_a_run_in_contact_passes_all_three(tapped):
    checks = checks_of(tapped)
    assert {name: check.verdict for name, check in checks.items()} == {
        'Coulomb cone': 'pass', 'contact passivity': 'pass', 'external torque': 'pass'}
    assert checks['Coulomb cone'].details['contacts'] > 10
    assert checks['contact passivity'].details['dissipated_J'] > 0.0


def test_friction_beyond_its_cone_fails_with_bodies_and_time(tapped):
    stamp, (contact, *others) = next(each for each in tapped.contact_forces if each[1])
    slipped = contact._replace(lateral=np.array([0.0, 5.0, 0.0]) + contact.normal[[1, 0, 2]])
    run = replace(tapped, contact_forces=((stamp, [slipped, *others]),))
    check = checks_of(run)['Coulomb cone']
    assert check.verdict == 'fail'
    assert 'wrist_3_link on wall at 0.7' in check.sentence


def test_contact_that_pushes_on_its_own_is_not_passive(tapped):
    # the torque of the contact moves the joints instead of resisting
    way = np.diff(tapped.exact.q, axis=0)
    contact = np.zeros_like(tapped.contact)
    contact[1:, 0] = 20.0 * np.sign(way)
    check = checks_of(replace(tapped, contact=contact))['contact passivity']
    assert check.verdict == 'fail' and check.value > 0.1


def test_the_observer_finds_a_torque_that_nothing_else_explains():
    arm, h, n = load_arm('ur5_real'), 1e-3, 1500
    rng = np.random.default_rng(7)
    q, qd = np.array([0.2, -1.4, 1.5, -1.6, -1.4, 0.1]), np.zeros(6)
    external = np.zeros((n, 6))
    external[500:900] = [4.0, -3.0, 2.0, 1.0, 0.5, 0.2]
    rows = [(q, qd, np.zeros(6))]
    for k in range(n - 1):
        tau = gravity_torque(q, arm) + 3.0 * np.sin(6.28 * k * h + np.arange(6))
        qd = qd + h * forward_dynamics(q, qd, tau + external[k], arm)
        q = q + h * qd
        rows.append((q, qd, tau))
    q, qd, effort = (np.array(part) for part in zip(*rows, strict=True))
    estimate = external_torque(q, qd, effort, h, arm, 50.0)
    truth = first_order(external[:-1], 50.0, h)
    assert np.abs(estimate - truth).max() < 0.02 * np.abs(truth).max()
    assert np.abs(estimate[499]).max() < 0.02
    noisy = external_torque(q, qd + rng.normal(0.0, 1e-6, qd.shape), effort, h, arm, 50.0)
    assert np.abs(noisy - truth).max() < 0.1
