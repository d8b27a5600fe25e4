"""
The simulator by the standard services of the package simulation_interfaces, where that is there.

The same functions stand under them as under ``~/pause``, ``~/step`` and ``~/reset``. The package
comes with a full ROS 2 installation only, so that these services are not run in CI.
"""

from typing import Any

from rclpy.node import Node

from ur5_ros.errors import InputError

#: simulation_interfaces/msg/SimulationState, field ``state``.
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
#: simulation_interfaces/msg/Result, field ``result``.
UNSUPPORTED, OK, INCORRECT_STATE, FAILED = 0, 1, 3, 4
#: simulation_interfaces/srv/SetSimulationState, beyond the codes of Result.
ALREADY_THERE = 101
#: simulation_interfaces/srv/ResetSimulation, field ``scope``: nothing named, or the state.
_DEFAULT_SCOPE, _STATE_SCOPE = 0, 2

#: Names in simulation_interfaces/msg/SimulatorFeatures of what is served.
FEATURES = ('SIMULATION_RESET', 'SIMULATION_RESET_STATE', 'SIMULATION_STATE_GETTING',
            'SIMULATION_STATE_SETTING', 'SIMULATION_STATE_PAUSE', 'STEP_SIMULATION_SINGLE',
            'STEP_SIMULATION_MULTIPLE')


def offer_standard_services(node: Node, sim: Any) -> bool:
    """
    Offer GetSimulatorFeatures, Get/SetSimulationState, ResetSimulation and StepSimulation.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    sim : SimNode
        Whose loop does what is asked.

    Returns
    -------
    bool
        Whether the package is there.

    """
    try:
        from simulation_interfaces import srv
        from simulation_interfaces.msg import SimulatorFeatures
    except ImportError:
        return False

    def features(request: Any, response: Any) -> Any:
        response.features.features = [
            getattr(SimulatorFeatures, name) for name in FEATURES
            if hasattr(SimulatorFeatures, name)]
        response.features.custom_info = 'a reset keeps simulated time going on'
        return response

    def get_state(request: Any, response: Any) -> Any:
        response.state.state = PAUSED if sim.simulation.paused else PLAYING
        response.result.result = OK
        return response

    def set_state(request: Any, response: Any) -> Any:
        response.result.result, response.result.error_message = _set_state(
            sim, request.state.state)
        return response

    def reset(request: Any, response: Any) -> Any:
        if request.scope not in (_DEFAULT_SCOPE, _STATE_SCOPE):
            response.result.result = UNSUPPORTED
            response.result.error_message = 'only the state can be reset; time goes on'
            return response
        response.result.result, response.result.error_message = _done(sim, sim.reset)
        return response

    def fill_step(response: Any, success: bool, message: str) -> None:
        response.result.result = OK if success else INCORRECT_STATE
        response.result.error_message = '' if success else message

    node.create_service(srv.GetSimulatorFeatures, '~/get_simulator_features', features)
    node.create_service(srv.GetSimulationState, '~/get_simulation_state', get_state)
    node.create_service(srv.SetSimulationState, '~/set_simulation_state', set_state)
    node.create_service(srv.ResetSimulation, '~/reset_simulation', reset)
    sim.steps.offer(srv.StepSimulation, '~/step_simulation',
                    lambda request: int(request.steps), fill_step)
    return True


def _set_state(sim: Any, state: int) -> tuple[int, str]:
    """Go to a standard state; return the result code and what went wrong."""
    if state == QUITTING:
        sim.stop.ask('asked to quit')
        return OK, ''
    if state == STOPPED:
        def stop() -> None:
            sim.pause(True)
            sim.reset()
        return _done(sim, stop)
    if state not in (PLAYING, PAUSED):
        return UNSUPPORTED, f'state {state} is unknown; give 0 to 3'
    if sim.simulation.paused == (state == PAUSED):
        return ALREADY_THERE, ''
    return _done(sim, lambda: sim.pause(state == PAUSED))


def _done(sim: Any, work: Any) -> tuple[int, str]:
    try:
        sim.inputs.requests.call(work)
    except InputError as error:
        return FAILED, str(error)
    return OK, ''
