"""The viewer draws what the arm touches, and forces as arrows."""

import numpy as np
import pytest
import viser

from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.sim.camera import Camera
from ur5_ros.viewer.frame import Frames
from ur5_ros.viewer.track import arm_of, track, tree_of
from ur5_ros.viewer.world_scene import WorldScene
from ur5_ros.viewer.world_track import FRICTION, NORMAL, WorldTrack, force_arrows


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
    assert np.array_equal(colours[0, 0], NORMAL) and np.array_equal(colours[1, 0], FRICTION)


def test_the_tool_of_a_world_is_part_of_the_drawn_arm():
    run = as_run(run_closed_loop(run_config('push_block', duration=0.01)))
    kinds = [visual.kind for visual in tree_of(arm_of(run), run.sim.world).visuals['wrist_3_link']]
    assert kinds == ['cylinder', 'cylinder', 'sphere']


def blue(picture, alone):
    """Return where a picture became as blue as the block, as rows of x, y."""
    changed = np.abs(alone.astype(int) - picture).max(axis=-1) > 20
    return np.argwhere(changed & (picture[..., 2] > picture[..., 0].astype(int) + 40))[:, ::-1]


def test_a_picture_shows_the_bodies_where_they_are_and_the_forces(pushed):
    run = pushed
    world, camera = WorldTrack(run), Camera(arm_of(run), 600, 400, run.sim.world)
    try:
        q, poses = run.states.q[-1], world.poses(float(run.t[-1]))
        alone, there = camera.picture(q), camera.picture(q, poses)
        gone = camera.picture(q)
        poses[1, 1, 3] += 0.3
        aside = camera.picture(q, poses)
        frame = Frames(track(run, tree_of(arm_of(run))), camera, 100, 1, world).frame(-1)
        corners = [[x, y, z, 1.0] for x in (-0.06, 0.06) for y in (-0.06, 0.06)
                   for z in (-0.05, 0.05)]
        seen = [camera.pixels((np.array(corners) @ pose.T)[:, :3] * [-1.0, -1.0, 1.0])
                for pose in (world.poses(float(run.t[-1]))[1], poses[1])]
    finally:
        camera.close()
    assert np.array_equal(alone, gone), 'without poses nothing stands there'
    assert (alone != there).any(axis=-1).mean() > 0.05, 'the table is large'
    for picture, box in zip((there, aside), seen, strict=True):
        spots = blue(picture, alone)
        assert len(spots) > 100
        assert (spots > box.min(axis=0) - 2).all() and (spots < box.max(axis=0) + 2).all()
    assert (frame == np.array(NORMAL)).all(axis=-1).sum() > 5


def test_an_empty_world_leaves_a_picture_as_it_is(pushed):
    arm, q = arm_of(pushed), pushed.states.q[0]
    plain, empty = Camera(arm, 120, 80), Camera(arm, 120, 80)
    try:
        assert np.array_equal(plain.picture(q), empty.picture(q, np.zeros((0, 4, 4))))
    finally:
        plain.close()
        empty.close()
