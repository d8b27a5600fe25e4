"""Recordings of other tools: what is healthy passes, what was left out is counted and placed."""

from dataclasses import replace

import numpy as np
import pytest
from foreign_recordings import (
    GRIPPER,
    STATES,
    arm_messages,
    gravity,
    gripper_messages,
    message,
    motion,
    remarks,
)

from ur5_ros.cdr.fixed_messages import encode
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES


def test_a_healthy_recording_passes_without_a_remark(judged, made):
    result = judged(arm_messages(made))
    assert result.verdict == 'pass' and not result.about['remarks'] and not result.causes
    assert result.headline == 'pass; controller not judged'
    assert result.check('effort').verdict == 'pass'
    assert result.check('kinematics').verdict == 'pass'


@pytest.mark.parametrize('first', [True, False])
def test_a_gripper_on_the_topic_is_counted_and_passed_over(judged, made, first):
    arm, gripper = arm_messages(made), gripper_messages(made)
    if not first:
        gripper = [(time + 1_000_000, data) for time, data in gripper]
    result = judged(arm + gripper)
    assert result.verdict == 'pass'
    assert f'{len(gripper)} messages of /joint_states, of {len(arm + gripper)}' in remarks(result)


def test_a_gripper_joint_within_the_message_is_left_out(judged, made):
    messages = [(int(stamp), message(stamp, (*JOINT_NAMES, *GRIPPER), [*made.q[k], 0.1],
                                     [*made.qd[k], 0.0], [*made.effort[k], 0.0]))
                for k, stamp in enumerate(made.stamp)]
    assert judged(messages).verdict == 'pass'


def test_a_name_without_a_value_behind_the_joints_does_no_harm(judged, made):
    messages = [(int(stamp), message(stamp, (*JOINT_NAMES, 'g'), made.q[k], made.qd[k],
                                     made.effort[k])) for k, stamp in enumerate(made.stamp)]
    assert judged(messages).verdict == 'pass'


@pytest.mark.parametrize('row', [0, 350])
def test_an_empty_message_is_counted_and_passed_over(judged, made, row):
    messages = arm_messages(made)
    messages[row] = (messages[row][0], message(made.stamp[row]))
    result = judged(messages)
    assert result.verdict == 'pass' and '1 message of /joint_states' in remarks(result)
    assert result.about['states'] == len(messages) - 1


@pytest.mark.parametrize('hand', ['/hand/joint_states', '/a/very/much/longer/joint_states'])
def test_the_topic_that_holds_the_six_joints_is_taken(judged, made, hand):
    result = judged({hand: gripper_messages(made, 1), '/ur/joint_states': arm_messages(made)})
    assert result.verdict == 'pass' and result.about['states'] == len(made.stamp)


def test_a_topic_of_any_name_that_holds_the_six_joints_is_taken(judged, made):
    assert judged({'/robot/feedback': arm_messages(made)}).verdict == 'pass'


def test_of_two_topics_with_the_six_joints_one_is_taken_and_the_choice_is_said(judged, made):
    other = made.with_(effort=np.zeros_like(made.effort))
    topics = {'/a/joint_states': arm_messages(made), '/b/joint_states': arm_messages(other)}
    assert '--topic joint_states=NAME' in remarks(judged(topics))


def test_the_user_chooses_the_topic(judged, made):
    other = made.with_(effort=2.0 * made.effort)
    topics = {'/a/joint_states': arm_messages(made), '/b/joint_states': arm_messages(other)}
    result = judged(topics, topics={'joint_states': '/b/joint_states'})
    assert result.check('inverse dynamics').verdict == 'fail'


@pytest.mark.parametrize('topics, match', [
    ({'joint_states': '/absent'},
     'no topic /absent for joint_states; there are: /grip, /joint_states'),
    ({'reference': STATES}, 'not trajectory_msgs/msg/JointTrajectory'),
    ({'joint_command': '/grip'}, 'of the six joints')])
def test_a_topic_that_is_not_the_role_is_refused_with_the_choices(judged, made, topics, match):
    with pytest.raises(InputError, match=match):
        judged({STATES: arm_messages(made), '/grip': gripper_messages(made)}, topics=topics)


def two_arms(made, prefixes=('left_', 'right_')):
    other = motion('ur3e')
    names = [prefix + name for prefix in prefixes for name in JOINT_NAMES]
    return [(int(stamp), message(stamp, names, *(np.concatenate([getattr(each, part)[k] for each in
             (made, other)]) for part in ('q', 'qd', 'effort'))))
            for k, stamp in enumerate(made.stamp)]


