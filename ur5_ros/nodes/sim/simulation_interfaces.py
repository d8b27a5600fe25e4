"""
The simulator by the standard services of the package simulation_interfaces, where that is there.

The same functions stand under them as under ``~/pause``, ``~/step`` and ``~/reset``; states and
result codes are those of simulation_interfaces 1.5.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.node import Node

from ur5_ros.errors import InputError

if TYPE_CHECKING:
    from ur5_ros.nodes.sim.node import SimNode

#: simulation_interfaces/msg/SimulationState, field ``state``.
STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD, LOADING_WORLD = range(6)
#: simulation_interfaces/msg/Result, field ``result``.
UNSUPPORTED, OK, FAILED = 0, 1, 4
#: simulation_interfaces/srv/SetSimulationState, beyond the codes of Result.
ALREADY_THERE, TRANSITION_ERROR, INCORRECT_TRANSITION = 101, 102, 103
#: simulation_interfaces/srv/ResetSimulation, field ``scope``: default and all are the same.
_DEFAULT_SCOPE, _STATE_SCOPE, _ALL_SCOPE = 0, 2, 255

#: Names in simulation_interfaces/msg/SimulatorFeatures of what is served.
FEATURES = ('SIMULATION_RESET', 'SIMULATION_RESET_STATE', 'SIMULATION_STATE_GETTING',
            'SIMULATION_STATE_SETTING', 'SIMULATION_STATE_PAUSE', 'STEP_SIMULATION_SINGLE',
            'STEP_SIMULATION_MULTIPLE')


def create_standard_services(node: Node, sim: 'SimNode') -> None:
    """
    Offer GetSimulatorFeatures, Get/SetSimulationState, ResetSimulation and StepSimulation.

    Without the package a line is logged.
    """
    try:
        from simulation_interfaces import srv
        from simulation_interfaces.msg import SimulatorFeatures
    except ImportError:
        node.get_logger().info('simulation_interfaces is not installed: no standard services '
                               '(ros-jazzy-simulation-interfaces)')
        return

    def features(request: Any, response: Any) -> Any:
        response.features.features = [
            getattr(SimulatorFeatures, name) for name in FEATURES
            if hasattr(SimulatorFeatures, name)]
        response.features.custom_info = 'a reset of any scope lets simulated time go on'
        return response

    def get_state(request: Any, response: Any) -> Any:
        response.state.state = _state(sim)
        response.result.result = OK
        return response

    def set_state(request: Any, response: Any) -> Any:
        response.result.result, response.result.error_message = _set_state(
            sim, request.state.state)
        return response

    def reset(request: Any, response: Any) -> Any:
        result = response.result
        if request.scope in (_DEFAULT_SCOPE, _STATE_SCOPE, _ALL_SCOPE):
            result.result, result.error_message = _done(sim, sim.reset, FAILED)
        else:
            result.result = UNSUPPORTED
            result.error_message = (f'scope {request.scope}: only the state can be reset, as time '
                                    'goes on and nothing is spawned; give 0, 2 or 255')
        return response

    def fill_step(response: Any, success: bool, message: str) -> None:
        response.result.result = OK if success else FAILED
        response.result.error_message = '' if success else message

    node.create_service(srv.GetSimulatorFeatures, '~/get_simulator_features', features)
    node.create_service(srv.GetSimulationState, '~/get_simulation_state', get_state)
    node.create_service(srv.SetSimulationState, '~/set_simulation_state', set_state)
    node.create_service(srv.ResetSimulation, '~/reset_simulation', reset)
    sim.steps.add_service(srv.StepSimulation, '~/step_simulation',
                    lambda request: int(request.steps), fill_step)


def _state(sim: 'SimNode') -> int:
    """Return the state as the standard names it."""
    if sim.stop.reason:
        return QUITTING
    if sim.simulation.stopped:
        return STOPPED
    return PAUSED if sim.simulation.paused else PLAYING


def _set_state(sim: 'SimNode', state: int) -> tuple[int, str]:
    """Go to a standard state; return the result code and what went wrong."""
    if state in (NO_WORLD, LOADING_WORLD):
        return UNSUPPORTED, f'state {state}: no world is loaded or unloaded here; give 0 to 3'
    if state > LOADING_WORLD:
        return UNSUPPORTED, f'state {state} is unknown; give 0 to 3'
    present = _state(sim)
    if present == state:
        return ALREADY_THERE, ''
    if present == QUITTING:
        return INCORRECT_TRANSITION, 'the simulator is quitting; start it again'
    if state == QUITTING:
        sim.stop.ask('asked to quit')
        return OK, ''
    change = sim.stop_simulation if state == STOPPED else lambda: sim.pause(state == PAUSED)
    return _done(sim, change, TRANSITION_ERROR)


def _done(sim: 'SimNode', work: Callable[[], Any], failure: int) -> tuple[int, str]:
    try:
        sim.inputs.requests.call(work)
    except InputError as error:
        return failure, str(error)
    return OK, ''
