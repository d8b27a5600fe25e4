"""
Ten thousand runs on two workers that are killed, as is the scheduler, as is the sweep itself.

    python benchmarks/sweep_proof.py [--runs 10000] [--again 1000]

``ur5 sweep SPEC --scheduler ADDRESS`` works with a scheduler and two workers that are processes
of their own.  At a sixth of the runs a worker is killed (SIGKILL), at a third the scheduler, at a
half the sweep itself, at two thirds the other worker; each is started again, the sweep by the same
command.  Afterwards every run has to be there once, the first of them with the bits of a sweep
that nobody disturbed, and no process may have grown.  Code that changes while it runs is refused:
rows of two versions say nothing about the sweep.
"""

import argparse
import hashlib
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import child
import polars
import psutil
from side_by_side import Row, publish

SPEC = """
name: proof
question: "Does a sweep lose or double a run whatever is killed?"
experiment: kebria_fig11
duration: 2.0
judge: {judge}
seed: 1
samples: {runs}
success: {{max_error: 0.2}}
vary:
  initial_error: {{uniform: [-0.1, 0.1], size: 6}}
  sim.payload.mass: {{uniform: [0.0, 0.5]}}
"""
#: What a worker does before it takes work: with the first runs, some of which fail, it loads all
#: that rows take.  What it holds then is what it must not grow from.
PRELOAD = """
from itertools import islice
from ur5_ros.sweep.engine import run_batch
from ur5_ros.sweep.provenance import sources
from ur5_ros.sweep.spec import expand, load_sweep

def dask_setup(worker):
    spec = load_sweep('proof.yaml')
    run_batch(spec, None, sources(), list(islice(expand(spec), 10)))
"""
#: Share of the life of a process that is its warm-up.
WARM_UP = 0.25
MEBI = 2**20


class Cluster:
    """
    A scheduler and two workers as processes of this machine.

    Parameters
    ----------
    folder : pathlib.Path
        Where they work and log.

    """

    def __init__(self, folder: Path):
        self._folder, self._started = folder, 0
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self._port = probe.getsockname()[1]
        self.address = f'tcp://127.0.0.1:{self._port}'
        self.alive: dict[str, subprocess.Popen] = {}

    def keep(self) -> None:
        """Start whoever is not there."""
        for name in ('scheduler', 'worker 1', 'worker 2'):
            process = self.alive.get(name)
            if process is not None and process.poll() is None:
                continue
            if name == 'scheduler':
                self.alive[name] = self._start('dask_scheduler', '--host', '127.0.0.1', '--port',
                                               str(self._port), '--no-dashboard')
            else:
                self.alive[name] = self._start(
                    'dask_worker', self.address, '--nthreads', '1', '--no-nanny',
                    '--no-dashboard', '--death-timeout', '120', '--preload', 'warm.py')

    def kill(self, name: str) -> None:
        """Kill one of them."""
        self.alive[name].kill()
        self.alive[name].wait()

    def close(self) -> None:
        """Kill all."""
        for name in self.alive:
            self.kill(name)

    def _start(self, module: str, *arguments: str) -> subprocess.Popen:
        self._started += 1
        with open(self._folder / f'{module}_{self._started}.log', 'wb') as log:
            return child.start(
                [sys.executable, '-m', f'distributed.cli.{module}', *arguments], stdout=log,
                stderr=log, cwd=self._folder, start_new_session=True,
                env={**os.environ, 'OPENBLAS_NUM_THREADS': '1',  # as in the workers of ur5 sweep
                     'DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED': 'False'})


