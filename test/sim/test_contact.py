"""Contact of the arm with a world: forces by the book, equal bits, refusals in words."""

import numpy as np
import pinocchio
import pytest

from ur5_ros.config import SIM_PARAMETERS, arm_text, complete, load_arm
from ur5_ros.config.worlds import load_world
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import gravity_torque, inertia_matrix
from ur5_ros.model.inverse_kinematics import nearest_solution
from ur5_ros.model.kinematics import forward_kinematics, jacobian
from ur5_ros.sim.plant import Plant
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.sim.world.contact_rows import REST_DEPTH

G = 9.81

ROTORS = [2.0, 2.0, 1.0, 0.2, 0.2, 0.2]


@pytest.fixture
def plant_in():
    """Return a function: world (text or name), arm, tool position -> plant with the tool down."""
    plants = []

    def make(world, arm='ur5', tool=(-0.5, -0.1, 0.2), **given):
        record = load_arm(arm) if isinstance(arm, str) else arm
        pose = np.diag([1.0, -1.0, -1.0, 1.0])
        pose[:3, 3] = tool
        near = np.deg2rad([20.0, -75.0, 90.0, -105.0, -90.0, 15.0])
        start = nearest_solution(pose, near, record, record.limits)
        parameters = {name.replace('__', '.'): value for name, value in given.items()}
        plants.append(Plant(record, complete(SIM_PARAMETERS, {
            'world': str(world), 'initial_positions': np.ravel(start)[:6].tolist(),
            **parameters})))
        return plants[-1]

    yield make
    for plant in plants:
        plant.close()


@pytest.fixture
def world_file(tmp_path):
    """Return a function that writes a world of some bodies and returns its path."""
    def write(*bodies, tool=''):
        path = tmp_path / 'test_world.yaml'
        path.write_text('name: test\ndescription: ""\nsource: ""\n' + tool + 'bodies:\n'
                        + ''.join(f'  - {body}\n' for body in bodies))
        return path
    return write


FLOOR = ('{name: floor, shape: box, size: [4.0, 4.0, 0.1], position: [0.0, 0.0, -0.05], '
         'friction: 1.0}')


def push(plant, force, damping=20.0):
    """Step under gravity compensation, damping and a force at the tool [N]."""
    state, arm = plant.state, plant.arm
    q = state.q + arm.angle_offset
    tau = gravity_torque(q, arm) + jacobian(q, arm).T @ [*force, 0.0, 0.0, 0.0]
    return plant.step(tau - damping * (inertia_matrix(q, arm) @ state.qd))


def hold(plant):
    """Step with the arm out of the way."""
    return plant.step(None)


def forces(plant):
    """Return the sum of the contact forces on first bodies in the last physics step [N]."""
    return plant.mechanics.contacts[-1].force.sum(axis=0)


def block(plant):
    """Return place and quaternion of the only free body."""
    (_, place, turn), = plant.mechanics.objects()
    return place, turn


def test_a_block_at_rest_presses_with_its_weight(plant_in, world_file):
    plant = plant_in(world_file(FLOOR, '{name: block, shape: box, size: [0.1, 0.1, 0.1], mass: '
                                '2.0, position: [0.9, 0.9, 0.05], friction: 0.5}'))
    for _ in range(500):
        hold(plant)
    assert forces(plant)[2] == pytest.approx(-2.0 * G, abs=1e-9)  # on the floor, the first body
    assert block(plant)[0][2] == pytest.approx(0.05 - REST_DEPTH, abs=1e-9)


@pytest.mark.parametrize('friction', [0.2, 0.5])
def test_a_block_slides_as_far_as_coulomb_says(plant_in, world_file, friction):
    plant = plant_in(world_file(FLOOR, '{name: block, shape: box, size: [0.1, 0.1, 0.1], mass: '
                                f'1.0, position: [0.5, 0.9, 0.05], friction: {friction}}}'))
    for _ in range(100):
        hold(plant)
    world = plant.mechanics.world
    start, speed = block(plant)[0], 0.8
    world.bodies[0, 11] = speed
    for _ in range(1500):
        hold(plant)
    place, turn = block(plant)
    # semi-implicit Euler takes half a step of the first speed less
    way = speed**2 / (2 * friction * G) - speed * 0.5e-3
    assert place[0] - start[0] == pytest.approx(way, rel=2e-3)
    assert np.abs(turn[:3]).max() < 1e-6


