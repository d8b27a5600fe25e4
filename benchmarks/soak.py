"""
Both nodes for a long time: memory at the same phase of the split cycle, lateness, every part read.

    python benchmarks/soak.py [--minutes 60] [--split 60] [--json FILE]

Half of the time in lockstep, half paced by the wall clock.  Each bag part is read as soon as it is
closed - whole, its stamps joined to the part before without a gap - and removed, so that an hour
needs no more room than some minutes.

Late is a paced state that came more than half a period after the schedule.  The schedule of each
second is that of its earliest states, and a part is judged by the best tenth of its seconds: nodes
that get slower get slower in these too, where a machine that others use, or that stood still,
does not show.  With more than twice its cores to do in the end it says nothing about the nodes.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
from soak_page import page

from ur5_ros.bag.reader import open_bag
from ur5_ros.launcher.node_processes import NodeProcesses
from ur5_ros.loop.run_config import run_config

#: Allowed growth of a node's own memory, pages of files aside, from warm-up to end [MiB].
GROWTH = 5.0
#: Share of the time that is warm-up: five minutes of an hour.
WARM_UP = 1 / 12
#: Allowed growth of the usual lateness of a paced state behind its schedule [s]; half a period.
LATER = 0.5e-3
#: Allowed growth of the share of late periods, beyond twice that of the beginning.
LATE_SHARE = 0.01
NODES = {'sim': ('ur5_ros.nodes.sim_node', '/joint_states'),
         'control': ('ur5_ros.nodes.control_node', '/joint_command')}


class Parts:
    """
    Reads the parts of one node's bag as they are closed.

    Parameters
    ----------
    folder : pathlib.Path
        Bag folder that grows.
    topic : str
        The topic that has a message every period.
    period : int
        Length of a period [ns].

    """

    def __init__(self, folder: Path, topic: str, period: int):
        self._folder, self._topic, self._period = folder, topic, period
        self._read = 0
        self._last: int | None = None
        self.states, self.gaps, self.problems = 0, 0, []
        self.lateness: list[float] = []
        self.late: list[float] = []
        self.load: list[float] = []
        self.summary: dict = {}

    def number(self, path: Path) -> int:
        """Return the place of a part among the others."""
        return int(path.stem.rpartition('_')[2])

    def closed(self, all_of_them: bool = False) -> bool:
        """Read the parts that are closed by now; tell whether there was a new one."""
        parts = sorted(self._folder.glob('*.mcap'), key=self.number)
        ready = parts if all_of_them else parts[:-1]
        for path in ready:
            self._check(path)
            path.unlink()
            self._read += 1
        return bool(ready)

    def _check(self, path: Path) -> None:
        bag = open_bag(path)
        columns = bag.joint_states(self._topic)
        self.problems += [f'{path.name}: {problem}' for problem in bag.problems]
        if not len(columns.stamp):
            self.problems.append(f'{path.name}: no {self._topic} in it')
            return
        stamps = np.unique(columns.stamp)  # copies of state 1 before the first answer
        if self._last is not None:
            stamps = np.concatenate([[self._last], stamps])
        self.gaps += int((np.abs(np.diff(stamps) - self._period) > 2).sum())
        self._last = int(stamps[-1])
        self.states += len(columns.stamp)
        lateness, late = by_second(columns.log_time - columns.stamp, columns.stamp, self._period)
        self.lateness.append(1e-9 * float(np.percentile(lateness, 10.0)))
        self.late.append(float(np.percentile(late, 10.0)))
        self.load.append(os.getloadavg()[0])
        self.summary = bag.notes.get('summary', self.summary)


def by_second(delay: np.ndarray, stamp: np.ndarray, period: int) -> tuple[list, list]:
    """
    Return how late the states of each second were, and which share of them too late.

    Parameters
    ----------
    delay : ndarray, shape (n,)
        Wall-clock time minus stamp [ns].
    stamp : ndarray, shape (n,)
        In order [ns].
    period : int
        Length of a period [ns].

    Returns
    -------
    lateness : list of float
        Median delay of each second beyond its second percentile [ns].
    late : list of float
        Share of the states of each second that were more than half a period behind it.

    """
    cuts = np.flatnonzero(np.diff(stamp // 10**9)) + 1
    seconds = [each - np.percentile(each, 2.0) for each in np.split(delay, cuts)]
    return ([float(np.median(each)) for each in seconds],
            [float(np.mean(each > 0.5 * period)) for each in seconds])


def soak(lockstep: bool, minutes: float, split: float, folder: Path) -> dict:
    """Run both nodes for some minutes; return what was seen, with ``failures`` in words."""
    plan = run_config(control={'max_bagfile_duration': split}, sim={
        'stop_after': 0.0, 'lockstep': lockstep, 'max_bagfile_duration': split})
    parts = {name: Parts(folder / name, topic, 10**9 // plan.sim.control_rate)
             for name, (_, topic) in NODES.items()}
    memory: dict[str, list[tuple[float, float, float]]] = {name: [] for name in NODES}
    handles: dict[str, list[tuple[int, int]]] = {name: [] for name in NODES}
    with NodeProcesses(folder) as nodes:
        for name, (module, _) in NODES.items():
            given = getattr(plan, name).changed_by_name()
            nodes.start(name, module, given | {'bag': str(folder / name)})
        watched = {name: psutil.Process(nodes.pid(name)) for name in NODES}
        began = time.monotonic()
        while (now := time.monotonic() - began) < 60.0 * minutes:
            time.sleep(0.2)
            for name in NODES:
                if nodes.poll(name) is not None:
                    raise SystemExit(f'{name}_node ended: {nodes.last_log_line(name)}')
                if parts[name].closed():
                    about = watched[name].memory_info()
                    resident, mapped = about.rss / 2**20, about.shared / 2**20
                    memory[name].append((now, resident, resident - mapped))
                    handles[name].append((watched[name].num_fds(), watched[name].num_threads()))
                    say(f'{now:7.0f} s  {name:8}{resident:8.1f} MiB')
        codes = {name: nodes.end(name) for name in NODES}
    for each in parts.values():
        each.closed(all_of_them=True)
    return judge(lockstep, minutes, parts, memory, codes) | {
        f'{name} files and threads': [each[0], each[-1]]
        for name, each in handles.items() if each} | {
        f'{name} memory by time [s, MiB]': [(round(when), round(resident, 1))
                                            for when, resident, _ in each]
        for name, each in memory.items()}


def judge(lockstep: bool, minutes: float, parts: dict[str, Parts], memory: dict,
          codes: dict[str, int]) -> dict:
    """Return the figures of a soak and what is wrong with them."""
    figures: dict = {'mode': 'lockstep' if lockstep else 'paced', 'minutes': minutes}
    failures = []
    for name, each in parts.items():
        figures[f'{name} states'], figures[f'{name} gaps'] = each.states, each.gaps
        if each.gaps and (lockstep or name == 'sim'):  # paced, a late answer is no answer
            failures.append(f'{name}: {each.gaps} gaps between stamps')
        failures += [f'{name}: {problem}' for problem in each.problems]
        if codes[name] != 0:
            failures.append(f'{name}_node ended with code {codes[name]}')
        warm = [each for each in memory[name] if each[0] >= 60 * minutes * WARM_UP]
        if len(warm) < 2:
            failures.append(f'{name}: {len(warm)} splits after the warm-up; run longer')
            continue
        (_, *first), (_, *last) = warm[0], warm[-1]
        figures[f'{name} memory [MiB]'] = [round(first[0], 1), round(last[0], 1)]
        grown = last[1] - first[1]  # pages of files come and go with what code runs
        figures[f'{name} growth of its own memory [MiB]'] = round(grown, 1)
        if grown > GROWTH:
            failures.append(f'{name}: memory grew by {grown:.1f} MiB; at most {GROWTH:g}')
    if not lockstep:
        failures += judge_lateness(parts['sim'], figures)
    return figures | {'failures': failures}


def judge_lateness(sim: Parts, figures: dict) -> list[str]:
    """Compare the first parts after the warm-up with the last ones; return what got worse."""
    parts = sim.lateness[max(1, round(WARM_UP * len(sim.lateness))):]
    third = max(1, len(parts) // 3)
    early, late = (1e3 * float(np.median(each)) for each in (parts[:third], parts[-third:]))
    shares = sim.late[-len(parts):]
    first, last = (float(np.median(each)) for each in (shares[:third], shares[-third:]))
    counters = sim.summary.get('counters', {})
    figures['usual lateness, first and last third [ms]'] = [round(early, 4), round(late, 4)]
    figures['late periods, first and last third [%]'] = [round(100 * first, 3),
                                                         round(100 * last, 3)]
    figures['schedule moved by stalls of the machine [s]'] = counters.get('schedule_lost_s')
    figures['longest delay of a period [s]'] = counters.get('worst_lateness_s')
    load = float(np.median(sim.load[-third:]))
    figures['load average in the last third'] = round(load, 1)
    failures: list[str] = []
    if load > 2.0 * (os.cpu_count() or 1):
        figures['lateness'] = 'not judged: this machine did too much else in the last third'
        return failures
    if late - early > 1e3 * LATER:
        failures.append(f'states came {late - early:.2f} ms later at the end than at the start; '
                        f'at most {1e3 * LATER:g}')
    if last > 2.0 * first + LATE_SHARE:
        failures.append(f'{100 * last:.1f} % of the periods late at the end, {100 * first:.1f} % '
                        f'at the start; at most {200 * first + 100 * LATE_SHARE:.1f} %')
    return failures


def say(line: str) -> None:
    """Print a line of progress."""
    print(line, file=sys.stderr, flush=True)


def main() -> int:
    """Run both modes; 0 if nothing failed."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--minutes', type=float, default=60.0, help='for both modes together')
    parser.add_argument('--split', type=float, default=60.0, help='length of a bag part [s]')
    parser.add_argument('--json', type=Path, help='figures as JSON')
    parser.add_argument('--page', type=Path, help='figures as a document')
    arguments = parser.parse_args()
    results = []
    for lockstep in (True, False):
        say(f'{"lockstep" if lockstep else "paced"}, {arguments.minutes / 2:g} minutes')
        with tempfile.TemporaryDirectory(prefix='ur5-soak-') as folder:
            results.append(soak(lockstep, arguments.minutes / 2, arguments.split, Path(folder)))
    for result in results:
        for key, value in result.items():
            print(f'{key}: {value}')
    if arguments.json:
        arguments.json.write_text(json.dumps(results) + '\n', encoding='utf-8')
    if arguments.page:
        arguments.page.write_text(page(results), encoding='utf-8')
    return 1 if any(result['failures'] for result in results) else 0


if __name__ == '__main__':
    sys.exit(main())