class Sweep:
    """
    The command, started again by the same words.

    Parameters
    ----------
    folder : pathlib.Path
        Where it is called.
    address : str
        Of the scheduler.

    """

    def __init__(self, folder: Path, address: str):
        self._folder, self._address = folder, address
        self.process = self.start()

    def start(self) -> subprocess.Popen:
        """Call the command."""
        with open(self._folder / 'sweep.log', 'ab') as log:
            self.process = child.start(
                [sys.executable, '-c', 'from ur5_ros.cli import main; main()', 'sweep',
                 'proof.yaml', '--scheduler', self._address], cwd=self._folder, stdout=log,
                stderr=log, stdin=subprocess.DEVNULL, start_new_session=True)
        return self.process

    def rows(self) -> int:
        """Return how many rows are on disk: each part says it in its name."""
        parts = (self._folder / 'sweeps' / 'proof' / 'parts').glob('*.parquet')
        return sum(int(part.stem.partition('-')[2]) for part in parts)


def disturbed(folder: Path, runs: int, judge: str) -> dict:
    """Run the sweep while its parts are killed; return what happened."""
    (folder / 'proof.yaml').write_text(SPEC.format(runs=runs, judge=judge))
    (folder / 'warm.py').write_text(PRELOAD)
    cluster = Cluster(folder)
    victims = [(runs // 6, 'worker 1'), (runs // 3, 'scheduler'), (runs // 2, 'sweep'),
               (2 * runs // 3, 'worker 2')]
    memory: dict[str, list[tuple[int, float]]] = defaultdict(list)
    killed, begin, sweep = [], time.monotonic(), None
    try:
        cluster.keep()
        sweep = Sweep(folder, cluster.address)
        while sweep.process.poll() is None:
            rows = sweep.rows()
            for name, process in [*cluster.alive.items(), ('sweep', sweep.process)]:
                size = resident(process.pid)
                if size:
                    memory[f'{name}, process {process.pid}'].append((rows, size))
            if victims and rows >= victims[0][0]:
                _, name = victims.pop(0)
                killed.append((name, rows))
                print(f'{time.monotonic() - begin:6.0f} s  {rows:6d} rows  {name} killed',
                      flush=True)
                if name == 'sweep':
                    sweep.process.kill()
                    sweep.process.wait()
                    sweep.start()
                else:
                    cluster.kill(name)
            cluster.keep()
            time.sleep(1.0)
    finally:
        cluster.close()
        if sweep is not None and sweep.process.poll() is None:
            sweep.process.kill()
        print((folder / 'sweep.log').read_text(errors='replace')[-2000:])
    return {'killed': killed, 'seconds': time.monotonic() - begin, 'memory': dict(memory),
            'code': sweep.process.returncode}


def resident(pid: int) -> float:
    """Return the memory of a process [MiB], 0 if it has gone."""
    try:
        return psutil.Process(pid).memory_info().rss / MEBI
    except psutil.NoSuchProcess:
        return 0.0


def undisturbed(folder: Path, runs: int, judge: str) -> polars.DataFrame:
    """Return the table of the same sweep by the cores of this machine, nobody killed."""
    (folder / 'quiet.yaml').write_text(SPEC.format(runs=runs, judge=judge))
    child.call([sys.executable, '-c', 'from ur5_ros.cli import main; main()', 'sweep',
                'quiet.yaml', '--out', 'quiet'], cwd=folder, stdin=subprocess.DEVNULL)
    return polars.read_parquet(folder / 'quiet' / 'table.parquet')


def growth(memory: dict[str, list[tuple[int, float]]]) -> dict[str, dict[str, float]]:
    """
    Return the memory after warm-up and at the end of who lived long enough [MiB].

    A process that has loaded what it needs is one in whose life rows were written.
    """
    found = {}
    for name, samples in memory.items():
        samples = [each for each in samples if each[0] > samples[0][0]]
        sizes = [size for _, size in samples]
        if len(sizes) < 20:
            continue
        warm = sizes[int(WARM_UP * len(sizes)):]
        part = max(1, len(warm) // 5)
        found[name] = {'first_row': samples[0][0], 'last_row': samples[-1][0],
                       'warm': sum(warm[:part]) / part, 'end': sum(warm[-part:]) / part,
                       'peak': max(sizes)}
    return found


def digest(table: polars.DataFrame) -> str:
    """Return a SHA-256 over all rows in order, as text that shows every bit of a number."""
    found = hashlib.sha256(repr(table.columns).encode())
    for row in table.iter_rows():
        found.update(repr(row).encode())
    return found.hexdigest()


def main() -> None:
    """Run, compare, keep the figures; exit 1 if one is missed."""
    parser = argparse.ArgumentParser(description=__doc__.strip().partition('\n')[0])
    parser.add_argument('--runs', type=int, default=10_000)
    parser.add_argument('--again', type=int, default=1_000, help='runs to repeat undisturbed')
    parser.add_argument('--keep', action='store_true',
                        help='keep the figures of fewer than 10,000 runs too')
    parser.add_argument('--judge', choices=('checks', 'metrics'), default='checks')
    options = parser.parse_args()
    # what this computer has not compiled yet, no worker shall compile
    child.call([sys.executable, '-c', 'from ur5_ros.cli import main; main()', 'warm-up'],
               stdin=subprocess.DEVNULL)
    with tempfile.TemporaryDirectory(prefix='ur5-sweep-proof-') as name:
        folder = Path(name)
        reported = disturbed(folder, options.runs, options.judge)
        sweep = folder / 'sweeps' / 'proof'
        table = polars.read_parquet(sweep / 'table.parquet')
        written = [index for part in sorted((sweep / 'parts').glob('*.parquet'))
                   for index in polars.read_parquet(part, columns=['index'])['index']]
        quiet = undisturbed(folder, min(options.again, options.runs), options.judge)
        codes = {json.loads((each / 'software.json').read_text())['sources']
                 for each in (sweep, folder / 'quiet')}
    if len(codes) > 1:
        print(f'The code changed while this ran: sources {" and ".join(sorted(codes))}. '
              'Nothing is kept; run it again.')
        sys.exit(2)
    grown = growth(reported['memory'])
    digests = digest(table.head(quiet.height)), digest(quiet)
    statuses = dict(table['status'].value_counts().sort('status').iter_rows())
    for who, found in grown.items():
        print(f'{who:28s} rows {found["first_row"]:6.0f} to {found["last_row"]:6.0f}: '
              f'{found["warm"]:6.1f} MiB when warm, {found["end"]:6.1f} at its end')
    print(f'{options.runs} runs in {reported["seconds"]:.0f} s; {statuses}; SHA-256 {digests[0]}')
    worst = max((found['end'] / found['warm'] for found in grown.values()), default=1.0)
    names = [name for name, _ in reported['killed']]
    rows = [
        Row('rows of the table', 'runs asked for', table.height / options.runs, 1.0, True,
            f'{table.height} rows; killed on the way: {", ".join(names)}'),
        Row('different runs among them', 'runs asked for',
            table['index'].n_unique() / options.runs, 1.0, True),
        Row('rows written', 'runs asked for', len(written) / options.runs, 1.0, False,
            f'{len(written) - len(set(written))} twice'),
        Row('rows that could not be done', 'runs asked for',
            statuses.get('failed', 0) / options.runs, 0.0, False),
        Row('rows with the bits of an undisturbed sweep', 'rows compared',
            float(digests[0] == digests[1]), 1.0, True, f'{quiet.height} rows'),
        Row('memory at the end of a process, the worst of them', 'when it was warm', worst, 1.1,
            False, '; '.join(f'{who.partition(",")[0]} {found["warm"]:.0f} to '
                             f'{found["end"]:.0f} MiB' for who, found in grown.items())),
    ]
    publish('sweep_proof', f'{options.runs} runs of 2 s at 1 kHz, workers, scheduler and sweep '
            'killed', rows, {'runs': options.runs, 'compared': quiet.height,
                             'killed': reported['killed'], 'seconds': reported['seconds'],
                             'statuses': statuses, 'sha256': digests[0], 'memory': grown},
            keep=options.keep or options.runs >= 10_000)
    sys.exit(0 if reported['code'] == 0 and all(row.met for row in rows) else 1)


if __name__ == '__main__':
    main()
