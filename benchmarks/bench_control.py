"""The controller's work in one control period, from the state to the torque, by kind of motion."""

import time
from collections.abc import Callable

import numpy as np
from side_by_side import Row, arguments, interleave, publish

from ur5_ros.control.controller import Controller, controller_from_parameters
from ur5_ros.control.joint_trajectory import TrajectoryPoint
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.signals import JOINT_NAMES, ArmState, stamp_of_period

RATE = 1000
PERIODS = 4000
BUDGET = 100e-6
START = np.deg2rad([20.0, -75.0, 90.0, -105.0, -80.0, 15.0])
SECOND = 1_000_000_000


def hold(controller: Controller) -> None:
    """Ask for nothing."""


def pose(controller: Controller) -> None:
    """Ask for a far pose at low speed, so that it moves all the time."""
    controller.change({'max_velocity': [0.2]})
    controller.target_pose(forward_kinematics(START + 0.9, controller.arm))


def path(controller: Controller) -> None:
    """Ask for a line that takes all the time, inverse kinematics included."""
    poses = np.tile(forward_kinematics(START, controller.arm), (3, 1, 1))
    poses[1:, 0, 3] += 0.1
    poses[2, 1, 3] += 0.1
    controller.path(poses, [0, 2 * SECOND, 4 * SECOND])


def trajectory(controller: Controller) -> None:
    """Ask for twenty quintic segments."""
    controller.joint_trajectory(JOINT_NAMES, [
        TrajectoryPoint(SECOND * (i + 1) // 5, (START + 0.02 * i).tolist(), [0.0] * 6, [0.0] * 6)
        for i in range(20)])


def experiment(controller: Controller) -> None:
    """Go through the paper's profile, tabled when the controller was made."""
    controller.start_experiment()


def off_grid(controller: Controller) -> None:
    """Go through it between the rows of its table: inverse kinematics in every period."""
    controller.start_experiment()


def work(ask: Callable[[Controller], None]) -> float:
    """Return the median work of one period [s]; planning is spread over the periods."""
    controller = controller_from_parameters({'experiment': 'kebria_fig11'},
                                            7 if ask is off_grid else RATE)
    zero = np.zeros(6)
    states = [ArmState(stamp_of_period(k, RATE), START.copy(), zero.copy(), zero)
              for k in range(1, PERIODS + 2)]
    controller.update(states[0])
    begin = time.perf_counter()
    ask(controller)
    planning = time.perf_counter() - begin
    times = []
    for state in states[1:]:
        begin = time.perf_counter()
        controller.update(state)
        times.append(time.perf_counter() - begin)
    return float(np.median(times)) + planning / PERIODS


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, 5).parse_args()
    kinds = (hold, experiment, off_grid, pose, trajectory, path)
    figures = interleave({kind.__name__: lambda kind=kind: work(kind) for kind in kinds},
                         1 if options.quick else options.repeats)
    medians = {name: float(np.median(values)) for name, values in figures.items()}
    publish('control', "The controller's work in a period", [
        Row(name.replace('_', ' '), '100 microseconds', value / BUDGET, 1.0, False,
            f'{value * 1e6:.1f} us') for name, value in medians.items()
    ], {'seconds': medians}, keep=not options.quick)


if __name__ == '__main__':
    main()
