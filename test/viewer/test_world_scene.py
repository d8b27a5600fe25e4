"""The viewer draws what the arm touches, and forces as arrows."""

import numpy as np
import pytest
import viser

from ur5_ros.analysis.data.load import load_run
from ur5_ros.cdr.contact_messages import FORCE_COLOURS
from ur5_ros.config import arm_text
from ur5_ros.config.worlds import Body
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.viewer.picture.camera import Camera
from ur5_ros.viewer.picture.frame import Frames
from ur5_ros.viewer.picture.ray_caster import Placed, cast, seen_through
from ur5_ros.viewer.stage import Stage
from ur5_ros.viewer.track import arm_of, track, tree_of
from ur5_ros.viewer.urdf_tree import Visual
from ur5_ros.viewer.world_scene import WorldScene
from ur5_ros.viewer.world_track import (
    WorldTrack,
    body_visual,
    force_arrows,
)

#: Of ``base`` in ``base_link``.
BASE = np.diag([-1.0, -1.0, 1.0, 1.0])


@pytest.fixture(scope='module')
def pushed():
    return as_run(run_closed_loop(run_config('push_block', duration=1.6)))


def test_a_pushed_block_and_its_forces_are_drawn_where_they_are(pushed):
    run = pushed
    server = viser.ViserServer(host='127.0.0.1', port=18330, verbose=False)
    try:
        scene = WorldScene(server, run)
        scene.show(1.5)
    finally:
        server.stop()
    contacts = next(felt for stamp, felt in run.contact_forces if stamp >= 1_400_000_000)
    points, colours = force_arrows(contacts)
    assert len(points) == 2 * len(contacts) >= 2
    weight = sum(points[2 * i, 1, 2] - points[2 * i, 0, 2] for i, each in enumerate(contacts)
                 if each.bodies == ('table', 'block'))
    assert -0.11 < weight < -0.08, '1 kg at 10 mm a newton, part of it on the finger'
    assert [tuple(each) for each in colours[:2, 0].tolist()] == list(FORCE_COLOURS)


def test_the_tool_of_a_world_is_part_of_the_drawn_arm():
    run = as_run(run_closed_loop(run_config('push_block', duration=0.01)))
    kinds = [visual.kind for visual in tree_of(arm_of(run), run.sim.world).visuals['wrist_3_link']]
    assert kinds == ['cylinder', 'cylinder', 'sphere']


def test_the_tool_of_an_arms_file_is_drawn_from_the_bag(tmp_path):
    arm = tmp_path / 'armed.yaml'
    arm.write_text(arm_text('ur5') + 'tool:\n  - {shape: sphere, radius: 0.02, position: '
                   '[0.0, 0.0, 0.05]}\n')
    run_closed_loop(run_config(arm=str(arm), duration=0.05), tmp_path / 'run')
    run = load_run(tmp_path / 'run')
    kinds = [visual.kind for visual in tree_of(arm_of(run), run.sim.world).visuals['wrist_3_link']]
    assert kinds[-1] == 'sphere' and kinds.count('sphere') == 1


def blue(picture, alone):
    """Return where a picture became as blue as the block, as rows of x, y."""
    changed = np.abs(alone.astype(int) - picture).max(axis=-1) > 20
    return np.argwhere(changed & (picture[..., 2] > picture[..., 0].astype(int) + 40))[:, ::-1]


def test_a_picture_shows_the_bodies_where_they_are_and_the_forces(pushed):
    run, camera = pushed, Camera(600, 400)
    stage, world = Stage(run), WorldTrack(run)
    t, end = float(run.t[-1]), len(world.bodies)
    placed = stage.arm(run.states.q[-1]) + stage.world(t)
    pose = world.poses(t)[1]
    aside = pose.copy()
    aside[1, 3] += 0.3
    moved = [*placed[:-1], Placed(placed[-1].visual, BASE @ aside)]
    alone = cast(camera, placed[:-end])
    assert [each.visual.kind for each in placed[-end:]] == ['box', 'box']
    assert (np.isfinite(alone.depth) != np.isfinite(cast(camera, placed).depth)).mean() > 0.05, \
        'the table is large'
    corners = np.array([[x, y, z, 1.0] for x in (-0.06, 0.06) for y in (-0.06, 0.06)
                        for z in (-0.05, 0.05)])
    for bodies, place in ((placed, pose), (moved, aside)):
        box = camera.pixels((corners @ place.T)[:, :3] * [-1.0, -1.0, 1.0])
        spots = blue(cast(camera, bodies).colour, alone.colour)
        assert len(spots) > 100
        assert (spots > box.min(axis=0) - 2).all() and (spots < box.max(axis=0) + 2).all()
    frame = Frames(track(run, stage.tree), stage, (600, 400), 130, 1).frame(-1)
    assert (frame == np.array(FORCE_COLOURS[0])).all(axis=-1).sum() > 5


def test_a_mesh_of_a_world_is_drawn_and_one_whose_file_is_gone_is_left_out(tmp_path):
    path = tmp_path / 'wedge.obj'
    path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n'
                    'f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n')
    there, gone = (body_visual(Body(name='wedge', shape='mesh', file=str(each)))
                   for each in (path, tmp_path / 'other.obj'))
    assert there.triangles.shape == (4, 3, 3) and there.triangles.max() == 1.0
    assert gone.triangles.shape == (0, 3, 3)


def test_what_stands_before_the_arm_lets_it_show_through(pushed):
    stage, camera = Stage(pushed), Camera(300, 200)
    rows = track(pushed, stage.tree)
    arm = cast(camera, stage.arm(rows.q[-1]))
    wall = Placed(Visual('box', (1.0, 0.02, 1.0), np.eye(4), (70, 130, 70)),
                  np.array([[1.0, 0, 0, 0.2], [0, 1, 0, 0.55], [0, 0, 1, 0.5], [0, 0, 0, 1]]))
    shut = cast(camera, [*stage.arm(rows.q[-1]), wall])
    hidden = np.isfinite(arm.depth) & (shut.depth < arm.depth)
    assert hidden.sum() > 500, 'the wall stands before the arm'
    shown = seen_through(shut, arm)
    other = ~hidden
    np.testing.assert_array_equal(shown.colour[other], shut.colour[other])
    between = (np.minimum(shut.colour, arm.colour) <= shown.colour) & (
        shown.colour <= np.maximum(shut.colour, arm.colour))
    assert between[hidden].all()
    tint = np.abs(arm.colour[hidden].astype(int) - shut.colour[hidden]).max(axis=-1) > 60
    assert (np.abs(shown.colour[hidden].astype(int) - shut.colour[hidden]).max(axis=-1)
            > 20)[tint].all(), 'the arm is seen'
