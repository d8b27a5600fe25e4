"""Dry friction, brakes and stops: the optimality conditions, and an outside minimiser."""

import numpy as np
import pytest

from ur5_ros.sim.friction import solve_friction

NO_STOP = np.full(6, np.inf)


def problems(number, seed):
    """Yield ill-conditioned problems with friction on some joints and stops on some."""
    rng = np.random.default_rng(seed)
    for n in range(number):
        L = rng.normal(size=(6, 6)) * 10.0 ** rng.uniform(-2.0, 1.0, (6, 1))
        A = L @ L.T + 1e-3 * np.eye(6)
        drive = rng.normal(size=6) * 10.0 ** rng.uniform(-1.0, 3.0)
        qd = rng.normal(size=6) * 10.0 ** rng.uniform(-3.0, 2.0)
        qd[rng.random(6) < 0.1] = 0.0
        level = np.where(rng.random(6) < 0.3, 0.0, 10.0 ** rng.uniform(-2.0, 3.0, 6))
        lower = np.where(rng.random(6) < 0.5, -np.inf, -np.abs(rng.normal(size=6)))
        upper = np.where(rng.random(6) < 0.5, np.inf, np.abs(rng.normal(size=6)))
        if n % 3 == 0:  # rounding put a joint a hair beyond its stop
            lower[0], upper[0], upper[1] = -1.0, -1e-13, 0.0
        yield A, drive, qd, level, lower, upper


def test_the_solution_fulfils_the_equation_and_the_law_of_each_joint():
    for A, drive, qd, level, lower, upper in problems(3000, seed=1):
        delta, f = solve_friction(A, drive, qd, level, lower, upper)
        v = qd + delta
        size = np.abs(drive).max() + level.max() + np.abs(A * delta).max()
        np.testing.assert_allclose(A @ delta + f, drive, atol=1e-11 * size)
        rounding = 1e-12 * (np.abs(v).max() + np.abs(qd).max())
        assert (v >= lower - rounding).all() and (v <= upper + rounding).all()
        at_lower, at_upper = v <= lower + rounding, v >= upper - rounding
        moving = (np.abs(v) > rounding) & ~at_lower & ~at_upper
        np.testing.assert_allclose(f[moving], (np.sign(v) * level)[moving], atol=1e-11 * size)
        assert (f <= level + 1e-11 * size)[~at_upper].all()
        assert (f >= -level - 1e-11 * size)[~at_lower].all()


def test_it_is_the_least_of_the_convex_problem_that_it_claims_to_solve():
    rng = np.random.default_rng(2)
    for A, drive, qd, level, lower, upper in problems(200, seed=3):
        def cost(v, A=A, drive=drive, qd=qd, level=level):
            return 0.5 * v @ A @ v - (drive + A @ qd) @ v + level @ np.abs(v)

        best = qd + solve_friction(A, drive, qd, level, lower, upper)[0]
        for scale in 10.0 ** np.arange(-6.0, 2.0):
            other = np.clip(best + scale * rng.normal(size=6), lower, upper)
            assert cost(other) >= cost(best) - 1e-9 * (abs(cost(best)) + 1.0)


def test_friction_stops_a_motion_but_never_reverses_it():
    rng = np.random.default_rng(4)
    for _ in range(1000):
        inertia = np.diag(10.0 ** rng.uniform(-4.0, 1.0, 6)) / 1e-3
        qd, level = rng.normal(size=6), 10.0 ** rng.uniform(-3.0, 3.0, 6)
        delta, _ = solve_friction(inertia, np.zeros(6), qd, level, -NO_STOP, NO_STOP)
        assert (np.sign(qd + delta) * np.sign(qd) >= 0.0).all()
        assert (np.abs(qd + delta) <= np.abs(qd)).all()


def test_without_friction_and_stops_it_is_the_plain_solution():
    for A, drive, qd, *_ in problems(100, seed=5):
        delta, f = solve_friction(A, drive, qd, np.zeros(6), -NO_STOP, NO_STOP)
        rounding = 1e-13 * np.abs(A * delta).max()
        np.testing.assert_allclose(A @ delta, drive, rtol=0.0, atol=rounding)
        assert not f.any()


def test_the_brake_leaves_less_energy_than_any_other_torque_within_the_limits():
    rng = np.random.default_rng(6)
    for A, drive, qd, *_ in problems(200, seed=7):
        limit = np.abs(drive).max() * 10.0 ** rng.uniform(-2.0, 1.0, 6)
        delta, _ = solve_friction(A, drive, qd, limit, -NO_STOP, NO_STOP)
        v = qd + delta
        for _ in range(100):
            tau = rng.uniform(-limit, limit) * rng.choice([1.0, 10.0])
            w = qd + np.linalg.solve(A, drive + np.clip(tau, -limit, limit))
            assert v @ A @ v <= w @ A @ w * (1.0 + 1e-9) + 1e-9


@pytest.mark.parametrize('joint', range(6))
def test_a_stop_lets_a_joint_come_to_it_exactly_and_not_further(joint):
    lower, upper = -NO_STOP.copy(), NO_STOP.copy()
    upper[joint] = 0.25
    delta, f = solve_friction(np.eye(6), np.full(6, 10.0), np.zeros(6), np.zeros(6), lower, upper)
    assert delta[joint] == 0.25
    assert f[joint] == pytest.approx(9.75)
    np.testing.assert_allclose(np.delete(delta, joint), 10.0)
