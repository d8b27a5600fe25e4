"""The loop without ROS against PyBullet's bare set-step-read loop, measured side by side."""

import time

import numpy as np
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.loop.closed_loop import full_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.rollout import rollout
from ur5_ros.loop.run_config import RunConfig, arm_named, run_config
from ur5_ros.sim.bullet_arm import BulletArm
from ur5_ros.sim.pybullet_import import pybullet
from ur5_ros.sweep.run import row_of
from ur5_ros.sweep.spec import expand, parse_sweep

REPEATS = 9
DURATION = 20.0


class BareLoop:
    """Set six torques, step, read six joints: what nobody can do without."""

    def __init__(self, plan: RunConfig, torque: np.ndarray) -> None:
        arm = arm_named('ur5')
        self._start = plan.sim.initial_positions
        self._torque = torque.tolist()
        self._arm = BulletArm(arm, arm.gravity, 1e-3)

    def periods_per_second(self) -> float:
        """Run once through the torques of the experiment."""
        arm = self._arm
        arm.place(self._start, [0.0] * 6)
        client, body, joints = arm._client, arm._body, list(range(6))
        begin = time.perf_counter()
        for torque in self._torque:
            pybullet.setJointMotorControlArray(body, joints, pybullet.TORQUE_CONTROL,
                                               forces=torque, physicsClientId=client)
            pybullet.stepSimulation(physicsClientId=client)
            pybullet.getJointStates(body, joints, physicsClientId=client)
        return len(self._torque) / (time.perf_counter() - begin)


def rate(function, plan: RunConfig) -> float:
    """Return periods a second of one run, everything from the plan to the arrays in it."""
    begin = time.perf_counter()
    function(plan)
    return plan.periods / (time.perf_counter() - begin)


def sweep_rate() -> float:
    """Return periods a second of a run of a sweep, its row included."""
    spec = parse_sweep(f'name: bench\nduration: {DURATION}\njudge: metrics\n'
                       'success: {max_error: 1.0}\nvary:\n  arm: [ur5]\n', 'bench')
    run, = expand(spec)
    begin = time.perf_counter()
    row_of(spec, run, None)
    return DURATION * 1000 / (time.perf_counter() - begin)


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    plan = run_config(duration=DURATION)
    run = rollout(plan)  # compiles, plans, opens the world
    as_run(run)
    bare = BareLoop(plan, run.torque[:, 0])
    figures = interleave({
        'bare': bare.periods_per_second,
        'ordinary': lambda: rate(rollout, plan),
        'bare again': bare.periods_per_second,
        'sweep': sweep_rate,
        'full': lambda: rate(full_loop, plan),
    }, 1 if options.quick else options.repeats)
    reference = 'bare PyBullet set-step-read loop'
    median = {name: float(np.median(values)) for name, values in figures.items()}
    publish('loop_without_ros', 'Loop without ROS, model and law included', [
        Row('an ordinary run, periods a second', reference, ratio(figures, 'ordinary', 'bare'),
            0.5, True, f'{median["ordinary"]:.0f} against {median["bare"]:.0f} a second'),
        Row('a run of a sweep, its row included', reference,
            ratio(figures, 'sweep', 'bare again'), 0.5, True,
            f'{median["sweep"]:.0f} a second'),
        Row('Plant and Controller as the nodes run them', reference,
            ratio(figures, 'full', 'bare again'), 0.1, True, f'{median["full"]:.0f} a second'),
    ], {'periods_per_second': median}, keep=not options.quick)


if __name__ == '__main__':
    main()
