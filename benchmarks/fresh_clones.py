"""
From a fresh clone to the verdict: `make demo` on another Python beside Python 3.11.

    python benchmarks/fresh_clones.py --python python3.12 --reference python3.11

Each takes its turn in a clone of its own, with nothing but what the package index and pip's own
cache hold; both runs have to leave the same hashes.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from side_by_side import Row, publish

ROOT = Path(__file__).resolve().parents[1]
HASH = re.compile(r'\b[0-9a-f]{64}\b')
#: Longest that a clone may take to its verdict [s].
PATIENCE = 3600.0


def from_clone(python: str) -> tuple[float, list[str]]:
    """Return the wall time from `git clone` to the end of `make demo` [s], and the hashes said."""
    with tempfile.TemporaryDirectory(prefix='ur5-clone-') as folder:
        began = time.monotonic()
        subprocess.run(['git', 'clone', '--quiet', ROOT, f'{folder}/ur5_ros'], check=True)
        done = subprocess.run(['make', f'PYTHON={python}', 'demo'], cwd=f'{folder}/ur5_ros',
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                              timeout=PATIENCE)
        seconds = time.monotonic() - began
    if done.returncode:
        sys.exit(f'make PYTHON={python} demo ends with {done.returncode}:\n{done.stdout[-2000:]}')
    print(f'{python}: {seconds:.1f} s', flush=True)
    return seconds, sorted(set(HASH.findall(done.stdout)))


def main() -> None:
    """Measure and keep the ratio."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--python', default='python3.12')
    parser.add_argument('--reference', default='python3.11')
    parser.add_argument('--repeats', type=int, default=1)
    options = parser.parse_args()
    pairs = [(from_clone(options.python), from_clone(options.reference))
             for _ in range(options.repeats)]
    hashes = [said for pair in pairs for _, said in pair]
    if not hashes[0] or any(said != hashes[0] for said in hashes):
        sys.exit(f'the runs differ: {hashes}')
    seconds = [(ours, reference) for (ours, _), (reference, _) in pairs]
    publish('fresh_clones', 'From a fresh clone to the verdict of the demo, wall time', [
        Row(f'make PYTHON={Path(options.python).name} demo',
            f'make PYTHON={Path(options.reference).name} demo, the same hashes',
            median(ours / reference for ours, reference in seconds), 1.3, False,
            f'{median(ours for ours, _ in seconds):.0f} s against '
            f'{median(reference for _, reference in seconds):.0f} s'),
    ], {'seconds': seconds, 'hashes': hashes[0]})


if __name__ == '__main__':
    main()