def test_a_ball_rolls_with_five_sevenths_of_the_speed_it_slid_with(plant_in, world_file):
    plant = plant_in(world_file(FLOOR, '{name: ball, shape: sphere, radius: 0.05, mass: 1.0, '
                                'position: [-1.5, 0.9, 0.05], friction: 0.3}'))
    world = plant.mechanics.world
    world.bodies[0, 11] = 1.0
    for _ in range(600):
        hold(plant)
    assert world.bodies[0, 11] == pytest.approx(5 / 7, rel=1e-3)
    assert world.bodies[0, 15] == pytest.approx(5 / 7 / 0.05, rel=1e-3)


def test_a_ball_bounces_to_the_square_of_its_restitution(plant_in, world_file):
    floor = FLOOR.replace('friction: 1.0', 'friction: 1.0, restitution: 1.0')
    plant = plant_in(world_file(floor, '{name: ball, shape: sphere, radius: 0.05, mass: 1.0, '
                                'position: [0.9, 0.9, 0.25], restitution: 0.7}'))
    height, fallen = [], False
    for _ in range(600):
        hold(plant)
        fallen |= bool(forces(plant).any())
        height.append(block(plant)[0][2] if fallen else 0.0)
    assert max(height) - 0.05 == pytest.approx(0.7**2 * 0.2, rel=0.02)


def test_a_soft_contact_gives_way_by_weight_over_stiffness(plant_in, world_file):
    plant = plant_in(world_file(FLOOR, '{name: ball, shape: sphere, radius: 0.05, mass: 1.0, '
                                'position: [0.9, 0.9, 0.05], stiffness: 20000.0, damping: 50.0}'))
    for _ in range(3000):
        hold(plant)
    assert block(plant)[0][2] == pytest.approx(0.05 - G / 20000.0, abs=1e-9)


@pytest.mark.parametrize('given', [
    {}, {'arm': 'ur5_real'},
    {'arm': 'ur5_real', 'friction__coulomb': [2.0] * 6, 'friction__viscous': [1.0] * 6},
], ids=['plain', 'rotors', 'rotors and friction'])
def test_contact_forces_explain_an_impact_to_the_last_digits(plant_in, given):
    plant = plant_in('table', tool=(-0.5, -0.1, 0.12), **given)
    arm = plant.arm
    model = pinocchio.buildModelFromXML(urdf_text(arm))
    data, worst, largest = model.createData(), 0.0, 0.0
    coulomb = np.array(plant.parameters.friction_coulomb)
    viscous = np.array(plant.parameters.friction_viscous)
    for k in range(1500):
        before = plant.truth
        after = push(plant, (30.0 if k > 800 else 0.0, 0.0, -30.0))
        acceleration = (after.qd - before.qd) * 1000.0
        needed = pinocchio.rnea(model, data, before.q, before.qd, acceleration)
        needed = needed + arm.armature * acceleration + viscous * after.qd
        (_, torque), = plant.contact_effort()
        left = needed - after.effort - torque
        sticks = np.abs(after.qd) <= 1e-12
        left = np.where(sticks, left - np.clip(left, -coulomb, coulomb),
                        left + coulomb * np.sign(after.qd))
        worst = max(worst, np.abs(left).max())
        largest = max(largest, np.abs(torque).max())
    assert largest > 50.0, 'the tool hits the table'
    assert worst < 1e-9


def test_contact_torque_is_the_jacobian_of_the_place_times_the_force(plant_in):
    plant = plant_in('table', tool=(-0.5, -0.1, 0.1))
    model = pinocchio.buildModelFromXML(urdf_text(plant.arm))
    data, link = model.createData(), model.getFrameId('wrist_3_link')
    turn = np.diag([-1.0, -1.0, 1.0])  # base_link <- base
    for _ in range(600):
        push(plant, (5.0, 5.0, -40.0))
    last = plant.mechanics.contacts[-1]
    q = np.array(last.q)
    pinocchio.framesForwardKinematics(model, data, q)
    J = pinocchio.computeFrameJacobian(model, data, q, link, pinocchio.LOCAL_WORLD_ALIGNED)
    lever = turn @ last.points[0, 2:5] - data.oMf[link].translation
    force = turn @ last.force[0]
    expected = J.T @ np.concatenate([force, np.cross(lever, force)])
    assert np.linalg.norm(force) > 20.0
    assert np.abs(np.array(last.torque) - expected).max() < 1e-9


