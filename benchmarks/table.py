"""docs/performance.md from benchmarks/results/*.json."""

import argparse
import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / 'benchmarks' / 'results'
PAGE = ROOT / 'docs' / 'performance.md'
#: Titles come in this order, others after them.
ORDER = ('lockstep', 'profile', 'paced', 'recording', 'start', 'scaling', 'loop_without_ros',
         'sweep', 'sweep_proof', 'control', 'analysis', 'identification', 'bag')

HEAD = """# Performance

Made by `make bench` from `benchmarks/results/*.json`; do not edit.

Each figure is a ratio to a reference measured in the same run, the two in turn, a median where
there are several repeats: it says the same on another machine, where microseconds do not.
On a busy machine even ratios suffer, most of all where two processes wait for each other, so a
missed bar is worth a second look on a quiet one: `.venv/bin/python benchmarks/bench_lockstep.py`.
"""

TAIL = """## What stands in the way

- A lockstep period is two messages.  The ping-pong with a kept wait set is what the middleware
  takes for them, with no work done; physics, law, seven messages made and recorded come on top.
- What the nodes do costs two to three times as much in the loop of two processes as by itself:
  between two turns the other node, the middleware and the kernel have used the same caches.
- In one process (`ur5 demo --composed`) nobody is woken: a message is there when the other node
  takes it, and the caches stay warm.
- Each message wakes a thread of the middleware before it wakes the node: there is no way around
  it for types without a bound on their size.
- Sharing one core saves the waking of another on a quiet machine, and batch scheduling saves the
  interruptions; where others compute too, two processes bound to a core that they also use ran at
  half the speed of two that may move.  A loop of two nodes on two cores wakes an idle core twice a
  period.
- Shared memory would save the ping-pong more than the loop; the nodes do without it for the
  reasons in [the decision](decisions/loopback.md).
- Paced, a core sleeps between two periods: after 0.3 ms of sleep the same work takes three times
  as long as at once.
- A wait set has to be filled anew for each wait (rclpy's crashes if it is not): 2 microseconds an
  entity.  While the loop runs it holds the hot topic alone.
"""


def page(results: list[dict[str, Any]]) -> str:
    """Return the document for what the JSON files hold."""
    blocks = [HEAD]
    for result in results:
        blocks.append('\n'.join([
            f'## {result["title"]}', '', _where(result), '',
            '| measured | reference | ratio | bar | | |', '|---|---|---|---|---|---|',
            *map(_line, result['rows']), *_more(result), '']))
    missed = [f'- {result["title"]}: {row["measured"]}, {row["ratio"]:.3g} of {row["reference"]}'
              for result in results for row in result['rows'] if not row['met']]
    if missed:
        blocks.append('\n'.join(['## Bars missed in these runs', '', *missed, '']))
    return '\n'.join([*blocks, TAIL])


def _where(result: dict[str, Any]) -> str:
    machine = result['machine']
    packages = [f'{name} {number}' for name, number in machine.items()
                if name not in ('python', 'system', 'processor', 'cores')]
    return (f'{result["date"]}, {machine["processor"]}, {machine["cores"]} cores, '
            f'{machine["system"]}, Python {machine["python"]}, {", ".join(packages)}. '
            + result.get('note', '')).strip()


def _line(row: dict[str, Any]) -> str:
    sign = 'at least' if row['at_least'] else 'at most'
    return (f'| {row["measured"]} | {row["reference"]} | {row["ratio"]:.3g} '
            f'| {sign} {row["bar"]:.3g} | {"met" if row["met"] else "**missed**"} '
            f'| {row["detail"]} |')


def _more(result: dict[str, Any]) -> list[str]:
    """Return the lines of the tables that only some results have."""
    lines: list[str] = []
    if 'parts' in result:
        lines += ['', '| part of a period, both nodes | microseconds |', '|---|---|']
        lines += [f'| {name} | {cost * 1e6:.1f} |' for name, cost in result['parts'].items()]
    for name, costs in result.get('seconds_a_period', {}).items():
        lines += ['', f'| {name} | microseconds a period |', '|---|---|']
        lines += [f'| {value} | {cost * 1e6:.0f} |' for value, cost in costs.items()]
    return lines


def read(folder: Path) -> list[dict[str, Any]]:
    """Return the results of a folder in the order of the page."""
    found = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob('*.json'))}
    names = [name for name in ORDER if name in found]
    return [found[name] for name in [*names, *(name for name in found if name not in names)]]


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--results', type=Path, default=RESULTS)
    parser.add_argument('--page', type=Path, default=PAGE)
    options = parser.parse_args()
    options.page.write_text(page(read(options.results)))
    print(options.page)


if __name__ == '__main__':
    main()
