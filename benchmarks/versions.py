"""
This version against an older one, side by side: plant, law, loop, model, both nodes, their start.

    python benchmarks/versions.py --old FOLDER

FOLDER is a checkout of the older version with its own ``.venv``.  Each round asks one after the
other, so that both see the same machine; a ratio is the median over the rounds.  "General way" is
all that a step or an update checks: version 0.1 had a faster copy of both for periods in which
nothing else happens, which is left out there; since then there is one way.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import child
from side_by_side import Row, arguments, interleave, publish, ratio

PROBE = Path(__file__).with_name('version_probe.py')
HERE = Path(__file__).resolve().parents[1]
REPEATS = 7
#: Figures to the ratio that they must keep, where it is not 1.
BARS = {
    'step, a command within the limits': 0.6,
    'step, caches emptied before each call': 0.6,
    'step within the node, general way': 0.6,
    'update, a command within the limits': 0.5,
    'update, caches emptied before each call': 0.5,
    'update within the node, general way': 0.5,
    # batches gave up kernels of eight lanes: their bar is Pinocchio, in bench_model.py
    'inverse dynamics of 100,000': 4.0,
    'forward dynamics of 100,000': 4.0,
}
#: What the nodes print once their state or answer can go out.
STARTED = {'sim_node': 'recorded in', 'control_node': 'waiting for states'}
#: The bar of the others: the scatter of two equal figures on a quiet machine.
SCATTER = 1.05


def probe(checkout: Path, group: str, scale: float) -> dict[str, float]:
    """Return a group of figures of a checkout [s]."""
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder:
        try:
            done = child.call([python(checkout), str(PROBE), group, str(scale)], cwd=folder,
                              capture_output=True, text=True, env=environment())
        except subprocess.CalledProcessError as error:
            raise SystemExit(f'{checkout}: {group}: {error.stderr.strip()}') from None
    return json.loads(done.stdout.splitlines()[-1])


def python(checkout: Path) -> str:
    """Return the interpreter of a checkout."""
    return str(checkout / '.venv' / 'bin' / 'python')


def environment() -> dict[str, str]:
    """Return the environment, with both nodes on one core, as a quiet machine has them."""
    return os.environ | {'UR5_ROS_CORE': str(max(os.sched_getaffinity(0)))}


def start(checkout: Path, node: str, line: str) -> float:
    """Return the time from the start of a node until it prints that it has begun [s]."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as folder, child.start(
            [python(checkout), '-m', f'ur5_ros.nodes.{node}', '--ros-args', '-p', "bag:=''"],
            cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env=environment() | {'PYTHONUNBUFFERED': '1', 'ROS_LOG_DIR': folder}) as process:
        assert process.stdout is not None
        for printed in process.stdout:
            if line in printed:
                break
        seconds = time.perf_counter() - begin
        process.terminate()
        process.stdout.read()
    return seconds


def measure(checkout: Path, scale: float) -> dict[str, float]:
    """Return every figure of a checkout [s]."""
    found = {}
    for group in ('loops', 'runs', 'model', 'two_nodes'):
        found |= probe(checkout, group, scale)
    return found | {f'start of {node}': start(checkout, node, line)
                    for node, line in STARTED.items()}


def main() -> None:
    """Measure and keep the table."""
    parser = arguments(__doc__, REPEATS)
    parser.add_argument('--old', type=Path, required=True, metavar='FOLDER',
                        help='checkout of the older version, with its .venv')
    options = parser.parse_args()
    old = options.old.resolve()
    if not Path(python(old)).exists():
        raise SystemExit(f'{old}: no .venv/bin/python; run make setup-all there')
    scale, repeats = (0.2, 1) if options.quick else (1.0, options.repeats)
    measure(old, 0.2), measure(HERE, 0.2)  # compiles, and fills the caches of the disk
    rounds = interleave({'old': lambda: measure(old, scale), 'new': lambda: measure(HERE, scale)},
                        repeats)
    names = filter(rounds['old'][0].__contains__, rounds['new'][0])
    rows = [composed(rounds), *(beside(name, rounds) for name in names)]
    publish('versions', 'This version beside version 0.1', rows, {'seconds': rounds},
            keep=not options.quick)


def beside(name: str, rounds: dict[str, list[dict[str, float]]]) -> Row:
    """Return a figure of both versions; of a step also what PyBullet and the fast copy took."""
    pair = {side: [each[name] for each in rounds[side]] for side in rounds}
    detail = f'{shown(median(pair["new"]))} against {shown(median(pair["old"]))}'
    for side, part, words in (('new', 'PyBullet alone in', "PyBullet's own calls"),
                              ('old', 'fast copy of', 'its fast copy')):
        if f'{part} {name}' in rounds[side][0]:
            seconds = median(each[f'{part} {name}'] for each in rounds[side])
            detail += f'; {words}: {shown(seconds)}'
    return Row(name, 'version 0.1', ratio(pair, 'new', 'old'), BARS.get(name, SCATTER), False,
               detail)


def composed(rounds: dict[str, list[dict[str, float]]]) -> Row:
    """Return how many times as fast both nodes in one process are as two of the older version."""
    ways = [name for name in rounds['old'][0]
            if name.startswith('period of two nodes, ') and name.endswith('core')]
    fastest = min(ways, key=lambda name: median(each[name] for each in rounds['old']))
    pair = {'old': [each[fastest] for each in rounds['old']],
            'new': [each['period of both nodes in one process'] for each in rounds['new']]}
    return Row('periods a second of both nodes in one process',
               f'{fastest.removeprefix("period of ")}, version 0.1, the faster way',
               ratio(pair, 'old', 'new'), 1.8, True,
               f'{shown(median(pair["new"]))} against {shown(median(pair["old"]))} a period')


def shown(seconds: float) -> str:
    """Return a time in microseconds or seconds."""
    return f'{seconds:.2f} s' if seconds > 0.1 else f'{seconds * 1e6:.2f} us'


if __name__ == '__main__':
    sys.exit(main())