def test_friction_stays_in_its_cone_and_reaches_it_in_sliding(plant_in):
    plant, ratio = plant_in('table', tool=(-0.5, -0.1, 0.1)), []
    for k in range(1500):
        push(plant, (0.0, 25.0 if k > 600 else 0.0, -30.0))
        for force in plant.mechanics.contacts[-1].force:
            assert np.hypot(force[0], force[1]) <= 0.3 * force[2] + 1e-9
            ratio.append(np.hypot(force[0], force[1]) / max(force[2], 1e-9))
    assert ratio[-1] == pytest.approx(0.3, rel=1e-6)


def run(plant, periods=700):
    """Return the bytes of states, contact torques and bodies of a push of the block."""
    trace = []
    for _ in range(periods):
        state = push(plant, (0.0, 60.0, 0.0))
        trace += [state.q.tobytes(), state.qd.tobytes()]
        trace += [torque.tobytes() for _, torque in plant.contact_effort()]
        trace += [part.tobytes() for part in block(plant)]
    return b''.join(trace)


@pytest.mark.parametrize('physics_rate', [1000, 4000])
def test_two_runs_and_a_reset_give_the_same_bits_through_contact(plant_in, physics_rate):
    start = {'tool': (-0.5, -0.1, 0.11), 'physics_rate': physics_rate}
    plant, other = plant_in('blocks', **start), plant_in('blocks', **start)
    first = run(plant)
    assert block(plant)[0][1] > 0.01, 'the block was pushed'
    assert run(other) == first
    plant.reset()
    assert run(plant) == first


def test_every_physics_step_has_its_row_of_contact_torque(plant_in):
    plant = plant_in('table', tool=(-0.5, -0.1, 0.1), physics_rate=4000)
    for _ in range(500):
        push(plant, (0.0, 0.0, -40.0))
    stamps = [stamp for stamp, _ in plant.contact_effort()]
    assert np.diff(stamps).tolist() == [250_000] * 3
    assert stamps[-1] == plant.stamp


def test_the_wrench_at_the_tool_is_the_force_of_the_contact_and_of_the_hand(plant_in):
    plant = plant_in('table', tool=(-0.5, -0.1, 0.1))
    for _ in range(500):
        push(plant, (0.0, 0.0, -40.0))
    last = plant.mechanics.contacts[-1]
    pose = forward_kinematics(np.array(last.q) + plant.arm.angle_offset, plant.arm)
    turn, lever = pose[:3, :3], last.points[0, 2:5] - pose[:3, 3]
    wrench = plant.tool_wrench()
    assert wrench[2] < -20.0, 'against the z of the tool, which looks down'
    assert np.abs(wrench[:3] - turn.T @ last.force[0]).max() < 1e-12
    assert np.abs(wrench[3:] - turn.T @ np.cross(lever, last.force[0])).max() < 1e-12
    hand = np.array([1.0, 2.0, 3.0])
    plant.apply_wrench(hand, (0.0, 0.0, 0.0))
    now = forward_kinematics(plant.truth.q + plant.arm.angle_offset, plant.arm)[:3, :3]
    assert np.abs(plant.tool_wrench()[:3] - wrench[:3] - now.T @ hand).max() < 1e-12


def test_contact_is_reported_when_it_begins_and_ends(plant_in):
    plant, events = plant_in('table', tool=(-0.5, -0.1, 0.1)), []
    for k in range(1500):
        push(plant, (0.0, 0.0, -30.0 if k < 700 else 30.0))
        events += [event for event in plant.drain_events() if event.kind == 'contact']
    begin, end = events
    assert begin.values['active'] == 'true' and end.values['active'] == 'false'
    assert begin.values['bodies'] == '["wrist_3_link", "table"]'
    assert 'wrist_3_link touches table with' in begin.message
    assert end.stamp > begin.stamp > 0


def test_a_force_above_its_limit_is_a_protective_stop(plant_in):
    plant = plant_in('table', tool=(-0.5, -0.1, 0.1), force_limit=50.0)
    for _ in range(500):
        push(plant, (0.0, 0.0, -30.0))
    assert plant.stopped
    assert any('above force_limit 50 N' in event.message for event in plant.drain_events())


