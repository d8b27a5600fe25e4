"""Services and live parameters of the controller, each a request to the loop."""

from typing import TYPE_CHECKING, Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from ur5_ros.config import CONTROL_PARAMETERS
from ur5_ros.nodes.control.trajectory_action import TrajectoryAction, create_trajectory_action
from ur5_ros.nodes.ros.background_executor import add_service
from ur5_ros.nodes.ros.parameters import serve

if TYPE_CHECKING:
    from ur5_ros.nodes.control.node import ControlNode


def create_services(node: Node, control: 'ControlNode') -> TrajectoryAction | None:
    """Offer ``~/start_experiment``, ``~/hold``, the parameters and, if it can be, the action."""
    def start(request: Any) -> str:
        # the controller may be another one by the time that the loop gets to it
        control.requests.call(lambda: control.cycle.controller.start_experiment())
        return 'the experiment starts'

    def hold(request: Any) -> str:
        control.requests.call(lambda: control.cycle.controller.hold())
        return 'the arm comes to rest'

    add_service(node, Trigger, '~/start_experiment', start)
    add_service(node, Trigger, '~/hold', hold)
    serve(node, CONTROL_PARAMETERS,
          lambda changes: control.requests.call(lambda: control.change(changes)), control.prepare)
    return create_trajectory_action(node, control)
