"""Services and live parameters of the simulator, each a request to the loop."""

from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from ur5_ros.config import SIM_PARAMETERS
from ur5_ros.nodes.hot_loop import ReservedGroup
from ur5_ros.nodes.parameters import serve
from ur5_ros.nodes.serving import add_service
from ur5_ros.nodes.simulation import Simulation

#: Single steps that may wait for their turn.
MOST_WAITING = 100


class StepService:
    """
    ``~/step``: taken and answered by the loop itself, so that nothing else waits with it.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    loop
        Whose waits a request ends.

    """

    def __init__(self, node: Node, loop: Any) -> None:
        self.waiting: list[Any] = []
        """Requests that were let in, the first to be answered next."""
        self._service = node.create_service(
            Trigger, '~/step', lambda request, response: response,
            callback_group=ReservedGroup())
        loop.watch_service(self._service)

    def look(self, simulation: Simulation) -> bool:
        """Let in or refuse the requests that have come; return whether one was let in."""
        let_in = False
        handle = self._service.handle
        while True:
            request, header = handle.service_take_request(Trigger.Request)
            if request is None:
                return let_in
            if not simulation.paused:
                self._respond(header, False, 'time is running; call ~/pause with true first')
            elif len(self.waiting) >= MOST_WAITING:
                self._respond(header, False, f'{MOST_WAITING} steps are waiting; wait for them')
            else:
                self.waiting.append(header)
                simulation.steps_wanted += 1
                let_in = True

    def answer(self, simulation: Simulation) -> None:
        """Answer the first request: its period is over."""
        self._respond(self.waiting.pop(0), True, f'state {simulation.plant.k} is out')

    def refuse_all(self, simulation: Simulation, why: str) -> None:
        """Answer all requests that will not get their period."""
        simulation.steps_wanted = 0
        while self.waiting:
            self._respond(self.waiting.pop(0), False, why)

    def _respond(self, header: Any, success: bool, message: str) -> None:
        self._service.send_response(Trigger.Response(success=success, message=message), header)


def offer_services(node: Node, sim: Any) -> None:
    """
    Offer ``~/pause``, ``~/reset`` and the parameters; ``~/step`` is :class:`StepService`.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    sim : SimNode
        Whose loop does what is asked.

    """
    call = sim.inputs.requests.call
    add_service(node, SetBool, '~/pause', lambda request: call(lambda: sim.pause(request.data)))
    add_service(node, Trigger, '~/reset', lambda request: call(sim.reset))

    serve(node, SIM_PARAMETERS, lambda changes: call(lambda: sim.change(changes)))
