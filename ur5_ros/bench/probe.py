"""A first look at somebody's law: does it answer, in time, with six finite numbers?"""

import sys
import time

from ur5_ros.bench.entries import Entry
from ur5_ros.bench.limited_process import limit_memory, run_limited, write_result
from ur5_ros.bench.perturbations import ARM
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import full_loop
from ur5_ros.loop.run_config import run_config

#: Wall-clock time of the probe, and of one control period in it [s].
SECONDS, SLOWEST = 60.0, 0.02
#: Simulated time of the probe [s].
_DURATION = 0.1


def check_law(entry: Entry) -> None:
    """
    Run a tenth of a second with somebody's law, in a limited process.

    Raises
    ------
    InputError
        If it raises, returns no six finite numbers, takes too long or too much memory.

    """
    control = [f'{key}={value!r}' for key, value in entry.control.items()]
    found = run_limited(__name__, control, SECONDS)
    if found.why:
        raise InputError(f'{entry.name}: {found.why}')
    if found.result['why']:
        raise InputError(found.result['why'])
    if found.result['period'] > SLOWEST:
        raise InputError(f'{entry.name}: too late: it takes {1e3 * found.result["period"]:.3g} ms '
                         f'a period; give an answer within {1e3 * SLOWEST:g} ms')


def main(file: str, given: list[str]) -> None:
    """Run the law and write what came of it."""
    from ast import literal_eval
    control = {key: literal_eval(value) for key, _, value in
               (each.partition('=') for each in given)}
    ordinary = {'mode': 'gravity_pd', 'kp': [100.0], 'kd': [5.0]}
    try:
        seconds = []
        for chosen in (ordinary, control):
            config = run_config('multi_sine', ARM, duration=_DURATION, control=chosen)
            if chosen is control:
                limit_memory()
            began = time.perf_counter()
            full_loop(config)
            seconds.append(time.perf_counter() - began)
        write_result(file, {'why': '', 'period': seconds[1] / (1000 * _DURATION)})
    except InputError as error:
        write_result(file, {'why': str(error), 'period': 0.0})
    except MemoryError:
        write_result(file, {'why': 'the law takes more than 512 MB of memory', 'period': 0.0})


if __name__ == '__main__':
    main(sys.argv[1], sys.argv[2:])