def test_a_body_that_flies_away_ends_in_a_stop(plant_in, world_file):
    plant = plant_in(world_file(FLOOR, '{name: ball, shape: sphere, radius: 0.05, mass: 1.0, '
                                'position: [0.9, 0.9, 0.05]}'))
    plant.mechanics.world.bodies[0, 11] = 2000.0
    hold(plant)
    assert plant.stopped
    assert any('body ball flew away' in event.message for event in plant.drain_events())
    assert np.abs(block(plant)[0]).max() < 1.0


def test_links_far_apart_touch_each_other_where_self_contact_is_on(world_file):
    arm = load_arm('ur5')
    folded = [0.0, -0.3, 2.8, 0.0, 1.2, 0.0]
    path = world_file(FLOOR.replace('-0.05]', '-2.0]'))
    path.write_text(path.read_text() + 'self_contact: true\n')
    with pytest.raises(InputError, match='overlap by'):
        Plant(arm, {'world': str(path), 'initial_positions': folded})
    path.write_text(path.read_text().replace('self_contact: true', 'self_contact: false'))
    Plant(arm, {'world': str(path), 'initial_positions': folded}).close()


def test_a_world_that_overlaps_the_arm_is_refused_with_names_and_depth(plant_in):
    with pytest.raises(InputError, match=r'wrist_3_link and table overlap by \d+.* mm'):
        plant_in('table', tool=(-0.5, -0.1, 0.05))


def test_a_mesh_without_faces_is_refused_by_name(plant_in, world_file, tmp_path):
    (tmp_path / 'part.obj').write_text('# nothing\n')
    with pytest.raises(InputError, match='body part: mesh .*part.obj cannot be read'):
        plant_in(world_file('{name: part, shape: mesh, file: part.obj}'))


def test_a_mesh_is_felt_like_the_box_that_it_is(plant_in, world_file, tmp_path):
    corners = [(x, y, z) for x in (-2, 2) for y in (-2, 2) for z in (-0.05, 0.05)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    (tmp_path / 'slab.obj').write_text(
        ''.join(f'v {x} {y} {z}\n' for x, y, z in corners)
        + ''.join(f'f {a} {b} {c}\nf {a} {c} {d}\n' for a, b, c, d in faces))
    tool = 'tool:\n  - {shape: sphere, radius: 0.02, position: [0.0, 0.0, 0.05]}\n'
    meshed = plant_in(world_file('{name: slab, shape: mesh, file: slab.obj, position: '
                                 '[0.0, 0.0, -0.05]}', tool=tool), tool=(-0.5, -0.1, 0.1))
    boxed = plant_in(world_file('{name: slab, shape: box, size: [4.0, 4.0, 0.1], position: '
                                '[0.0, 0.0, -0.05]}', tool=tool), tool=(-0.5, -0.1, 0.1))
    for _ in range(500):
        one, other = (push(plant, (0.0, 0.0, -40.0)) for plant in (meshed, boxed))
        assert np.abs(one.q - other.q).max() < 1e-6
    assert forces(meshed)[2] > 20.0


def test_the_empty_world_has_no_contact_and_no_shapes_that_touch():
    arm = load_arm('ur5')
    plant = Plant(arm)
    assert plant.mechanics.world is None and plant.contact_effort() == []
    assert '<collision>' not in urdf_text(arm)
    assert '<collision>' in urdf_text(arm, world=load_world('table'))
    plant.close()


def test_a_tool_in_the_arms_file_touches_where_the_world_has_none(plant_in, world_file, tmp_path):
    arm = tmp_path / 'armed.yaml'
    arm.write_text(arm_text('ur5') + 'tool:\n  - {shape: sphere, radius: 0.02, position: '
                   '[0.0, 0.0, 0.05]}\n')
    plant = plant_in(world_file(FLOOR), arm=load_arm(str(arm)), tool=(-0.5, -0.1, 0.1))
    assert not plant.world.tool, 'a record has no shapes'
    plant = Plant(load_arm(str(arm)), plant.parameters.replaced({'arm': str(arm)}))
    assert [solid.shape for solid in plant.world.tool] == ['sphere']
    for _ in range(400):
        push(plant, (0.0, 0.0, -40.0))
    assert forces(plant)[2] > 20.0
    plant.close()
