import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.config.experiments import list_experiments, load_experiment
from ur5_ros.control.experiment import experiment_trajectory, initial_positions
from ur5_ros.control.tool_motion import singularity_distance
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.regressor import dynamics_regressor
from ur5_ros.signals import stamp_of_period

RATE = 500
SMOOTH = [name for name in list_experiments() if name != 'joint_step']
TEXT = """
name: mine
description: a step
source: assumed
kind: joint_step
duration: 2.0
at: 0.5
step: [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
start_degrees: [0.0, -90.0, 90.0, -90.0, -90.0, 0.0]
"""


def experiment_of(folder, text='', **fields):
    """Return the experiment of a text, or of a kind with these fields."""
    about = {'name': 'mine', 'description': 'for a test', 'source': 'assumed'}
    path = folder / 'mine.yaml'
    path.write_text(text or yaml.safe_dump(about | fields))
    return load_experiment(str(path))


def table(name, arm_name='ur5', rate=RATE):
    spec = load_experiment(name)
    motion = experiment_trajectory(spec, load_arm(arm_name), rate, 0.02).trajectory
    times = np.arange(int(spec.duration * rate) + 1)
    rows = [motion.at(int(i) * 1_000_000_000 // rate) for i in times]
    return times / rate, *(np.array(part) for part in zip(*rows, strict=True))


@pytest.mark.parametrize('name', SMOOTH)
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(name):
    _, q, qd, qdd = table(name)
    h = 1.0 / RATE
    assert_allclose((q[2:] - q[:-2]) / (2 * h), qd[1:-1], atol=2e-5)
    # the third derivative of a quintic ramp jumps where it begins and ends
    assert np.mean(np.abs((qd[2:] - qd[:-2]) / (2 * h) - qdd[1:-1])) < 2e-5
    assert_allclose((qd[2:] - qd[:-2]) / (2 * h), qdd[1:-1], atol=2e-2)


@pytest.mark.parametrize('name', list_experiments())
@pytest.mark.parametrize('arm_name', ['ur5', 'ur5_kebria2016', 'ur5e', 'ur10e'])
def test_every_experiment_can_be_run_by_every_arm_of_its_size(name, arm_name):
    arm = load_arm(arm_name)
    t, q, qd, _ = table(name, arm_name, 100)
    assert np.all(np.abs(qd) < arm.limits.velocity)
    assert np.all((q > arm.limits.lower) & (q < arm.limits.upper))
    if load_experiment(name).kind.startswith('tool'):
        assert singularity_distance(q, arm).min() > 0.02


@pytest.mark.parametrize('name', SMOOTH)
def test_smooth_experiments_begin_at_rest(name):
    _, _, qd, qdd = table(name)
    assert_allclose(qd[0], 0.0, atol=1e-12)
    assert_allclose(qdd[0], 0.0, atol=1e-12)


def test_the_papers_profile_is_the_one_described():
    # the closed form written a second time, poses compared through forward kinematics
    arm = load_arm('ur5')
    t, q, _, _ = table('kebria_fig11')
    start = forward_kinematics(np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0]), arm)
    omega = 2.0 * np.pi / 10.0
    x = np.minimum(t / 2.0, 1.0)
    w = x**3 * (10 - 15 * x + 6 * x**2)
    p = start[:3, 3] + w[:, None] * np.stack(
        [0.1 * np.sin(omega * t), 0.1 * np.cos(omega * t), 0.06 * np.sin(2 * omega * t)], axis=-1)
    c, b, a = (0.25 * w * np.sin(omega * t), 0.15 * w * np.sin(2 * omega * t),
               0.2 * w * np.sin(omega * t))
    pose = forward_kinematics(q, arm)
    assert_allclose(pose[:, :3, 3], p, atol=1e-12)
    for i in range(0, t.size, 50):
        expected = start[:3, :3] @ turn(2, c[i]) @ turn(1, b[i]) @ turn(0, a[i])
        assert_allclose(pose[i, :3, :3], expected, atol=1e-12)


