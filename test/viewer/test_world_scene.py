"""The viewer draws what the arm touches, and forces as arrows."""

import numpy as np
import viser

from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.viewer.track import arm_of, tree_of
from ur5_ros.viewer.world_scene import FRICTION, NORMAL, WorldScene, force_arrows


def test_a_pushed_block_and_its_forces_are_drawn_where_they_are():
    run = as_run(run_closed_loop(run_config('push_block', duration=1.6)))
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
