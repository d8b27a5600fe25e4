"""
From a fresh clone to the verdict: `make demo` on another Python, and of an older commit.

    python benchmarks/fresh_clones.py --python python3.12 --reference python3.11 --old COMMIT

Each takes its turn in a clone of its own, with nothing but what the package index and pip's own
cache hold; both runs have to leave the same hashes.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

from side_by_side import Row, publish

ROOT = Path(__file__).resolve().parents[1]
HASH = re.compile(r'\b[0-9a-f]{64}\b')
#: 90 s where version 0.1 took 125.
OLD_BAR = 0.72
#: Longest that a clone may take to its verdict [s].
TIMEOUT = 3600.0


class Clone(NamedTuple):
    """What a clone took to its verdict."""

    wall: float
    """From `git clone` to the end of `make demo` [s]."""
    processor: float
    """Of all processes together [s]: a busy machine changes it least."""
    hashes: list[str]
    """What the demo said."""


def from_clone(python: str, commit: str = 'HEAD') -> Clone:
    """Clone, make the demo of a commit with a Python, and return what it took."""
    with tempfile.TemporaryDirectory(prefix='ur5-clone-') as folder:
        began, before = time.monotonic(), os.times()
        subprocess.run(['git', 'clone', '--quiet', ROOT, f'{folder}/ur5_ros'], check=True)
        subprocess.run(['git', '-C', f'{folder}/ur5_ros', '-c', 'advice.detachedHead=false',
                        'checkout', '--quiet', commit], check=True)
        done = subprocess.run(['make', f'PYTHON={python}', 'demo'], cwd=f'{folder}/ur5_ros',
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                              timeout=TIMEOUT)
        seconds, after = time.monotonic() - began, os.times()
    if done.returncode:
        sys.exit(f'make PYTHON={python} demo ends with {done.returncode}:\n{done.stdout[-2000:]}')
    processor = (after.children_user + after.children_system
                 - before.children_user - before.children_system)
    print(f'{python}, {commit}: {seconds:.1f} s, {processor:.1f} s of processor time', flush=True)
    return Clone(seconds, processor, sorted(set(HASH.findall(done.stdout))))


def main() -> None:
    """Measure and keep the ratio."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--python', default='python3.12')
    parser.add_argument('--reference', default='python3.11')
    parser.add_argument('--old', default='20d0b35', metavar='COMMIT', help='of version 0.1')
    parser.add_argument('--repeats', type=int, default=1)
    options = parser.parse_args()
    rounds = [{'other': from_clone(options.python), 'ours': from_clone(options.reference),
               'old': from_clone(options.reference, options.old)} for _ in range(options.repeats)]
    hashes = [clone.hashes for each in rounds for clone in each.values()]
    if not hashes[0] or any(printed != hashes[0] for printed in hashes):
        sys.exit(f'the runs differ: {hashes}')
    other = f'make PYTHON={Path(options.python).name} demo'
    publish('fresh_clones', 'From a fresh clone to the verdict of the demo', [
        row(other, what, 'Python 3.11, the same hashes', 1.3,
            [(each['other'][i], each['ours'][i]) for each in rounds])
        for i, what in enumerate(('wall time', 'processor time'))
    ] + [row('make demo', 'wall time', 'version 0.1, the same hashes', OLD_BAR,
             [(each['ours'].wall, each['old'].wall) for each in rounds])],
        {'seconds': [{name: clone[:2] for name, clone in each.items()} for each in rounds],
         'hashes': hashes[0]})


def row(measured: str, what: str, reference: str, bar: float,
        pairs: list[tuple[float, float]]) -> Row:
    """Return the row of one kind of time; ``pairs``: of this one and of the reference [s]."""
    return Row(f'{measured}, {what}', reference, median(a / b for a, b in pairs), bar, False,
               f'{median(a for a, _ in pairs):.0f} s against {median(b for _, b in pairs):.0f} s')


if __name__ == '__main__':
    main()