def turn(axis, angle):
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[i, j], matrix[j, i] = -np.sin(angle), np.sin(angle)
    return matrix


def test_the_papers_profile_has_the_margins_of_the_facts_sheet():
    # facts: |s5| >= 0.953, |s3| >= 0.841, peak speed 0.50 rad/s, peak acceleration 0.56 rad/s^2
    _, q, qd, qdd = table('kebria_fig11')
    assert_allclose(np.abs(np.sin(q[:, 4])).min(), 0.953, atol=1e-3)
    assert_allclose(np.abs(np.sin(q[:, 2])).min(), 0.841, atol=1e-3)
    assert_allclose(np.abs(qd).max(), 0.50, atol=5e-3)
    assert_allclose(np.abs(qdd).max(), 0.56, atol=5e-3)


def test_the_arm_begins_where_the_profile_begins_plus_the_initial_error():
    arm, spec = load_arm('ur5'), load_experiment('kebria_fig11')
    nominal = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
    assert_allclose(initial_positions(spec, arm) - nominal,
                    [0.10, -0.08, 0.06, 0.10, -0.10, 0.15], atol=1e-9)


@pytest.mark.parametrize('name', list_experiments())
def test_stamps_between_the_rows_of_the_table_get_the_motion_itself(name):
    # a robot's clock does not tick on our grid; the witness is a table whose grid it is on
    spec, arm = load_experiment(name), load_arm('ur5')
    coarse, fine = (experiment_trajectory(spec, arm, rate, 0.02).trajectory
                    for rate in (1000, 7000))
    for i in range(1, round(spec.duration * 7000), 3331):
        time = i * 1_000_000_000 // 7000
        for one, two, atol in zip(coarse.at(time), fine.at(time), (1e-9, 1e-9, 1e-6),
                                  strict=True):
            assert_allclose(one, two, atol=atol)


def test_a_time_on_the_grid_gives_the_same_bits_whatever_the_grid():
    spec, arm = load_experiment('kebria_fig11'), load_arm('ur5')
    tables = [experiment_trajectory(spec, arm, rate, 0.02).trajectory
              for rate in (125, 500, 1000, 2000)]
    for k in range(0, 20 * 125, 61):
        rows = [np.concatenate(table.at(k * 8_000_000)).tobytes() for table in tables]
        assert rows.count(rows[0]) == len(rows)


def test_stamps_rounded_to_nanoseconds_stay_on_the_grid():
    spec, arm = load_experiment('kebria_fig11'), load_arm('ur5')
    motion = experiment_trajectory(spec, arm, 300, 0.02).trajectory
    for first in (1, 2, 3):  # the same period after starts whose stamps were rounded otherwise
        time = stamp_of_period(first + 1000, 300) - stamp_of_period(first, 300)
        assert motion.at(time).q.tobytes() == motion.at(round(1000 / 300 * 1e9)).q.tobytes()


def test_the_exciting_trajectory_distinguishes_all_parameters():
    t, q, qd, qdd = table('exciting', rate=20)
    regressor = dynamics_regressor(q, qd, qdd, load_arm('ur5')).reshape(-1, 60)
    friction = np.concatenate([np.stack([np.diag(v), np.diag(np.sign(v))]).transpose(1, 0, 2)
                               .reshape(6, 12) for v in qd])
    random = np.random.default_rng(1).uniform(-3.0, 3.0, size=(3, 300, 6))
    everything = dynamics_regressor(*random, load_arm('ur5')).reshape(-1, 60)
    rank = np.linalg.matrix_rank(everything, tol=1e-6)
    assert np.linalg.matrix_rank(regressor, tol=1e-6) == rank == 36
    full = np.hstack([regressor, friction])
    scale = np.linalg.norm(full, axis=0)
    values = np.linalg.svd(full / np.where(scale > 0.0, scale, 1.0), compute_uv=False)
    assert values[0] / values[rank + 12 - 1] < 100.0


