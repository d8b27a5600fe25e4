"""Pictures made off screen show the arm where it is, and the path where the tool went."""

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.sim.camera import Camera
from ur5_ros.viewer.frame import MEASURED, Frames
from ur5_ros.viewer.render import draw, render
from ur5_ros.viewer.track import arm_of, drawable, track, tree_of

SIZE = (300, 200)


@pytest.fixture
def camera():
    camera = Camera(load_arm('ur5'), *SIZE)
    yield camera
    camera.close()


def arm_pixels(picture: np.ndarray) -> np.ndarray:
    """Return where the picture is not the white ground, as rows of x, y."""
    return np.argwhere((picture < 245).any(axis=-1))[:, ::-1]


def test_the_camera_sees_an_arm_that_moves(camera):
    home = camera.picture(np.zeros(6))
    moved = camera.picture(np.array([1.0, -1.0, 1.0, 0.0, 0.0, 0.0]))
    assert 0.01 < len(arm_pixels(home)) / (SIZE[0] * SIZE[1]) < 0.5
    assert np.abs(home.astype(int) - moved).max() > 50


def test_a_point_is_drawn_where_the_camera_sees_it(run):
    rows = track(run, tree_of(arm_of(run)))
    big = Camera(arm_of(run), 600, 400)
    try:
        for row in (0, len(rows.t) // 2, -1):
            spot = big.pixels(rows.tool[[row]])[0]
            seen = arm_pixels(big.picture(rows.q[row]))
            assert np.abs(seen - spot).max(axis=1).min() <= 3  # tool0 lies on the last link's end
    finally:
        big.close()


def test_every_arm_stands_in_the_picture():
    for name in ('ur3e', 'ur5', 'ur10e', 'ur20'):
        camera = Camera(load_arm(name), *SIZE)
        seen = arm_pixels(camera.picture(np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])))
        camera.close()
        assert len(seen) > 500, name
        assert seen.min() > 0 and (seen < np.array(SIZE) - 1).all(), name


def test_an_arm_of_point_masses_is_drawn_all_the_same():
    arm = drawable(load_arm('ur5_controller'))
    camera = Camera(arm, *SIZE)
    assert len(arm_pixels(camera.picture(np.zeros(6)))) > 500
    camera.close()


def test_a_frame_shows_the_path_that_the_tool_has_gone(run, camera):
    rows = track(run, tree_of(arm_of(run)))
    frames = Frames(rows, camera, 100)
    early, late = (np.sum(np.all(frames.frame(row)[:SIZE[1]] == MEASURED, axis=-1))
                   for row in (10, len(rows.t) - 1))
    assert late > early + 50
    assert frames.frame(0).shape == (SIZE[1] + 100, SIZE[0], 3)


def test_a_video_has_as_many_frames_as_its_run_has_seconds_times_the_rate(run, tmp_path):
    out = draw(run, tmp_path / 'run.mp4')
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(out))
    assert frames == pytest.approx(6.0 * 25, abs=2)
    assert seconds == pytest.approx(6.0, abs=0.1)


def test_an_animation_loops_and_moves(run, tmp_path):
    with Image.open(draw(run, tmp_path / 'run.gif')) as animation:
        assert animation.n_frames == pytest.approx(60, abs=2)
        first = np.asarray(animation.convert('RGB')).astype(int)
        animation.seek(animation.n_frames - 1)
        assert np.abs(np.asarray(animation.convert('RGB')) - first).max() > 50


def test_the_progress_of_a_video_ends_at_one(run, tmp_path):
    shares = []
    draw(run, tmp_path / 'run.gif', shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0


@pytest.mark.parametrize(('name', 'said'), [
    ('run.avi', 'png, .mp4, .gif'), ('missing/run.png', 'no such folder'),
    ('there.png', 'exists')])
def test_a_wrong_name_of_a_picture_is_refused_before_any_work(tmp_path, name, said):
    (tmp_path / 'there.png').write_bytes(b'')
    with pytest.raises(InputError, match=said):
        render(tmp_path / 'no_run', tmp_path / name)
    assert (tmp_path / 'there.png').read_bytes() == b''
