"""How a period's cost grows: length of the run, control rate, number of arms at once."""

import numpy as np
from side_by_side import Row, arguments, publish
from two_nodes_recorded import arms_at_once, per_second, run

from ur5_ros.loop.run_config import run_config

LENGTHS = (3.0, 6.0, 12.0)
RATES = (125, 250, 500, 1000, 2000, 4000)
ARMS = (1, 2, 4, 8)
PERIODS = 2500
REPEATS = 3


def medians(measure, values, repeats: int) -> dict:
    """Return the median of ``measure`` for each value, taken in turn."""
    found = {value: [] for value in values}
    for _ in range(repeats):
        for value in values:
            found[value].append(measure(value))
    return {str(value): float(np.median(list_)) for value, list_ in found.items()}


def seconds_of_run(length: float) -> float:
    """Return the wall-clock time of a period of a run that long [s]."""
    return 1.0 / per_second(run(run_config(duration=length)).states)


def seconds_at_rate(rate: int, periods: int) -> float:
    """Return the wall-clock time of a period at a control rate [s]."""
    return 1.0 / per_second(run(run_config(duration=periods / rate, control_rate=rate)).states)


def seconds_of_arms(number: int, seconds: float) -> float:
    """Return the wall-clock time of a period of all arms together, per arm [s]."""
    every = arms_at_once(run_config(duration=seconds), number)
    begin, end = min(each.states[0] for each in every), max(each.states[-1] for each in every)
    return float(end - begin) * 1e-9 / sum(len(each.states) for each in every)


def main() -> None:
    """Measure and keep the table."""
    options = arguments(__doc__, REPEATS).parse_args()
    lengths, rates, arms = LENGTHS, RATES, ARMS
    periods, seconds, repeats = PERIODS, 3.0, options.repeats
    if options.quick:
        lengths, rates, arms, periods, seconds, repeats = (1.0, 2.0), (125,), (2,), 200, 1.0, 1
    length = medians(seconds_of_run, lengths, repeats)
    rate = medians(lambda value: seconds_at_rate(value, periods), rates, repeats)
    arm = medians(lambda value: seconds_of_arms(value, seconds), arms, repeats)
    publish('scaling', 'How the cost of a period grows, lockstep, recording on', [
        Row(f'a period of a run of {max(lengths):g} s', f'one of {min(lengths):g} s',
            length[str(max(lengths))] / length[str(min(lengths))], 1.1, False,
            'linear in the length'),
        Row(f'a period at {max(rates)} Hz', f'one at {min(rates)} Hz',
            rate[str(max(rates))] / rate[str(min(rates))], 1.1, False,
            'more physics steps a period at low rates, as physics stays at 1 kHz'),
        Row(f'a period of {max(arms)} arms at once, per arm', f'one of {min(arms)}',
            arm[str(max(arms))] / arm[str(min(arms))], 1.5, False,
            'each pair of nodes in a namespace of its own'),
    ], {'seconds_a_period': {'length of the run [s]': length, 'control rate [Hz]': rate,
                             'arms at once': arm}}, keep=not options.quick)


if __name__ == '__main__':
    main()