def test_a_file_of_ones_own_is_an_experiment(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text(TEXT)
    motion = experiment_trajectory(load_experiment(str(path)), load_arm('ur5'), 100,
                                   0.02).trajectory
    assert_allclose(motion.at(490_000_000).q[0], 0.0)
    assert_allclose(motion.at(500_000_000).q[0], 0.1)


@pytest.mark.parametrize(('old', 'new', 'words'), [
    ('kind: joint_step', 'kind: dance', "kind is 'dance'; give one of: tool_waves"),
    ('duration: 2.0', 'duration: -2.0', 'duration'),
    ('step: [0.1,', 'step: [.nan,', 'step'),
    ('at: 0.5', 'at: 0.5\nwhen: 3', 'when'),
    ('step: [0.1,', 'step: [9.0,', 'needs shoulder_pan_joint at 9.0000 rad'),
])
def test_a_wrong_file_is_refused_with_the_reason(old, new, words, tmp_path):
    with pytest.raises(InputError, match=words):
        experiment_trajectory(experiment_of(tmp_path, TEXT.replace(old, new)),
                              load_arm('ur5'), 100, 0.02)


def test_a_profile_through_a_singularity_is_refused_with_the_sample(tmp_path):
    spec = experiment_of(tmp_path, kind='tool_polygon', leg_time=2.0,
                         start_degrees=[0.0, -45.0, 60.0, -105.0, -90.0, 0.0],
                         corners=[[0.0, 0.0, 0.0], [-0.5, 0.0, 0.0]])  # stretches the elbow
    with pytest.raises(InputError, match=r'sample \d+ of 201 .* comes within .* of a singularity'):
        experiment_trajectory(spec, load_arm('ur5'), 100, 0.3)


def test_a_profile_that_begins_in_a_singularity_is_refused_whatever_the_margin(tmp_path):
    spec = experiment_of(tmp_path, kind='tool_polygon', leg_time=2.0,
                         start_degrees=[0.0, -90.0, 90.0, -90.0, 0.0, 0.0],
                         corners=[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    with pytest.raises(InputError, match='sample 1 of 201 .* singularity'):
        experiment_trajectory(spec, load_arm('ur5'), 100, 0.0)
    with pytest.raises(InputError, match='sample 1 of 1 .* singularity'):
        initial_positions(spec, load_arm('ur5'))


def test_a_circle_around_its_own_axis_is_refused(tmp_path):
    spec = experiment_of(tmp_path, kind='tool_circle', duration=2.0, centre=[0.0, 0.0, 0.1],
                         normal=[0.0, 0.0, 1.0],
                         start_degrees=[20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
    with pytest.raises(InputError, match='make no circle'):
        experiment_trajectory(spec, load_arm('ur5'), 100, 0.02)


def test_ramps_longer_than_the_experiment_and_lost_files_are_refused(tmp_path):
    with pytest.raises(InputError, match='take 4 s of 3 s; make the duration longer'):
        experiment_of(tmp_path, kind='joint_waves', duration=3.0, ramp=2.0, ramp_down=2.0,
                      start_degrees=[0.0, -90.0, 90.0, -90.0, -90.0, 0.0],
                      joints={'elbow_joint': [{'amplitude': 0.1, 'frequency': 1.0}]})
    with pytest.raises(InputError, match='no experiment file ./lost.yaml'):
        load_experiment('./lost.yaml')


def test_without_a_ramp_the_motion_begins_at_speed(tmp_path):
    text = TEXT.replace('kind: joint_step', 'kind: joint_waves').replace('at: 0.5', 'ramp: 0.0')
    text = text.replace('step: [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]',
                        'joints: {elbow_joint: [{amplitude: 0.1, frequency: 1.0}]}')
    spec = experiment_of(tmp_path, text)
    motion = experiment_trajectory(spec, load_arm('ur5'), 100, 0.02).trajectory
    assert_allclose(motion.at(0).qd[2], 0.2 * np.pi)


def test_an_unknown_experiment_is_refused_with_those_that_exist():
    with pytest.raises(InputError, match='kebria_fig11'):
        load_experiment('kebria')
