"""A step with one contact against the plain step of the same plant, measured side by side."""

import time

import numpy as np
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.config import load_arm
from ur5_ros.config.experiments import load_experiment
from ur5_ros.control.experiment import experiment_trajectory
from ur5_ros.model.dynamics import gravity_torque, inertia_matrix
from ur5_ros.model.kinematics import jacobian
from ur5_ros.sim.plant import Plant

REPEATS = 15
STEPS = 300


class Pressing:
    """The finger on the table, or the same arm without a world: time of a step alone."""

    def __init__(self, world: str) -> None:
        arm = load_arm('ur5')
        motion = experiment_trajectory(load_experiment('press_and_slide'), arm, 1000, 0.02)
        self._rest = motion.trajectory.at(1_000_000_000).q  # where the finger touches
        start = motion.trajectory.at(990_000_000).q
        self._plant = Plant(arm, {'world': world, 'initial_positions': start.tolist()})
        self._press = np.array([0.0, 0.0, -20.0, 0.0, 0.0, 0.0]) * (world != 'empty')
        self.seconds_per_step(2000)
        if world != 'empty':
            assert len(self._plant.mechanics.contacts[-1].pairs) == 1, 'one contact'

    def seconds_per_step(self, steps: int = STEPS) -> float:
        """Return the median time of a step [s]."""
        plant, arm, taken = self._plant, self._plant.arm, []
        for _ in range(steps):
            q, qd = plant.state.q, plant.state.qd
            hold = inertia_matrix(q, arm) @ (200.0 * (self._rest - q) - 40.0 * qd)
            tau = gravity_torque(q, arm) + hold + jacobian(q, arm).T @ self._press
            begin = time.perf_counter()
            plant.step(tau)
            taken.append(time.perf_counter() - begin)
        return float(np.median(taken))


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    plain, touching = Pressing('empty'), Pressing('table')
    figures = interleave({'plain': plain.seconds_per_step, 'contact': touching.seconds_per_step},
                         1 if options.quick else options.repeats)
    median = {name: float(np.median(values)) for name, values in figures.items()}
    publish('contact', 'A step in contact', [
        Row('a step with one contact', 'the plain step', ratio(figures, 'contact', 'plain'), 2.0,
            False, f'{1e6 * median["contact"]:.1f} against {1e6 * median["plain"]:.1f} us'),
    ], {'seconds_per_step': median}, keep=not options.quick)


if __name__ == '__main__':
    main()