def test_of_two_arms_in_one_message_one_is_taken_and_the_prefixes_are_said(judged, made):
    result = judged(two_arms(made))
    assert result.verdict == 'pass'
    assert "'left_', 'right_'" in remarks(result) and '--joint-prefix' in remarks(result)


def test_the_user_chooses_the_arm_by_its_prefix(judged, made):
    result = judged(two_arms(made), arm='ur3e', joint_prefix='right_')
    assert result.verdict == 'pass' and not result.about['remarks']


def test_a_prefix_that_does_not_exist_is_refused_with_those_that_do(judged, made):
    with pytest.raises(InputError, match="'middle_'.*'left_', 'right_'"):
        judged(two_arms(made), joint_prefix='middle_')


@pytest.mark.parametrize('topic, kind, fields', [
    ('/diff_drive_controller/reference', 'geometry_msgs/msg/PoseStamped', {}),
    ('/object/ground_truth', 'geometry_msgs/msg/PoseStamped', {}),
    ('/x/events', 'std_msgs/msg/String', {'data': 'hello'}),
    ('/gripper/joint_command', 'std_msgs/msg/Float64MultiArray', {})])
def test_a_topic_that_ends_like_a_role_and_is_another_thing_is_not_that_role(
        judged, made, topic, kind, fields):
    other = [(int(stamp), encode(kind, fields)) for stamp in made.stamp[::10]]
    result = judged({STATES: arm_messages(made), topic: other}, {topic: kind})
    assert result.verdict == 'pass' and topic in remarks(result)


def test_events_of_another_tool_are_not_the_simulators(judged, made):
    kind = 'diagnostic_msgs/msg/DiagnosticArray'
    event = encode(kind, {'status': [{'name': 'x', 'values': [{'key': 'a', 'value': 'no json'}]}]})
    result = judged({STATES: arm_messages(made), '/x/events': [(int(made.stamp[5]), event)]},
                    {'/x/events': kind})
    assert result.verdict == 'pass' and '/x/events' in remarks(result)


@pytest.mark.parametrize('fields', [('position',), ('position', 'effort')])
def test_commands_of_positions_are_no_torque_commands(judged, made, fields):
    commands = arm_messages(made.with_(effort=0.0 * made.effort), fields)[::5]
    result = judged({STATES: arm_messages(made), '/joint_command': commands})
    assert result.verdict == 'pass'
    assert result.check('pairing').verdict == 'not applicable'


@pytest.mark.parametrize('rows', [range(5), range(300, 303), [0, 10, 20, 699]])
def test_rows_that_hold_no_number_are_dropped_counted_and_placed(judged, made, rows):
    q = made.q.copy()
    q[list(rows)] = np.nan
    result = judged(arm_messages(made.with_(q=q, qd=np.where(np.isnan(q), np.nan, made.qd))))
    assert result.verdict == 'pass'
    assert result.about['states'] == len(made.stamp) - len(rows)
    first, last = made.t[min(rows)], made.t[max(rows)]
    assert (f'{len(rows)} states of 700 hold a value that is not a number, from {first:.4g} s to '
            f'{last:.4g} s: dropped') in remarks(result)


@pytest.mark.parametrize('effort', [None, np.nan, 0.0])
def test_without_a_torque_kinematics_and_timing_are_judged(judged, made, effort):
    fields = ('position', 'velocity', 'effort')[:2 if effort is None else 3]
    filled = made.with_(effort=np.full_like(made.effort, 0.0 if effort is None else effort))
    result = judged(arm_messages(filled, fields))
    assert result.verdict == 'pass' and 'no torque is recorded' in remarks(result)
    for name, verdict in (('kinematics', 'pass'), ('timing', 'pass'),
                          ('effort', 'not applicable'), ('inverse dynamics', 'not applicable')):
        assert result.check(name).verdict == verdict


def test_velocities_in_degrees_are_noticed(judged, made):
    result = judged(arm_messages(made.with_(qd=np.degrees(made.qd)), ('position', 'velocity')))
    assert result.check('kinematics').verdict == 'fail'


def test_a_missing_velocity_is_differentiated_and_said(judged, made):
    result = judged(arm_messages(made, ('position', 'effort')))
    assert result.verdict == 'pass' and 'differentiated from the positions' in remarks(result)


