"""States that cannot be right, clocks that jump, limits passed: held safely, and reported."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ur5_ros.control.computed_torque import computed_torque
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.control.gains import gains_from
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.control.tolerances import JointTolerance
from ur5_ros.control.torque_limits import limit_torque
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES, ArmState

RATE = 500
HOME = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
ZERO = np.zeros(6)


def state(k, q=HOME, qd=ZERO):
    return ArmState(k * 2_000_000, np.array(q, dtype=float), np.array(qd, dtype=float), ZERO)


def in_motion():
    """Return a controller that has begun to move every joint by half a radian."""
    controller = controller_from_parameters({}, RATE)
    controller.update(state(1))
    controller.target_joints(JOINT_NAMES, HOME + 0.5)
    return controller


def same(one, two):
    return all(a.tobytes() == b.tobytes() for a, b in
               zip((*one.torque, *one.reference), (*two.torque, *two.reference), strict=True))


def test_a_copy_of_a_state_gets_the_same_answer_and_moves_nothing_on():
    one, two = in_motion(), in_motion()
    for k in range(2, 200):
        answer = one.update(state(k))
        assert one.update(state(k)) is answer
        assert one.update(state(k, HOME + 0.01)) is answer
        assert same(answer, two.update(state(k)))


def test_a_single_state_that_jumps_is_not_accepted_and_the_motion_goes_on():
    one, two = in_motion(), in_motion()
    for k in range(2, 300):
        glitch = state(k, HOME + [0, 0, 2.0, 0, 0, 0]) if k == 100 else state(k)
        assert same(one.update(glitch), two.update(state(k)))
    assert one.status()['unbelieved_states'] == 1
    assert 'joint 3 jumped by 2.0000 rad' in one.status()['last_doubt']


@pytest.mark.parametrize('bad', [np.nan, np.inf, -np.inf])
def test_a_state_that_is_not_finite_is_answered_from_the_last_good_one(bad):
    controller = controller_from_parameters({}, RATE)
    good = controller.update(state(1))
    torn = HOME.copy()
    torn[2] = bad
    for torn_state in (state(2, torn), state(3, HOME, torn)):
        answer = controller.update(torn_state)
        assert np.all(np.isfinite(answer.torque.total))
        assert_allclose(answer.torque.total, good.torque.total)
    assert same(controller.update(state(4)), good)


def test_with_nothing_to_believe_there_is_no_answer():
    controller = controller_from_parameters({}, RATE)
    with pytest.raises(InputError, match='not finite .* at stamp 2000000 ns; not answered'):
        controller.update(state(1, HOME * np.nan))
    controller.update(state(2))
    for k in range(3, 13):
        controller.update(state(k, HOME * np.nan))
    with pytest.raises(InputError, match='not answered'):
        controller.update(state(13, HOME * np.nan))
    assert controller.update(state(14)).status == 'holding'


def test_an_arm_that_was_moved_is_held_where_it_is_now():
    controller = in_motion()
    for k in range(2, 100):
        controller.update(state(k))
    elsewhere = HOME - 1.0  # a reset of the simulator
    controller.update(state(100, elsewhere))
    answer = controller.update(state(101, elsewhere))
    assert_allclose(answer.reference.q, elsewhere)
    assert answer.status == 'holding'
    assert 'jumped by' in controller.status()['detail']


@pytest.mark.parametrize(('stamp', 'words'), [
    (1, 'clock went back by 0.198000 s'),
    (10_000, 'clock jumped ahead by 19.800000 s'),
])
def test_a_clock_that_jumps_ends_the_motion_and_the_arm_is_held(stamp, words):
    controller = controller_from_parameters({'experiment': 'joint_step', 'autostart': True}, RATE)
    for k in range(1, 101):
        controller.update(state(k))
    assert controller.status()['state'] == 'moving'
    answer = controller.update(state(stamp, HOME + 0.05))
    assert answer.status == 'holding'
    assert_allclose(answer.reference.q, HOME + 0.05)
    assert words in controller.status()['detail']


def test_states_missing_in_between_do_not_change_the_reference():
    every, third = in_motion(), in_motion()
    for k in range(2, 602):
        answer = every.update(state(k))
        if k % 3 == 1:
            assert same(third.update(state(k)), answer)


def test_it_says_when_states_are_missing_and_when_they_are_back():
    controller = controller_from_parameters({}, RATE)
    assert controller.status()['state'] == 'waiting for states'
    controller.update(state(1))
    assert controller.status()['state'] == 'holding'
    controller.lose_states()
    assert controller.status()['state'] == 'waiting for states'
    controller.update(state(2))
    assert controller.status()['state'] == 'holding'


@pytest.mark.parametrize('beyond', [
    state(50, [*HOME[:5], 6.3], ZERO),
    state(50, [*HOME[:5], 6.0], [0, 0, 0, 0, 0, 3.2]),
])
def test_a_joint_beyond_a_limit_stops_the_motion_until_something_new_is_asked(beyond):
    controller = controller_from_parameters({'max_velocity': [3.0]}, RATE)
    near = np.array([*HOME[:5], 6.0])
    controller.update(state(1, near))
    controller.target_joints(JOINT_NAMES, [*HOME[:5] + 1.0, 6.0])
    for k in range(2, 50):
        controller.update(state(k, near))
    last = controller.update(beyond)
    assert last.status == 'stopped by a limit'
    assert 'wrist_3_joint at' in controller.status()['detail']
    for k in range(51, 600):
        answer = controller.update(beyond._replace(stamp=k * 2_000_000))
        assert np.abs(answer.reference.qd - last.reference.qd).max() <= 2.0 / RATE + 1e-9
        last = answer
    assert answer.status == 'stopped by a limit'
    assert not answer.reference.qd.any()
    controller.target_joints(JOINT_NAMES, near)
    assert controller.update(state(600, beyond.q)).status == 'moving'


def test_the_status_is_made_of_numbers_and_texts():
    controller = controller_from_parameters({}, RATE)
    for _ in range(2):
        for value in controller.status().values():
            assert isinstance(value, str | int | float)
        controller.update(state(1))


def mishap(rng, k):
    """Return the state of period k: mostly near home, now and then what a robot should not do."""
    q, qd = HOME + 0.02 * rng.standard_normal(6), 0.1 * rng.standard_normal(6)
    joint = rng.integers(6)
    match rng.integers(12):
        case 0:
            q[joint] += rng.choice([-3.0, 3.0])
        case 1:
            qd[joint] = rng.choice([-4.0, 4.0])  # faster than any limit of the UR5
        case 2:
            q[joint] = rng.choice([np.nan, np.inf])
        case 3:
            qd[joint] = rng.choice([np.nan, -np.inf, 1e300])
        case 4:
            q += 2.0 * rng.standard_normal(6)  # moved, if the next one confirms it
    return state(k, q, qd)


def outcome(controller, given):
    try:
        answer = controller.update(given)
    except InputError as refusal:
        return str(refusal)
    return (answer.stamp, answer.parts.tobytes(), answer.status, answer.limited,
            *(part.tobytes() for part in answer.reference))


def accepts(request, *arguments):
    try:
        request(JOINT_NAMES, *arguments)
    except InputError:
        return False
    return True


UNLIMITED = [JointTolerance(name, -1.0, -1.0, -1.0) for name in JOINT_NAMES]


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('gain', [10.0, 4000.0])  # the greater one meets the effort limits
@pytest.mark.parametrize('given', [{}, {'effort_convention': 'gravity_excluded'},
                                   {'torque_rate_limit': 1e4}], ids=str)
def test_a_period_with_all_checks_and_one_without_give_equal_bits(seed, gain, given):
    given = {'kp': [gain], 'kd': [2.0 * gain ** 0.5], 'experiment': ''} | given
    plain, watched = (controller_from_parameters(given, RATE) for _ in range(2))
    rng = np.random.default_rng(seed)
    compared = limited = 0
    for k in range(1, 600):
        at = k + (600 if k == 300 else 0)  # once the clock jumps ahead, and then back
        now = mishap(rng, at)
        assert outcome(plain, now) == outcome(watched, now)
        if plain.last[1] is None:
            continue
        if k % 60 == 1:
            points = [TrajectoryPoint(2_000_000_000, (HOME + 0.3 * rng.random()).tolist())]
            # a goal with tolerances has every period checked
            assert accepts(plain.joint_trajectory, points) == accepts(
                watched.follow_joint_trajectory, points, 0, UNLIMITED, UNLIMITED, -1.0)
        accepted, output = plain.last
        if 'torque_rate_limit' in given:
            continue
        whole = computed_torque(accepted, output.reference, plain.arm,
                                gains_from(given['kp'], given['kd']))
        added = whole.gravity if given.get('effort_convention') else np.zeros(6)
        total = whole.total if not added.any() else sum(whole[1:4])
        total, names = limit_torque(total, added, plain.arm.limits.effort, np.zeros(6), np.inf)
        assert output.limited == names
        assert output.torque.total.tobytes() == total.tobytes()
        compared, limited = compared + 1, limited + bool(names)
    status = plain.status()
    del status['detail']
    assert status.items() <= watched.status().items()
    assert 'torque_rate_limit' in given or compared > 300
    assert gain == 10.0 or status['limited_periods'] > 100
