"""
Processor time of compiling all that a demo needs, beside another version's on the same machine.

    python benchmarks/compile_time.py --other OTHER/.venv/bin/ur5

`ur5 demo` runs twice with an empty cache of its own, first cold, then warm: the difference is what
compiling took, in all processes together.  The two versions take turns.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import child
from side_by_side import Row, publish

OURS = Path(sys.executable).parent / 'ur5'


def demo(command: Path, cache: str) -> float:
    """Return the processor time of a demo and of the processes that it starts [s]."""
    environment = {name: value for name, value in os.environ.items()
                   if name not in ('PYTHONPATH', 'ROS_DOMAIN_ID')}
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        before = os.times()
        child.call([str(command), 'demo', '--run', f'{folder}/run'], cwd=folder,
                   env=environment | {'NUMBA_CACHE_DIR': cache}, stdin=subprocess.DEVNULL,
                   stdout=subprocess.DEVNULL)
        after = os.times()
    return (after.children_user + after.children_system
            - before.children_user - before.children_system)


def compiling(command: Path) -> float:
    """Return what a cold demo takes more than a warm one [s]."""
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as cache:
        cold, warm = demo(command, cache), demo(command, cache)
    print(f'{command}: {cold:.1f} s cold, {warm:.1f} s warm', flush=True)
    return cold - warm


def main() -> None:
    """Measure and keep the ratio."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--other', type=Path, required=True, metavar='UR5',
                        help='the command ur5 of the other version')
    parser.add_argument('--repeats', type=int, default=1)
    options = parser.parse_args()
    pairs = [(compiling(OURS), compiling(options.other)) for _ in range(options.repeats)]
    publish('compile_time', 'Compiling what a demo needs, processor time', [
        Row('compiling for the first demo', 'version 0.1, the same machine',
            median(ours / other for ours, other in pairs), 0.5, False,
            f'{median(ours for ours, _ in pairs):.1f} s against '
            f'{median(other for _, other in pairs):.1f} s'),
    ], {'seconds': pairs})


if __name__ == '__main__':
    main()