def test_a_second_publisher_without_velocities_is_named(judged, made):
    zeros = [(int(stamp) + 350_000, message(stamp + 50_000, JOINT_NAMES, np.zeros(6)))
             for stamp in made.stamp[4::26]]
    result = judged(arm_messages(made) + zeros)
    assert result.verdict == 'pass'
    assert f'{len(zeros)} states of {700 + len(zeros)} are of another source that interleaves' in (
        remarks(result))


@pytest.mark.parametrize('offset', [-1.0, 0.3])
def test_positions_that_their_velocities_cannot_explain_are_dropped(judged, made, offset):
    q, qd, effort = made.q.copy(), made.qd.copy(), made.effort.copy()
    rows = np.arange(7, 700, 50)
    q[rows], qd[rows], effort[rows] = q[rows] + offset, 0.0, 0.0
    result = judged(arm_messages(made.with_(q=q, qd=qd, effort=effort)))
    assert result.verdict == 'pass', [c.sentence for c in result.checks if c.verdict == 'fail']
    assert f'{len(rows)} states of 700 are of another source' in remarks(result)


def test_intermittent_zeros_are_another_source(judged, made):
    q, qd, effort = made.q.copy(), made.qd.copy(), made.effort.copy()
    for part in (q, qd, effort):
        part[20::40] = 0.0
    result = judged(arm_messages(made.with_(q=q, qd=qd, effort=effort)))
    assert result.verdict == 'pass' and '17 states of 700' in remarks(result)


def test_a_jump_that_stays_fails_and_is_placed(judged, made):
    q = made.q.copy()
    q[400:] += 0.5
    result = judged(arm_messages(made.with_(q=q)))
    assert result.check('recording').verdict == 'fail'
    assert 'jump at 0.8 s' in result.check('recording').sentence


def test_a_wrist_that_wraps_at_a_whole_turn_is_made_continuous(judged):
    made = motion(n=2000)
    turned = made.q[:, 5] - 0.4 + np.pi
    q = made.q.copy()
    q[:, 5] = (turned + np.pi) % (2 * np.pi) - np.pi
    base = made.with_(q=np.column_stack([made.q[:, :5], turned]))
    assert np.abs(np.diff(q[:, 5])).max() > 6.0
    result = judged(arm_messages(made.with_(q=q)))
    assert 'wrap' in remarks(result)
    assert result.check('kinematics').verdict == 'pass'
    assert base.q.shape == q.shape


def test_zero_stamps_give_way_to_the_log_time(judged, made):
    messages = [(int(stamp), message(0, JOINT_NAMES, made.q[k], made.qd[k], made.effort[k]))
                for k, stamp in enumerate(made.stamp)]
    result = judged(messages)
    assert result.verdict == 'pass' and 'the log time was used' in remarks(result)
    assert result.about['duration_s'] == pytest.approx(1.398)


def test_a_few_zero_stamps_and_repeated_ones_are_dropped_and_counted(judged, made):
    stamp = made.stamp.copy()
    stamp[:2], stamp[101:106] = 0, stamp[100]
    result = judged(arm_messages(made.with_(stamp=stamp)))
    assert '2 states of 700 have a stamp of zero: dropped' in remarks(result)
    assert '5 states of 698 repeat a stamp' in remarks(result)
    assert result.about['states'] == 693


def test_states_without_a_stamp_are_no_gaps_of_the_recorder(judged, made):
    stamp = np.where(np.arange(700) % 10 == 3, 0, made.stamp)
    messages = [(int(each) + 300_000, message(stamp[k], JOINT_NAMES, made.q[k], made.qd[k],
                                              made.effort[k]))
                for k, each in enumerate(made.stamp)]
    result = judged(messages)
    assert result.verdict == 'pass' and '70 states of 700 have a stamp of zero' in remarks(result)


@pytest.mark.parametrize('row, stamp', [(0, 5_000_000_000), (699, 2_000_000_000_000_000_000)])
def test_a_stamp_far_from_all_others_is_dropped(judged, made, row, stamp):
    stamps = made.stamp.copy()
    stamps[row] = stamp
    result = judged(arm_messages(made.with_(stamp=stamps)))
    assert result.verdict == 'pass' and 'a stamp far from all others' in remarks(result)


def test_efforts_missing_in_between_are_no_other_source(judged, made):
    effort = made.effort.copy()
    effort[100:110] = np.nan
    result = judged(arm_messages(made.with_(effort=effort)))
    assert result.verdict == 'pass' and '10 states of 700 hold a value that is not a number' in (
        remarks(result))


