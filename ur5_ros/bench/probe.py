"""A first look at a user's law: does it answer, in time, with six finite numbers?"""

import sys
import time
from pathlib import Path
from typing import Any

from ur5_ros.bench.entries import Entry, user_entry
from ur5_ros.bench.limited_process import OUT_OF_MEMORY, end_with, limit_resources, run_limited
from ur5_ros.bench.perturbations import ARM
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import full_loop
from ur5_ros.loop.run_config import run_config

#: Wall-clock time of the probe and of a run with the law, and of one control period in it [s].
TIMEOUT, SLOWEST_PERIOD = 60.0, 0.02
#: Simulated time of the probe [s].
_DURATION = 0.1


def probed_entry(file: Path, gains: Path | None = None, seconds: float = TIMEOUT) -> Entry:
    """
    Return a user's law with its gains, after a tenth of a second with it in a limited process.

    The file is read there alone: what it does to its process, it does not do to this one.

    ``file``: A Python file with a class ``Law``; ``seconds``: wall-clock time of the probe and,
    later, of each run with the law.
    """
    if file.is_dir():
        raise InputError(f'{file} is a folder; give a Python file that defines class Law')
    if not file.is_file():
        raise InputError(f'no file {file}; give a Python file that defines class Law')
    arguments = [str(file), *([] if gains is None else [str(gains.resolve())])]
    found = run_limited(__name__, arguments, seconds, Path.cwd())
    why = found.why or found.result['why']
    if why:
        raise InputError(why if str(file) in why else f'{file}: {why}')
    if found.result['period'] > SLOWEST_PERIOD:
        raise InputError(f'{file}: too late: it takes {1e3 * found.result["period"]:.3g} ms '
                         f'a period; give an answer within {1e3 * SLOWEST_PERIOD:g} ms')
    return Entry(file.name, found.result['control'], seconds)


def probe(file: str, gains: str | None) -> dict[str, Any]:
    """Run the law; return its parameters and what came of it."""
    try:
        limit_resources()
        entry = user_entry(file, None if gains is None else Path(gains))
        config = run_config('multi_sine', ARM, duration=_DURATION, control=entry.control)
        began = time.perf_counter()
        full_loop(config)
        return {'why': '', 'period': (time.perf_counter() - began) / (1000 * _DURATION),
                'control': entry.control}
    except InputError as error:
        return {'why': str(error)}
    except MemoryError:
        return {'why': f'the law takes {OUT_OF_MEMORY}'}


def load_package() -> None:
    """Run an ordinary law, which loads what the package needs, before memory is limited."""
    ordinary = {'mode': 'gravity_pd', 'kp': [100.0], 'kd': [5.0]}
    full_loop(run_config('multi_sine', ARM, duration=_DURATION, control=ordinary))


def main(result: str, file: str, gains: str | None = None) -> None:
    """Probe a law."""
    load_package()
    end_with(result, probe(file, gains))


if __name__ == '__main__':
    main(*sys.argv[1:])
