"""Pictures made off screen show the arm where it is, and the path where the tool went."""

import dataclasses

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from ur5_ros.analysis.injected import Injection
from ur5_ros.analysis.report import palette
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.rotations import rotation_of_rpy
from ur5_ros.viewer.picture.camera import Camera
from ur5_ros.viewer.picture.frame import MEASURED, Frames
from ur5_ros.viewer.picture.ray_caster import Placed, cast
from ur5_ros.viewer.picture.strips import ticks
from ur5_ros.viewer.render import draw, render
from ur5_ros.viewer.stage import Stage
from ur5_ros.viewer.track import track
from ur5_ros.viewer.urdf_tree import Visual

SIZE = (300, 200)


@pytest.fixture(scope='module')
def short():
    """Return two seconds of the paper's experiment: a video of them is soon drawn."""
    return as_run(run_closed_loop(run_config(control_rate=250, physics_rate=250, duration=2.0)),
                  'two_seconds')


def seen(stage: Stage, camera: Camera, q: np.ndarray) -> np.ndarray:
    """Return where the camera sees the arm, as rows of x, y."""
    return np.argwhere(np.isfinite(cast(camera, stage.arm(q)).depth))[:, ::-1]


def at(x, y, z, roll=0.0, pitch=0.0, yaw=0.0) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_of_rpy(roll, pitch, yaw), (x, y, z)
    return pose


def hull_of(shape: str, size: tuple) -> np.ndarray:
    """Return points all over the surface of a shape (n, 3)."""
    rng = np.random.default_rng(3)
    if shape == 'sphere':
        points = rng.normal(size=(4000, 3))
        return size[0] * points / np.linalg.norm(points, axis=1, keepdims=True)
    if shape == 'box':
        points = rng.uniform(-0.5, 0.5, (6000, 3))
        points[np.arange(6000), np.arange(6000) % 3] = np.sign(points[:, 0]) / 2
        return points * size
    angle, along = rng.uniform(0, 2 * np.pi, 6000), rng.uniform(-0.5, 0.5, 6000) * size[1]
    along[:3000] = np.sign(along[:3000]) * size[1] / 2
    radius = np.where(np.arange(6000) < 3000, np.sqrt(rng.uniform(0, 1, 6000)), 1.0) * size[0]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), along], axis=-1)


@pytest.mark.parametrize(('shape', 'size'), [
    ('sphere', (0.2,)), ('box', (0.3, 0.2, 0.5)), ('cylinder', (0.1, 0.6))])
@pytest.mark.parametrize('rpy', [(0.0, 0.0, 0.0), (0.7, -0.4, 2.1)])
def test_a_body_covers_the_pixels_of_its_surface_at_their_depth(shape, size, rpy):
    camera, pose = Camera(*SIZE), at(0.1, -0.1, 0.4, *rpy)
    picture = cast(camera, [Placed(Visual(shape, size, np.eye(4), (200, 100, 50)), pose)])
    points = hull_of(shape, size) @ pose[:3, :3].T + pose[:3, 3]
    spots, depth = camera.pixels(points), camera.depth(points)
    covered = np.argwhere(np.isfinite(picture.depth))[:, ::-1] + 0.5
    assert np.abs(covered.min(axis=0) - spots.min(axis=0)).max() < 2.0
    assert np.abs(covered.max(axis=0) - spots.max(axis=0)).max() < 2.0
    nearest = picture.depth[tuple(np.floor(spots).astype(int).T[::-1])]
    inner = np.isfinite(nearest)
    assert inner.mean() > 0.9
    assert (depth[inner] > nearest[inner] - 0.03).mean() > 0.99, 'no surface is in front of it'
    assert np.abs(depth[inner] - nearest[inner]).min() < 1e-3


def test_a_mesh_looks_like_the_box_whose_faces_it_has():
    corners = np.array([[x, y, z] for x in (-.1, .1) for y in (-.15, .15) for z in (-.2, .2)])
    faces = [(0, 1, 3), (0, 3, 2), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 3, 7),
             (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 3, 7), (1, 7, 5)]
    box = Visual('box', (0.2, 0.3, 0.4), np.eye(4), (200, 100, 50))
    mesh = Visual('mesh', (), np.eye(4), (200, 100, 50), corners[np.array(faces)])
    camera, pose = Camera(*SIZE), at(0.0, 0.1, 0.3, 0.5, 0.2, 0.9)
    one, other = (cast(camera, [Placed(each, pose)]) for each in (box, mesh))
    both = np.isfinite(one.depth) & np.isfinite(other.depth)
    assert both.sum() > 500
    assert (np.isfinite(one.depth) != np.isfinite(other.depth)).sum() < 20
    np.testing.assert_allclose(one.depth[both], other.depth[both], atol=1e-5)
    assert np.abs(one.colour[both].astype(int) - other.colour[both]).mean() < 2