def test_jitter_is_reported_with_its_size_and_is_no_gap(judged, made):
    random = np.random.default_rng(3)
    stamp = made.stamp + np.rint(random.normal(0.0, 150_000, 700)).astype(np.int64)
    result = judged(arm_messages(made.with_(stamp=np.sort(stamp))))
    assert result.verdict == 'pass'
    assert result.check('timing').details['jitter_s'] == pytest.approx(0.15e-3 * 2**0.5, rel=0.2)
    assert 'jitter by 0.2' in remarks(result)


def test_missing_states_are_gaps(judged, made):
    messages = arm_messages(made)
    result = judged(messages[:300] + messages[310:])
    check = result.check('timing')
    assert check.verdict == 'fail' and check.value == 1 and 'after 0.598 s' in check.sentence


def test_an_arm_at_rest_is_judged_by_its_gravity(judged):
    result = judged(arm_messages(motion(still=True)))
    assert result.verdict == 'pass' and result.check('inverse dynamics').verdict == 'pass'


def test_an_arm_at_rest_with_another_torque_fails_without_a_traceback(judged):
    made = motion(still=True)
    result = judged(arm_messages(made.with_(effort=1.2 * made.effort)))
    assert result.check('inverse dynamics').verdict == 'fail' and result.causes


def test_no_gravity_is_named_that_a_real_robot_cannot_have(judged):
    made = motion(still=True)
    result = judged(arm_messages(made.with_(
        effort=made.effort + np.array([0.0, -5.0, -2.0, 0.3, 0.0, 0.0]))))
    assert result.verdict == 'fail' and result.causes
    for cause in result.causes:
        if 'gravity' in cause:
            assert 9.6 < np.linalg.norm(cause['gravity']) < 10.0


def test_a_robot_on_the_ceiling_is_recognised_by_the_direction_of_its_gravity(judged):
    hung = replace(load_arm('ur5e'), gravity=np.array([0.0, 0.0, 9.81]))
    result = judged(arm_messages(motion(hung, n=3000)))
    assert result.causes[0]['kind'] == 'gravity'
    np.testing.assert_allclose(result.causes[0]['gravity'], [0.0, 0.0, 9.81], atol=0.05)


@pytest.mark.parametrize('jumps, rows', [([-0.3], [350]), ([-3600.0], [350]), ([3600.0], [10]),
                                         ([5.0, -5.0], [200, 300])])
def test_a_jump_of_the_clock_is_taken_out_by_the_log_time(judged, made, jumps, rows):
    stamp = made.stamp.copy()
    for size, row in zip(jumps, rows, strict=True):
        stamp[row:] += round(size * 1e9)
    messages = [(int(logged) + 300_000, message(stamp[k], JOINT_NAMES, made.q[k], made.qd[k],
                                                made.effort[k]))
                for k, logged in enumerate(made.stamp)]
    result = judged(messages)
    assert result.verdict == 'pass' and result.about['states'] == 700
    assert f'the clock of the stamps jumps by {jumps[0]:.4g} s' in remarks(result)
    assert result.about['duration_s'] == pytest.approx(1.398, abs=1e-3)


def test_a_pause_that_stamps_and_log_share_stays_a_gap(judged, made):
    stamp = made.stamp + np.where(np.arange(700) < 350, 0, 2_000_000_000)
    assert judged(arm_messages(made.with_(stamp=stamp))).check('timing').verdict == 'fail'


def test_messages_that_are_recorded_twice_count_once(judged, made):
    messages = arm_messages(made)
    result = judged(messages + [(time + 100, data) for time, data in messages])
    assert result.verdict == 'pass' and '700 states of 1400 repeat a stamp' in remarks(result)


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('size', [0.3e6, 0.45e6])
def test_strong_jitter_is_no_gap_and_a_missing_state_still_is(judged, made, seed, size):
    random = np.random.default_rng(seed)
    stamp = np.sort(made.stamp + np.rint(random.normal(0.0, size, 700)).astype(np.int64))
    messages = arm_messages(made.with_(stamp=stamp))
    if seed % 2:
        del messages[400:403]
    check = judged(messages).check('timing')
    assert check.verdict == ('fail' if seed % 2 else 'pass'), check.sentence


