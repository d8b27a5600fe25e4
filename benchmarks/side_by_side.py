"""Figures that mean something on a noisy machine: ratios, interleaved in one run, medians."""

import argparse
import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

RESULTS = Path(__file__).parent / 'results'
PACKAGES = ('numpy', 'numba', 'pybullet', 'mcap', 'rclpy', 'pin', 'eaik', 'ssik', 'mujoco',
            'rosbags', 'mcap-ros2-support', 'mcap-ros2-support-fast')


class Row(NamedTuple):
    """One figure: a ratio to a reference measured in the same run, and the bar it has to meet."""

    measured: str
    reference: str
    ratio: float
    bar: float
    at_least: bool
    """The ratio has to reach the bar; otherwise to stay below it."""
    detail: str = ''

    @property
    def met(self) -> bool:
        """Tell whether the bar holds."""
        return self.ratio >= self.bar if self.at_least else self.ratio <= self.bar


def arguments(description: str, repeats: int) -> argparse.ArgumentParser:
    """Return the options that every benchmark has: ``--repeats`` and ``--quick``."""
    parser = argparse.ArgumentParser(description=description.strip().partition('\n')[0])
    parser.add_argument('--repeats', type=int, default=repeats)
    parser.add_argument('--quick', action='store_true',
                        help='show in a few seconds that it works; nothing is kept')
    return parser


def interleave(candidates: dict[str, Callable[[], float]], repeats: int) -> dict[str, list[float]]:
    """Call each candidate in turn, ``repeats`` times; each returns its own figure."""
    figures: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(repeats):
        for name, measure in candidates.items():
            figures[name].append(measure())
    return figures


def ratio(figures: dict[str, list[float]], measured: str, reference: str) -> float:
    """Return the median of the ratios of pairs taken one after the other."""
    pairs = zip(figures[measured], figures[reference], strict=True)
    return statistics.median(a / b for a, b in pairs)


def seconds_per_call(function: Callable[[], object], calls: int) -> float:
    """Return the mean time of one call [s] over ``calls`` calls."""
    start = time.perf_counter()
    for _ in range(calls):
        function()
    return (time.perf_counter() - start) / calls


def machine() -> dict[str, str]:
    """Return what the figures were measured on."""
    facts = {'python': platform.python_version(), 'system': platform.system(),
             'processor': processor(), 'cores': str(os.cpu_count())}
    for package in PACKAGES:
        try:
            facts[package] = version(package)
        except PackageNotFoundError:
            continue
    return facts


def processor() -> str:
    """Return the name of the processor, as the system reports it."""
    try:
        for line in Path('/proc/cpuinfo').read_text().splitlines():
            if line.startswith('model name'):
                return line.partition(':')[2].strip()
    except OSError:
        pass
    return platform.machine()


def realtime() -> bool:
    """Return whether others that compute too have to wait for this process."""
    return os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)


def publish(name: str, title: str, rows: list[Row], extra: dict | None = None,
            keep: bool = True, folder: Path = RESULTS) -> None:
    """Print the table and keep it as ``<name>.json`` in a folder."""
    print(f'\n{title}')
    width = max(len(row.measured) for row in rows)
    for row in rows:
        sign = '>=' if row.at_least else '<='
        print(f'  {row.measured:{width}}  {row.ratio:8.3g} of {row.reference}'
              f'  (bar {sign} {row.bar:g}: {"met" if row.met else "MISSED"})  {row.detail}')
    if not keep:
        return
    folder.mkdir(exist_ok=True)
    (folder / f'{name}.json').write_text(json.dumps({
        'title': title,
        'date': time.strftime('%Y-%m-%d', time.gmtime()),
        'machine': machine(),
        'note': f'Load average {os.getloadavg()[0]:.1f} at the end, priority {os.nice(0)}'
                + (', scheduled in real time.' if realtime() else '.'),
        'rows': [row._asdict() | {'met': row.met} for row in rows],
        **(extra or {}),
    }, indent=1) + '\n')
