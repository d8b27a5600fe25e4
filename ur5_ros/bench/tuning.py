"""The same search of gains for every law: as many runs, the same motions, the same judge."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.bench.entries import LAWS, BenchFile, Candidate, Tuned, entry_of
from ur5_ros.bench.jobs import run_jobs
from ur5_ros.bench.runs import Job
from ur5_ros.config.records import Record, as_data

#: Candidates of a law: frequency [rad/s], damping and the law's own number, log-uniform.
CANDIDATES = 16
_RANGES = ((5.0, 60.0), (0.5, 2.0), (0.1, 10.0))
#: What a candidate is judged by, with a seed that the bench does not use.
CONDITIONS, SEED = ('payload', 'friction', 'delay', 'noise'), 1_000_000
#: Error of a run that did not survive [rad], and roughness that costs as much as a twofold error.
LOST, ROUGH = 1.0, 2000.0

METHOD = (f'{CANDIDATES} candidates a law, the same Latin hypercube for all of them, log-uniform: '
       f'frequency {_RANGES[0][0]:g} to {_RANGES[0][1]:g} rad/s, damping {_RANGES[1][0]:g} to '
       f'{_RANGES[1][1]:g}, the own number {_RANGES[2][0]:g} to {_RANGES[2][1]:g}; each run with '
       f'{", ".join(CONDITIONS)} under seed {SEED}, which the bench does not use; the least '
       f'geometric mean of error times (1 + roughness / {ROUGH:g} N m/s) is taken')


def candidates() -> list[Tuned]:
    """Return the candidates, the same for every law: a Latin hypercube."""
    random = np.random.default_rng(SEED)
    columns = []
    for low, high in _RANGES:
        share = (random.permutation(CANDIDATES) + 0.5) / CANDIDATES
        columns.append(low * (high / low)**share)
    return [Tuned(*(float(f'{value:.4g}') for value in row)) for row in zip(*columns, strict=True)]


def cost(rows: list[dict[str, Any]]) -> float:
    """Return the geometric mean of error times (1 + roughness / ROUGH) over the conditions."""
    each = [np.log(row['rms_error']) + np.log1p(row['roughness'] / ROUGH) if row['survived']
            else np.log(10.0 * LOST) for row in rows]
    return float(np.exp(np.mean(each)))


def tune(workers: int | None = None, progress: Callable[[float], None] = lambda done: None,
         ) -> BenchFile:
    """Return the best candidate of every law, and all that were tried."""
    tried = [(law, gains) for law in LAWS for gains in candidates()]
    jobs = [Job(entry_of(law, gains), name, SEED) for law, gains in tried for name in CONDITIONS]
    rows = run_jobs(jobs, workers=workers, progress=progress)
    table, size = [], len(CONDITIONS)
    for number, (law, gains) in enumerate(tried):
        own = rows[size * number:size * (number + 1)]
        survived = [row for row in own if row['survived']]
        table.append(Candidate(
            law, *gains_values(gains), cost(own), len(survived),
            _mean(survived, 'rms_error'), _mean(survived, 'roughness')))
    best = {law: min((row for row in table if row.law == law), key=lambda row: row.cost)
            for law in LAWS}
    return BenchFile(METHOD, {law: Tuned(row.frequency, row.damping, row.own)
                           for law, row in best.items()}, table)


def write_bench(found: BenchFile, path: Path) -> None:
    """Write tuned gains as YAML, a line each."""
    def line(record: Record) -> str:
        pairs = (f'{key}: {_short(value)}' for key, value in as_data(record).items())
        return '{' + ', '.join(pairs) + '}'
    lines = ['# Gains of the laws on the bench, written by ur5 bench --tune.',
             'how: >-', f'  {found.how}', 'laws:',
             *(f'  {law}: {line(gains)}' for law, gains in found.laws.items()), 'tried:',
             *(f'  - {line(row)}' for row in found.tried)]
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')


def pareto_front(rows: list[Candidate]) -> list[Candidate]:
    """Return the candidates that none beats in error and in roughness, by error."""
    front, least = [], math.inf
    whole = [row for row in rows if row.survived == len(CONDITIONS)]
    for row in sorted(whole, key=lambda row: (row.rms_error, row.roughness)):
        if row.roughness is not None and row.roughness < least:
            least = row.roughness
            front.append(row)
    return front


def gains_values(gains: Tuned) -> tuple[float, float, float]:
    """Return frequency, damping and the law's own number."""
    return gains.frequency, gains.damping, gains.own


def _mean(rows: list[dict[str, Any]], key: str) -> float | None:
    return float(np.mean([row[key] for row in rows])) if rows else None


def _short(value: Any) -> str:
    if not isinstance(value, float):
        return 'null' if value is None else str(value)
    text = f'{value:.5g}'
    return text.replace('e', '.0e') if 'e' in text and '.' not in text else text  # YAML's numbers