@pytest.mark.parametrize('velocity', [True, False])
def test_a_publisher_that_fills_in_zeros_for_the_torque_is_counted(judged, made, velocity):
    zeros = [(int(made.stamp[k]) + 350_000, message(
        made.stamp[k] + 1_000_000, JOINT_NAMES, made.q[k], made.qd[k] * velocity, np.zeros(6)))
        for k in range(3, 700, 5)]
    result = judged(arm_messages(made) + zeros)
    assert result.verdict == 'pass' and result.check('inverse dynamics').verdict == 'pass'
    assert '140 states of 840 have an effort of zero in every joint' in remarks(result)


def test_zeros_for_a_velocity_between_states_that_move_are_counted(judged, made):
    zeros = [(int(made.stamp[k]) + 350_000, message(
        made.stamp[k] + 1_000_000, JOINT_NAMES, made.q[k], np.zeros(6)))
        for k in range(3, 700, 5)]
    result = judged(arm_messages(made, ('position', 'velocity')) + zeros)
    assert result.verdict == 'pass' and 'have a velocity of zero between' in remarks(result)
    assert result.check('kinematics').value < 1e-3


def test_a_faster_publisher_without_torque_does_not_hide_the_one_with_it(judged, made):
    positions = [(int(made.stamp[k]) + 350_000, message(
        made.stamp[k] + 1_000_000, JOINT_NAMES, made.q[k])) for k in range(700)]
    result = judged(arm_messages(made)[::5] + positions)
    assert result.verdict == 'pass' and result.check('inverse dynamics').verdict == 'pass'
    assert '700 states of 840 are of another source' in remarks(result)


def test_a_torque_that_begins_late_is_judged_from_there(judged, made):
    effort = made.effort.copy()
    effort[:400] = np.nan
    result = judged(arm_messages(made.with_(effort=effort)))
    assert result.verdict == 'pass' and result.about['states'] == 700
    assert result.check('inverse dynamics').verdict == 'pass'
    assert 'torque is recorded in 300 of 700 states' in remarks(result)


@pytest.mark.parametrize('joints', [range(6), [3]])
def test_a_velocity_of_zero_of_joints_that_move_is_differentiated(judged, made, joints):
    qd = made.qd.copy()
    qd[:, joints] = 0.0
    result = judged(arm_messages(made.with_(qd=qd)))
    assert result.verdict == 'pass' and 'is zero although the positions change' in remarks(result)


@pytest.mark.parametrize('field, value', [('q', 1e300), ('qd', 500.0), ('effort', -1e300)])
def test_a_value_that_no_arm_can_have_is_dropped_and_counted(judged, made, field, value):
    values = getattr(made, field).copy()
    values[5, 3] = value
    result = judged(arm_messages(made.with_(**{field: values})))
    assert result.verdict == 'pass' and result.about['states'] == 699
    assert '1 state of 700 holds a value that no arm can have' in remarks(result)


def test_positions_in_degrees_are_refused_with_joint_and_value(judged, made):
    with pytest.raises(InputError, match=r'shoulder_pan_joint is at \d+.* rad .*degrees'):
        judged(arm_messages(made.with_(q=np.degrees(made.q), qd=np.degrees(made.qd))))


def test_fewer_efforts_than_names_leave_the_other_fields(judged, made):
    names = ('rail', 'finger', *JOINT_NAMES)
    zero = np.zeros(2)
    messages = [(int(stamp), message(stamp, names, [*zero, *made.q[k]], [*zero, *made.qd[k]],
                                     made.effort[k])) for k, stamp in enumerate(made.stamp)]
    result = judged(messages)
    assert result.check('kinematics').verdict == 'pass'
    assert result.check('inverse dynamics').verdict == 'not applicable'
    assert 'have fewer values of effort than names' in remarks(result)


def test_the_prefix_chooses_the_topic_too(judged, made):
    topics = {'/l/joint_states': arm_messages(made, prefix='left_'),
              '/r/joint_states': arm_messages(motion('ur3e'), prefix='right_')}
    assert judged(topics, arm='ur3e', joint_prefix='right_').verdict == 'pass'


def test_a_prefix_on_no_topic_is_refused_with_those_of_all_topics(judged, made):
    topics = {'/l/joint_states': arm_messages(made, prefix='left_'),
              '/r/joint_states': arm_messages(motion('ur3e'), prefix='right_')}
    with pytest.raises(InputError, match="'up_'.*'left_', 'right_'"):
        judged(topics, joint_prefix='up_')


def test_names_that_stand_twice_are_the_reason_of_the_refusal(judged, made):
    names = (*JOINT_NAMES, JOINT_NAMES[0])
    messages = [(int(stamp), message(stamp, names, [*made.q[k], made.q[k, 0]]))
                for k, stamp in enumerate(made.stamp)]
    with pytest.raises(InputError, match='no joint states in it.*joint names missing or twice'):
        judged(messages)


