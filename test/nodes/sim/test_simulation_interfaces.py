"""The standard services as simulation_interfaces 1.5 defines them: states, codes, scopes."""

from types import SimpleNamespace

import pytest
from ros_processes import ros_domain, wait_until
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from ur5_ros.errors import InputError
from ur5_ros.nodes.sim.simulation_interfaces import create_standard_services

STOPPED, PLAYING, PAUSED, QUITTING = range(4)
UNSUPPORTED, OK, FAILED, ALREADY, TRANSITION, INCORRECT = 0, 1, 4, 101, 102, 103


class Client:
    """A client of the standard services of a simulator."""

    def __init__(self, ros, interfaces, **parameters):
        from simulation_interfaces import srv
        self.srv = srv
        self.node = ros.start('sim', environment=interfaces, bag='none', **parameters)
        self.observer = ros.observer()
        self.states = self.observer.subscribe(JointState, '/joint_states')

    def call(self, name, **fields):
        kind = getattr(self.srv, ''.join(word.title() for word in name.split('_')))
        request = kind.Request()
        for each, value in fields.items():
            setattr(request, each, value)
        return self.observer.call(kind, f'/ur5_sim/{name}', request)

    @property
    def state(self):
        answer = self.call('get_simulation_state')
        assert answer.result.result == OK
        return answer.state.state

    def go(self, state):
        """Ask for a state; return the result code."""
        kind = self.srv.SetSimulationState
        request = kind.Request()
        request.state.state = state
        answer = self.observer.call(kind, '/ur5_sim/set_simulation_state', request)
        assert answer.result.result in (OK, ALREADY) or answer.result.error_message
        return answer.result.result

    def stamp(self):
        stamp = self.states[-1].header.stamp
        return stamp.sec * 10**9 + stamp.nanosec


@pytest.fixture(scope='module')
def sim(tmp_path_factory, interfaces):
    with ros_domain(tmp_path_factory.mktemp('standard')) as ros:
        client = Client(ros, interfaces, lockstep=False, control_rate=250, physics_rate=1000)
        yield client
        assert client.node.stop() == 0, client.node.text


def test_a_simulator_says_what_it_can(sim):
    from simulation_interfaces.msg import SimulatorFeatures
    features = sim.call('get_simulator_features').features
    assert SimulatorFeatures.SIMULATION_RESET_STATE in features.features
    assert SimulatorFeatures.STEP_SIMULATION_MULTIPLE in features.features
    assert SimulatorFeatures.SIMULATION_RESET_TIME not in features.features


@pytest.mark.parametrize('way', [
    [(PLAYING, ALREADY)],
    [(PAUSED, OK), (PAUSED, ALREADY), (PLAYING, OK)],
    [(STOPPED, OK), (STOPPED, ALREADY), (PAUSED, OK), (PLAYING, OK)],
    [(PAUSED, OK), (STOPPED, OK), (PLAYING, OK)],
])
def test_the_state_is_the_one_asked_for(sim, way):
    assert sim.state == PLAYING
    for state, code in way:
        assert sim.go(state) == code
        assert sim.state == state


@pytest.mark.parametrize('state', [4, 5, 6, 255])
def test_a_state_that_it_cannot_have_is_unsupported(sim, state):
    assert sim.go(state) == UNSUPPORTED
    assert sim.state == PLAYING


def test_a_stopped_simulator_stands_in_its_initial_state(sim):
    assert sim.go(STOPPED) == OK
    still = sim.stamp()
    assert sim.states[-1].position == pytest.approx(sim.states[0].position, abs=1e-6)
    assert sim.call('step_simulation', steps=3).result.result == FAILED, 'not paused'
    assert sim.stamp() == still
    assert sim.observer.call(SetBool, '/ur5_sim/pause', SetBool.Request(data=True)).success
    assert sim.state == PAUSED
    assert sim.go(PLAYING) == OK


def test_steps_are_taken_while_paused_and_only_then(sim):
    refused = sim.call('step_simulation', steps=1).result
    assert refused.result == FAILED and 'running' in refused.error_message
    assert sim.go(PAUSED) == OK
    wait_until(lambda: sim.call('step_simulation', steps=0).result.result == OK, 'zero steps')
    before = sim.stamp()
    assert sim.call('step_simulation', steps=25).result.result == OK
    wait_until(lambda: sim.stamp() == before + 25 * 4_000_000, '25 periods')
    assert sim.state == PAUSED
    assert sim.go(PLAYING) == OK


def test_a_stop_ends_the_steps_under_way(sim):
    assert sim.go(PAUSED) == OK
    kind = sim.srv.StepSimulation
    steps = sim.observer.call_async(kind, '/ur5_sim/step_simulation', kind.Request(steps=10**6))
    before = sim.stamp()
    wait_until(lambda: sim.stamp() > before, 'a step')
    assert sim.go(STOPPED) == OK
    wait_until(steps.done, 'an answer to the steps')
    assert steps.result().result.result == FAILED
    assert 'stopped' in steps.result().result.error_message
    assert sim.state == STOPPED
    assert sim.go(PLAYING) == OK


@pytest.mark.parametrize(('scope', 'code'), [
    (0, OK), (2, OK), (255, OK), (1, UNSUPPORTED), (4, UNSUPPORTED), (3, UNSUPPORTED),
    (6, UNSUPPORTED)])
def test_a_scope_is_reset_or_refused(sim, scope, code):
    before = sim.stamp()
    answer = sim.call('reset_simulation', scope=scope).result
    assert answer.result == code and bool(answer.error_message) == (code == UNSUPPORTED)
    wait_until(lambda: sim.stamp() > before, 'time that goes on')


def test_steps_without_a_controller_are_answered(ros, interfaces):
    sim = Client(ros, interfaces)  # in lockstep, which waits for a command
    assert sim.go(PAUSED) == OK
    answer = sim.call('step_simulation', steps=2).result
    assert answer.result == FAILED and 'start a controller' in answer.error_message
    assert sim.state == PAUSED
    assert sim.go(QUITTING) == OK
    assert sim.node.ends() == 0, sim.node.text


def test_without_the_package_a_line_names_what_to_install(ros):
    sim = ros.start('sim', bag='none')
    sim.wait_for_line('recorded in')
    sim.lacks('simulation_interfaces')
    assert sim.stop() == 0


@pytest.mark.parametrize(('reason', 'state', 'code'), [
    ('SIGTERM', PLAYING, INCORRECT), ('SIGTERM', QUITTING, ALREADY), ('', PAUSED, TRANSITION)])
def test_a_simulator_that_ends_or_is_busy_says_so(interfaces, reason, state, code):
    """The moments between a request to end and the end are too short to be met by a client."""
    from simulation_interfaces import srv

    def busy(work):
        raise InputError('the node is busy or ending; try again')

    services = {}
    node = SimpleNamespace(create_service=lambda kind, name, handle: services.update(
        {name: (kind, handle)}))
    sim = SimpleNamespace(
        stop=SimpleNamespace(reason=reason), simulation=SimpleNamespace(
            stopped=False, paused=False),
        inputs=SimpleNamespace(requests=SimpleNamespace(call=busy)),
        steps=SimpleNamespace(add_service=lambda *_: None))
    create_standard_services(node, sim)
    request = srv.SetSimulationState.Request()
    request.state.state = state
    _, handle = services['~/set_simulation_state']
    answer = handle(request, srv.SetSimulationState.Response())
    assert answer.result.result == code
    assert bool(answer.result.error_message) == (code != ALREADY)
