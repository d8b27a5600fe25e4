"""Services and live parameters of the simulator, each a request to the loop."""

import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from ur5_ros.config import SIM_PARAMETERS
from ur5_ros.nodes.ros.background_executor import REQUEST_TIMEOUT, REQUESTS, add_service
from ur5_ros.nodes.ros.parameters import serve
from ur5_ros.nodes.ros.topics import Loop
from ur5_ros.nodes.ros.wait_set_loop import ReservedGroup
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.nodes.sim.simulation_interfaces import create_standard_services
from ur5_ros.sim.integrator import prepare_kernels

if TYPE_CHECKING:
    from ur5_ros.nodes.sim.node import SimNode

#: Single steps that may wait for their turn.
MOST_WAITING = 100


class StepRequest(NamedTuple):
    """A request for periods that is under way."""

    service: Any
    header: Any
    respond: Callable[[Any, bool, str], None]
    steps: int


class StepQueue:
    """``~/step`` and its like: taken and answered by the loop, so that nothing waits."""

    def __init__(self, node: Node, loop: Loop) -> None:
        self._node = node
        self._loop = loop
        self._services: list[tuple[Any, Callable, Callable]] = []
        self._waiting: deque[StepRequest] = deque()
        self._taken = 0
        self._progress_at = 0.0

        def fill(response: Trigger.Response, success: bool, message: str) -> None:
            response.success, response.message = success, message

        self.add_service(Trigger, '~/step', lambda request: 1, fill)

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def add_service(
        self, service_type: type, name: str, steps_of: Callable[[Any], int],
        fill: Callable[[Any, bool, str], None],
    ) -> None:
        """
        Serve steps by another service.

        ``fill``: ``fill(response, success, message)``.
        """
        service = self._node.create_service(
            service_type, name, lambda request, response: response,
            qos_profile=REQUESTS, callback_group=ReservedGroup())
        self._loop.watch_service(service)
        self._services.append((service, steps_of, fill))

    def update(self, simulation: Simulation) -> bool:
        """Accept or refuse the requests that have come; return whether one was accepted."""
        accepted = False
        for service, steps_of, fill in self._services:
            while True:
                request, header = service.handle.service_take_request(service.srv_type.Request)
                if request is None:
                    break
                step = StepRequest(service, header, fill, steps_of(request))
                if not simulation.paused:
                    _respond(step, False, 'time is running; call ~/pause with true first')
                elif simulation.stopped:
                    _respond(step, False, 'the simulation is stopped; call ~/pause with true '
                             'first')
                elif len(self._waiting) >= MOST_WAITING:
                    _respond(step, False, f'{MOST_WAITING} requests wait; wait for them')
                elif step.steps < 1:
                    _respond(step, True, f'paused at state {simulation.plant.k}')
                else:
                    if not self._waiting:
                        self._progress_at = time.monotonic()
                    self._waiting.append(step)
                    simulation.steps_requested += step.steps
                    accepted = True
        return accepted

    def answer(self, simulation: Simulation) -> None:
        """Take note of a period; answer the first request if it was its last."""
        self._taken += 1
        self._progress_at = time.monotonic()
        if self._taken >= self._waiting[0].steps:
            self._taken = 0
            _respond(self._waiting.popleft(), True, f'state {simulation.plant.k} is published')

    def expire(self, simulation: Simulation) -> None:
        """Refuse requests whose periods are not taken, as no command comes in lockstep."""
        if self._waiting and time.monotonic() - self._progress_at > REQUEST_TIMEOUT:
            self.refuse_all(simulation, f'no command came within {REQUEST_TIMEOUT:g} s, which '
                            'lockstep waits for; start a controller, or use lockstep:=false')

    def refuse_all(self, simulation: Simulation, why: str) -> None:
        """Answer all requests that will not get their periods."""
        simulation.steps_requested = self._taken = 0
        while self._waiting:
            _respond(self._waiting.popleft(), False, why)


def _respond(step: StepRequest, success: bool, message: str) -> None:
    response = step.service.srv_type.Response()
    step.respond(response, success, message)
    step.service.send_response(response, step.header)


def create_friction_service(node: Node) -> None:
    """Offer the service of UR's friction_model_controller, where ``ur_msgs`` is installed."""
    try:
        from ur_msgs.srv import SetFrictionModelParameters
    except ImportError:
        return

    def handle(request: Any, response: Any) -> Any:
        # the scales stand in the request, or in a message in it: ur_msgs has had both
        response.success = set_compensation(node, getattr(request, 'parameters', request))
        return response

    node.create_service(SetFrictionModelParameters, '~/set_friction_model_parameters', handle,
                        qos_profile=REQUESTS)


def set_compensation(node: Node, scales: Any) -> bool:
    """
    Set what the robot compensates of its friction, as parameters; return whether it was taken.

    ``scales``: with ``viscous_scale`` and ``coulomb_scale``, six numbers each.
    """
    result = node.set_parameters_atomically([
        Parameter(f'friction_compensation.{kind}_scale',
                  value=[float(x) for x in getattr(scales, f'{kind}_scale')])
        for kind in ('viscous', 'coulomb')])
    if not result.successful:
        node.get_logger().warning(result.reason)
    return bool(result.successful)


def create_services(node: Node, sim: 'SimNode') -> None:
    """
    Offer ``~/pause``, ``~/reset``, ``~/zero_force_torque_sensor`` and the parameters.

    ``~/step`` is :class:`StepQueue`.
    """
    call = sim.inputs.requests.call
    add_service(node, SetBool, '~/pause', lambda request: call(lambda: sim.pause(request.data)))
    add_service(node, Trigger, '~/reset', lambda request: call(sim.reset))
    add_service(node, Trigger, '~/zero_force_torque_sensor',
                lambda request: call(sim.simulation.zero_force_torque_sensor))
    add_service(node, Trigger, '~/resume_torque_mode',
                lambda request: call(sim.resume_torque_mode))
    create_friction_service(node)
    create_standard_services(node, sim)
    serve(node, SIM_PARAMETERS, lambda changes: call(lambda: sim.change(changes)), _prepare)


def _prepare(changes: dict[str, Any]) -> None:
    """Compile, or load, the kernels that friction needs and a plain arm does not."""
    if any(name.startswith('friction') for name in changes):
        prepare_kernels()