def test_a_tube_is_shaded_without_edges_and_throws_a_shadow_on_the_floor():
    camera = Camera(*SIZE)
    tube = Visual('cylinder', (0.1, 0.6), np.eye(4), (200, 200, 200))
    picture = cast(camera, [Placed(tube, at(0.0, 0.0, 0.6))])
    row = picture.colour[len(picture.colour) // 2, :, 0].astype(int)
    side = row[row > 0]
    assert len(side) > 20
    assert np.abs(np.diff(side)).max() < 25, 'from pixel to pixel the light changes little'
    assert 50 < picture.shadow.sum() < 0.1 * picture.shadow.size


def test_an_arm_that_moves_is_seen_elsewhere(run):
    stage, camera = Stage(run), Camera(*SIZE)
    home, moved = (seen(stage, camera, np.array(q)) for q in (
        [0.0] * 6, [1.0, -1.0, 1.0, 0.0, 0.0, 0.0]))
    assert 0.01 < len(home) / (SIZE[0] * SIZE[1]) < 0.5
    assert len({*map(tuple, home)} ^ {*map(tuple, moved)}) > 500


def test_a_point_is_drawn_where_the_camera_sees_it(run):
    stage, camera = Stage(run), Camera(600, 400)
    rows = track(run, stage.tree)
    for row in (0, len(rows.t) // 2, -1):
        spot = camera.pixels(rows.tool[[row]])[0]
        arm = seen(stage, camera, rows.q[row])
        assert np.abs(arm - spot).max(axis=1).min() <= 3  # tool0 is on the end of the last link


@pytest.mark.parametrize('name', ['ur3e', 'ur5', 'ur10e', 'ur20', 'ur5_controller'])
def test_every_arm_stands_in_the_picture_one_of_point_masses_too(run, name):
    arm = load_arm(name)
    of_this_arm = dataclasses.replace(run, sim=dataclasses.replace(run.sim, arm=arm))
    stage = Stage(of_this_arm)
    arm_pixels = seen(stage, Camera(*SIZE, stage.reach),
                      np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0]))
    assert len(arm_pixels) > 500
    assert arm_pixels.min() > 0 and (arm_pixels < np.array(SIZE) - 1).all()


def test_a_frame_shows_the_path_that_the_tool_has_gone(run):
    stage = Stage(run)
    rows = track(run, stage.tree)
    frames = Frames(rows, stage, (600, 400), 130, 1)
    early, late = (np.sum(np.all(frames.frame(row)[:400] == MEASURED, axis=-1))
                   for row in (10, len(rows.t) - 1))
    assert late > early + 50
    assert frames.frame(0).shape == (530, 600, 3)


def test_what_was_added_to_the_plant_is_marked_in_the_curves_and_named_from_then_on(run):
    stage = Stage(run)
    rows = track(run, stage.tree)
    plain, marked = (Frames(rows, stage, (600, 400), 130, 1, each)
                     for each in ((), (Injection(3.0, 'payload.mass 2'),)))
    row = rows.row(2.0)
    assert (plain.frame(row) != marked.frame(row))[400:].any()
    assert not (plain.frame(row) != marked.frame(row))[:400].any()
    row = rows.row(4.0)
    assert (plain.frame(row) != marked.frame(row))[:400].any()


@pytest.mark.parametrize(('low', 'high', 'levels'), [
    (0.0, 10.0, [0, 2.5, 5, 7.5, 10]), (-36.8, 0.4, [-40, -30, -20, -10, 0, 10]),
    (0.0, 0.0031, [0, 0.001, 0.002, 0.003, 0.004])])
def test_axes_have_round_numbers_around_their_range(low, high, levels):
    assert ticks(low, high) == pytest.approx(levels)


def test_a_video_has_as_many_frames_as_its_run_has_seconds_times_the_rate(short, tmp_path):
    out = draw(short, tmp_path / 'run.mp4')
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(out))
    assert frames == pytest.approx(2.0 * 25, abs=2)
    assert seconds == pytest.approx(2.0, abs=0.1)


def test_an_animation_loops_and_moves(short, tmp_path):
    with Image.open(draw(short, tmp_path / 'run.gif')) as animation:
        assert animation.n_frames == pytest.approx(20, abs=2)
        first = np.asarray(animation.convert('RGB')).astype(int)
        animation.seek(animation.n_frames - 1)
        assert np.abs(np.asarray(animation.convert('RGB')) - first).max() > 50


def test_an_animation_keeps_the_colours_that_have_a_meaning(short, tmp_path):
    named = [palette.rgb(each) for each in (*palette.JOINT_COLOURS, palette.MEASURED,
                                            palette.REFERENCE)]
    with Image.open(draw(short, tmp_path / 'run.gif')) as animation:
        for number in (0, animation.n_frames - 1):
            animation.seek(number)
            drawn = {colour for _, colour in animation.convert('RGB').getcolors(1 << 20)}
            assert set(named) <= drawn


def test_the_progress_of_a_video_ends_at_one(short, tmp_path):
    shares = []
    draw(short, tmp_path / 'run.gif', shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0


@pytest.mark.parametrize(('name', 'printed'), [
    ('run.avi', 'png, .mp4, .gif'), ('missing/run.png', 'no such folder'),
    ('there.png', 'exists')])
def test_a_wrong_name_of_a_picture_is_refused_before_any_work(tmp_path, name, printed):
    (tmp_path / 'there.png').write_bytes(b'')
    with pytest.raises(InputError, match=printed):
        render(tmp_path / 'no_run', tmp_path / name)
    assert (tmp_path / 'there.png').read_bytes() == b''
