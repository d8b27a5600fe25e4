"""A step of the plant with every part of friction against a plain step, side by side."""

import time

import numpy as np
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.config import load_arm
from ur5_ros.sim.plant import Plant

REPEATS, STEPS = 15, 3000

#: Every part of friction at once; the static part makes joints stick and slip.
EVERY_PART = {
    'friction.viscous': [9.0, 10.0, 9.0, 2.4, 2.1, 2.2],
    'friction.coulomb': [5.0, 6.0, 4.0, 1.3, 1.2, 1.2],
    'friction.static': [7.0, 8.0, 5.0, 1.6, 1.5, 1.4],
    'friction.load_factor': [0.05] * 6, 'friction.viscous_quadratic': [-2.0] * 3 + [-0.5] * 3,
    'friction.viscous_cubic': [0.4] * 3 + [0.1] * 3, 'friction.temperature_factor': [0.9] * 6,
    'friction.asymmetry': [0.1, -0.1, 0.05, 0.0, 0.02, -0.02]}
COMPENSATION = {f'friction_compensation.{kind}_scale': [0.8] * 6
                for kind in ('viscous', 'coulomb')}


class Stirred:
    """A weightless arm that torques stir, less than the limits and enough to slip."""

    def __init__(self, arm: str, size: float, **parameters) -> None:
        self._plant = Plant(load_arm(arm), {'gravity': [0.0, 0.0, 0.0], **parameters})
        phase = 0.05 * np.arange(STEPS)[:, None] + np.arange(6)
        self._torques = size * np.array([8.0, 9.0, 6.0, 1.8, 1.7, 1.6]) * np.sin(phase)

    def seconds(self) -> float:
        """Return the time of a step [s]."""
        plant, step = self._plant, self._plant.step
        plant.reset()
        begin = time.perf_counter()
        for torque in self._torques:
            step(torque)
        return (time.perf_counter() - begin) / STEPS


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    plants = {
        'plain': Stirred('ur5', 0.01),
        'every part': Stirred('ur5', 1.0, **EVERY_PART),
        'compensated': Stirred('ur5_real', 1.0, **EVERY_PART, **COMPENSATION),
    }
    for plant in plants.values():
        plant.seconds()  # compiles
    figures = interleave({name: plant.seconds for name, plant in plants.items()},
                         1 if options.quick else options.repeats)
    times = {name: float(np.median(values)) for name, values in figures.items()}
    publish('friction', 'A step of a plant with friction', [
        Row('with every part of friction', 'a plain step', ratio(figures, 'every part', 'plain'),
            2.5, False, f'{times["every part"] * 1e6:.1f} against {times["plain"] * 1e6:.1f} us'),
        Row('with rotors and compensation as well', 'a plain step',
            ratio(figures, 'compensated', 'plain'), 3.0, False,
            f'{times["compensated"] * 1e6:.1f} us'),
    ], {'parts': times}, keep=not options.quick)


if __name__ == '__main__':
    main()
