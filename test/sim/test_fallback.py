"""Nobody commands: the arm stops, stands, or falls, as it was told."""

import json

import numpy as np
import pytest

#: Stretched, joints 2 to 4 lowering: the worst pose known, for torque is limited to 150 N m.
STRETCHED = [0.0, 0.0, 0.0, 0.0, -1.0, 0.0]


def poses(number, seed):
    """Yield random poses with speeds up to 1 rad/s, the worst known first."""
    rng = np.random.default_rng(seed)
    yield STRETCHED, [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    yield STRETCHED, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    for _ in range(number):
        yield rng.uniform(-3.0, 3.0, 6).tolist(), rng.choice([-1.0, 1.0], 6).tolist()


@pytest.mark.fault(11)
@pytest.mark.parametrize('arm', ['ur5', 'ur5_real'])
def test_the_brake_stops_the_arm_within_a_twentieth_of_a_radian_from_anywhere(
        plant_of, arm, record_property):
    longest = 0.0
    for q, qd in poses(40, seed=31):
        plant = plant_of(arm=arm, initial_positions=q, initial_velocities=qd)
        for _ in range(300):
            state = plant.step(None)
            assert (np.abs(state.effort) <= plant.arm.limits.effort).all()
            if np.abs(state.qd).max() < 1e-12:
                break
        assert np.abs(state.qd).max() < 1e-9, 'at rest'
        longest = max(longest, np.abs(state.q - q).max())
    record_property('joint travel under the brake, any pose at 1 rad/s [rad]', float(longest))
    assert longest < 0.05
    assert longest == pytest.approx({'ur5': 0.033, 'ur5_real': 0.040}[arm], abs=5e-4)


@pytest.mark.parametrize('arm', ['ur5', 'ur5_real'])
@pytest.mark.parametrize('mode', ['brake', 'gravity_compensation'])
def test_the_arm_stands_still_for_ten_seconds(plant_of, arm, mode):
    plant = plant_of(arm=arm, fallback=mode)
    start = plant.truth.q
    for _ in range(10_000):
        state = plant.step(None)
    assert np.abs(state.q - start).max() < 1e-6


@pytest.mark.parametrize('arm', ['ur5', 'ur5_real'])
def test_the_brake_holds_for_ten_minutes(plant_of, arm, times, record_property):
    """One minute of them where the run is not a thorough one."""
    plant = plant_of(arm=arm, initial_positions=STRETCHED)
    start, worst = plant.truth.q, 0.0
    periods = times(60_000, 600_000)
    for _ in range(periods):
        state = plant.step(None)
        worst = max(worst, np.abs(state.q - start).max())
    record_property('periods under the brake', periods)
    record_property('drift under the brake [rad]', float(worst))
    assert worst < 1e-6


@pytest.mark.parametrize('mode', ['brake', 'gravity_compensation'])
def test_it_stands_whatever_hangs_pulls_or_tilts(plant_of, mode):
    plant = plant_of(fallback=mode, payload__mass=2.0, payload__com=[0.0, 0.05, 0.1],
                     gravity=[2.0, -1.0, -9.0], friction__coulomb=[1.0] * 6)
    if mode == 'brake':
        plant.apply_wrench([30.0, 10.0, -20.0], [1.0, 1.0, 1.0])
    start = plant.truth.q
    for _ in range(1000):
        state = plant.step(None)
    assert np.abs(state.q - start).max() < 1e-8


@pytest.mark.parametrize('rate', [20, 100, 1000])
def test_gravity_compensation_lets_motion_die_out_at_any_control_rate(plant_of, rate):
    plant = plant_of(fallback='gravity_compensation', control_rate=rate,
                     initial_velocities=[0.5] * 6)
    speeds = [np.abs(plant.step(None).qd).max() for _ in range(rate)]
    assert max(speeds) < 1.0
    assert speeds[-1] < 1e-6
    assert np.abs(plant.truth.q - plant.parameters.initial_positions).max() < 0.1


@pytest.mark.parametrize('rate', [10, 100, 500])
def test_the_brake_works_at_any_control_rate(plant_of, rate):
    plant = plant_of(control_rate=rate, initial_velocities=[0.5] * 6)
    for _ in range(2 * rate):
        state = plant.step(None)
    assert np.abs(state.qd).max() < 1e-9


def test_zero_torque_lets_the_arm_fall(plant_of):
    plant = plant_of(fallback='zero_torque')
    for _ in range(200):
        state = plant.step(None)
        assert not state.effort.any()
    assert np.abs(state.qd).max() > 1.0


def test_a_fallback_never_latches_and_reports_when_it_acts(plant_of):
    plant = plant_of()
    hold = plant.step(None).effort
    assert np.abs(hold).max() > 5.0, 'the torque of the fallback is told as effort'
    plant.step(hold)
    plant.step(None)
    plant.change('fallback', 'zero_torque')
    plant.step(None)
    reported = [(event.stamp, json.loads(event.values['mode']), json.loads(event.values['active']))
            for event in plant.drain_events() if event.kind == 'fallback']
    ms = 1_000_000
    assert reported == [(1 * ms, 'brake', True), (2 * ms, 'brake', False), (3 * ms, 'brake', True),
                    (4 * ms, 'zero_torque', True)]
    assert plant.counters['fallback_periods'] == 3
