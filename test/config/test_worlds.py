"""World files: what is read, and what is refused in one line."""

import numpy as np
import pytest

from ur5_ros.config.worlds import (
    base_pose,
    list_worlds,
    load_world,
    parse_world,
    with_contact,
    world_text,
)
from ur5_ros.errors import InputError

HEAD = 'name: test\ndescription: ""\nsource: ""\nbodies:\n  - '
BLOCK = '{name: block, shape: box, size: [0.1, 0.2, 0.3], mass: 2.0}'


@pytest.mark.parametrize('name', list_worlds())
def test_every_world_of_the_package_is_read_and_stored_as_text(name):
    world = load_world(name)
    assert world.name == name
    assert parse_world(world_text(name), 'bag') == world


def test_moments_of_a_homogeneous_box_are_the_textbooks():
    body, = parse_world(HEAD + BLOCK, 'test').bodies
    assert body.moments == pytest.approx([2 * (0.04 + 0.09) / 12, 2 * (0.01 + 0.09) / 12,
                                          2 * (0.01 + 0.04) / 12])


def test_poses_in_base_link_are_turned_by_half_a_turn():
    world = parse_world('frame: base_link\n' + HEAD + BLOCK.replace(
        'mass: 2.0', 'position: [1.0, 2.0, 3.0]'), 'test')
    pose = base_pose(world.bodies[0], world.frame)
    assert np.allclose(pose[:3, 3], [-1.0, -2.0, 3.0])
    assert np.allclose(pose[:3, :3], np.diag([-1.0, -1.0, 1.0]))


def test_contact_parameters_replace_what_the_file_says():
    world = parse_world(HEAD + BLOCK, 'test')
    given = {f'contact.{key}': -1.0 for key in ('friction', 'restitution', 'stiffness', 'damping')}
    assert with_contact(world, given) is world
    changed = with_contact(world, given | {'contact.friction': 0.9})
    assert [body.friction for body in changed.bodies] == [0.9]


@pytest.mark.parametrize(('body', 'words'), [
    ('{name: block, shape: box, size: [0.1, 0.1, 0.1], friction: -0.1}', 'friction'),
    ('{name: block, shape: box}', 'body block: a box needs size'),
    ('{name: block, shape: sphere, radius: 0.1, length: 1.0}', 'a sphere has no length'),
    ('{name: part, shape: mesh, file: part.obj, mass: 1.0}', 'mass 1 kg without inertia'),
    ('{name: floor, shape: plane, mass: 1.0}', 'a plane has mass'),
    ('{name: rod, shape: cylinder, radius: 0.1, length: 1.0, mass: 1.0, '
     'inertia: [1.0, 0.1, 0.1]}', 'that of no body'),
    ('{name: block, shape: cone, radius: 0.1}', 'cone'),
    (BLOCK + '\n  - ' + BLOCK, 'the name is there twice'),
    ('{name: block, shape: box, size: [0.1, 0.1, 0.1], colours: red}', 'unknown field .colours'),
])
def test_what_cannot_be_is_refused_in_one_line(body, words):
    with pytest.raises(InputError, match=words) as refusal:
        parse_world(HEAD + body, 'test')
    assert '\n' not in str(refusal.value)


def test_an_unknown_world_is_refused_with_those_there_are():
    with pytest.raises(InputError, match='unknown world .moon.; give one of: blocks'):
        load_world('moon')


def test_a_mesh_file_that_is_not_there_is_refused_with_its_path(tmp_path):
    path = tmp_path / 'world.yaml'
    path.write_text(HEAD + '{name: part, shape: mesh, file: part.obj}')
    with pytest.raises(InputError, match='body part: no mesh .*part.obj'):
        load_world(str(path))