def test_velocities_in_degrees_are_named_so(judged, made):
    result = judged(arm_messages(made.with_(qd=np.degrees(made.qd))))
    assert 'look like degrees a second' in result.check('kinematics').sentence
    # the torque of such velocities is that of no arm, so no other arm is named for it
    assert [cause['kind'] for cause in result.causes] == ['kinematics']


@pytest.mark.parametrize('value', [np.inf, -np.inf, 1.7e308, np.nan])
def test_an_effort_of_no_number_throughout_is_no_torque(judged, made, value, recwarn):
    result = judged(arm_messages(made.with_(effort=np.full((700, 6), value))))
    assert result.verdict == 'pass' and 'no torque is recorded' in remarks(result)
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


def test_single_values_far_beyond_the_others_are_dropped_and_leave_no_gap(judged, made):
    effort = made.effort.copy()
    effort[[100, 103, 110, 400, 650], [0, 1, 2, 3, 5]] = 1e6
    result = judged(arm_messages(made.with_(effort=effort)))
    assert result.verdict == 'pass' and result.check('timing').value == 0.0
    assert '5 states of 700 hold a value that no arm can have' in remarks(result)


def test_without_the_effort_of_one_joint_the_rest_is_judged_and_said(judged, made):
    effort = made.effort.copy()
    effort[:, 3] = np.nan
    result = judged(arm_messages(made.with_(effort=effort)))
    assert result.verdict == 'pass' and 'no effort of wrist_1_joint is measured' in remarks(result)
    assert 'no torque is recorded' not in remarks(result)


def test_stamps_before_zero_are_dropped_and_said(judged, made):
    early = made.with_(stamp=made.stamp - made.stamp[0] - 200_000_000)
    result = judged([(time, data) for (time, _), (_, data) in
                     zip(arm_messages(made), arm_messages(early), strict=True)])
    assert '101 states of 700 have a stamp of zero or less' in remarks(result)


def test_efforts_too_small_for_a_number_are_no_torque(judged, made, recwarn):
    result = judged(arm_messages(made.with_(effort=np.full((700, 6), 1e-310))))
    assert result.verdict == 'pass' and 'no torque is recorded' in remarks(result)
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


def test_states_too_far_apart_for_their_motion_are_not_judged_by_it(judged):
    result = judged(arm_messages(motion(n=400, rate=1.0)))
    for name in ('kinematics', 'effort', 'inverse dynamics'):
        assert result.check(name).verdict == 'not applicable'
        assert '1 states a second are too few for this motion' in result.check(name).sentence
    assert result.check('evidence').verdict == 'fail' and not result.causes
    assert judged_slowly(judged).verdict == 'pass'


def judged_slowly(judged):
    """Return the result of a motion that is slow enough for one state a second."""
    made = motion(n=400, rate=100.0)
    slow = made.with_(stamp=made.stamp[0] + 100 * (made.stamp - made.stamp[0]), qd=made.qd / 100.0,
                      effort=gravity(made))
    return judged({STATES: arm_messages(slow)})


@pytest.mark.parametrize('every', [2, 5])
def test_commands_at_a_lower_rate_than_the_states_act_on_and_are_no_measurement(
        judged, made, every):
    commands = [(int(made.stamp[k]) + 400_000, message(
        made.stamp[k], JOINT_NAMES, effort=made.effort[k] + 0.5)) for k in range(0, 700, every)]
    result = judged({STATES: arm_messages(made), '/joint_command': commands})
    assert result.verdict == 'pass'
    assert 'at their own rate' in result.check('pairing').sentence
    assert 'a robot measures its torque' in result.check('command acts').sentence


@pytest.mark.parametrize('noise', [1e-3, 3e-3])
def test_noise_of_joints_that_hardly_move_is_no_error_of_their_velocities(judged, noise):
    made = motion(n=2000)
    small = made.with_(q=made.q[0] + 0.01 * (made.q - made.q[0]), qd=0.01 * made.qd)
    random = np.random.default_rng(8)
    result = judged(arm_messages(small.with_(
        q=small.q + random.normal(0.0, 0.05 * noise, small.q.shape),
        qd=small.qd + random.normal(0.0, noise, small.q.shape), effort=gravity(small))))
    assert result.check('kinematics').verdict == 'pass' and not result.causes
