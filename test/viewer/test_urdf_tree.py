"""What the viewer draws is where the model says it is, for every arm."""

import numpy as np
import pytest

from ur5_ros.config import list_arms, load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics, link_transforms
from ur5_ros.viewer.track import Track, joint_angles, number_frame, tool_positions, tree_of
from ur5_ros.viewer.urdf_tree import link_poses, parse_urdf, turn

CASES = np.random.default_rng(5).uniform(-np.pi, np.pi, (20, 6))


@pytest.mark.parametrize('name', list_arms())
def test_the_drawn_tool_stands_where_the_model_puts_it(name):
    arm = load_arm(name)
    tree = tree_of(arm)
    poses = link_poses(tree, joint_angles(tree, CASES))
    model = forward_kinematics(CASES + arm.angle_offset, arm)
    np.testing.assert_allclose(np.linalg.inv(poses['base']) @ poses['tool0'], model, atol=1e-12)
    np.testing.assert_allclose(tool_positions(tree, CASES), poses['tool0'][:, :3, 3], atol=1e-15)


def test_base_link_is_base_turned_by_half_a_turn():
    poses = link_poses(tree_of(load_arm('ur5')), {})
    np.testing.assert_allclose(poses['base'], turn(np.array([0, 0, 1]), np.pi), atol=1e-15)


@pytest.mark.parametrize('name', list_arms())
def test_numbers_are_given_in_the_frame_of_the_model(name):
    arm = load_arm(name)
    tree = tree_of(arm)
    tool = tool_positions(tree, CASES)
    track = Track(np.zeros(20), CASES, CASES, CASES, tool, tool, *number_frame(tree))
    assert track.frame == 'base'
    model = forward_kinematics(CASES + arm.angle_offset, arm)[:, :3, 3]
    np.testing.assert_allclose([track.tool_in_base(row) for row in range(20)], model, atol=1e-12)


def test_a_shape_keeps_its_place_on_its_link():
    arm = load_arm('ur5')
    tree = tree_of(arm)
    poses = link_poses(tree, joint_angles(tree, CASES))
    elbow = (np.linalg.inv(poses['base']) @ poses['forearm_link'])[:, :3, 3]
    model = link_transforms(CASES, arm)[:, 1, :3, 3]
    np.testing.assert_allclose(elbow, model, atol=1e-12)


@pytest.mark.parametrize(('text', 'printed'), [
    ('no xml', 'not XML'),
    ('<robot/>', '0 root links'),
    ('<robot><link name="a"/><link name="b"/></robot>', '2 root links'),
    ('<robot><link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/>'
     '<child link="b"/><origin xyz="1 2" rpy="0 0 0"/></joint></robot>', '3 numbers'),
    ('<robot><link/></robot>', 'a link without name'),
    ('<robot><link name="a"/><joint name="j" type="fixed"><child link="a"/></joint></robot>',
     "joint 'j' has no parent"),
    ('<robot><link name="a"><visual><geometry><sphere/></geometry></visual></link></robot>',
     '1 number'),
    ('<robot><link name="a"><visual/></link></robot>', 'visual .* has no geometry'),
    ('<robot><link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/>'
     '<child link="b"/><origin xyz="1 2 nan"/></joint></robot>', '3 numbers'),
])
def test_a_description_that_is_none_is_refused_in_one_line(text, printed):
    with pytest.raises(InputError, match=printed) as refusal:
        parse_urdf(text)
    assert '\n' not in str(refusal.value)
