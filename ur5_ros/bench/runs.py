"""Runs of the bench: a law, a perturbation, a seed; and what a law survives."""

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.bench.entries import Entry
from ur5_ros.bench.perturbations import ACCURATE, ARM, SURVIVES, Conditions, conditions_of
from ur5_ros.bench.scores import SCORES, scores_of
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.loop.closed_loop import full_loop
from ur5_ros.loop.run_config import run_config

#: Simulated time of a run [s].
DURATION = 3.0
#: Largest payload [kg] and delay [control periods of 1 ms] that are tried.
LARGEST_TRIED = {'payload': 32.0, 'delay': 128.0}
#: Bisections of either: the payload is known to 1/8 kg, the delay to 1 ms.
BISECTIONS = {'payload': 8, 'delay': 7}


class Job(NamedTuple):
    """What a worker does: one run, or the bisections of ``payload`` or ``delay``."""

    entry: Entry
    perturbation: str
    seed: int
    survival: bool = False


def jobs_of(entries: Iterable[Entry], perturbations: Iterable[str], seeds: int,
            survival: bool = True) -> list[Job]:
    """Return all jobs; those that take longest first."""
    entries = list(entries)
    long = [Job(entry, what, 0, True) for entry in entries for what in LARGEST_TRIED]
    runs = [Job(entry, name, seed) for name in perturbations for seed in range(seeds)
            for entry in entries]
    return (long if survival else []) + runs


def row_of(job: Job) -> dict[str, Any]:
    """Return what a job finds."""
    if job.survival:
        return borders_of(job.entry, job.perturbation) | {'survived': True, 'why': ''}
    return run_of(job.entry, *conditions_of(job.perturbation, job.seed))


def run_of(entry: Entry, conditions: Conditions, error: np.ndarray) -> dict[str, Any]:
    """Return the scores of one run, and whether the law survived it."""
    try:
        arm = load_arm(ARM)
        at_wall = conditions.experiment != 'multi_sine'
        config = run_config(
            conditions.experiment, ARM, control_rate=conditions.control_rate,
            duration=DURATION,
            initial_error=None if at_wall else error.tolist(),
            sim=conditions.sim, control=entry.control)
        scores = scores_of(full_loop(config, conditions.sim_arm(arm), conditions.control_arm(arm)))
    except (InputError, ArithmeticError, np.linalg.LinAlgError) as refusal:
        return dict.fromkeys(SCORES) | {'survived': False, 'why': str(refusal)}
    lost = not scores['max_error'] <= conditions.survives
    why = f'a joint is {scores["max_error"]:.3g} rad from its reference' if lost else ''
    return scores | {'survived': not lost, 'why': why}


def borders_of(entry: Entry, what: str) -> dict[str, float]:
    """
    Return the largest payload [kg] or delay [ms] that a law survives, by bisection.

    Returned: ``largest``, with which every joint stays within SURVIVES, and ``accurate``, within
    ACCURATE; infinite where even the largest that is tried is survived.
    """
    @cache
    def worst(value: float) -> float:
        error = run_of(entry, border_conditions(what, value), np.zeros(6))['max_error']
        return float('inf') if error is None else error

    def border(within: float) -> float:
        low, high = 0.0, LARGEST_TRIED[what]
        if worst(high) <= within:
            return float('inf')
        for _ in range(BISECTIONS[what]):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if worst(middle) <= within else (low, middle)
        return low
    return {'largest': border(SURVIVES), 'accurate': border(ACCURATE)}


def border_conditions(what: str, value: float) -> Conditions:
    """Return the conditions of a payload [kg] or delay [ms]."""
    if what == 'payload':
        return Conditions(sim={'payload.mass': value})
    return Conditions(sim={'delay.command_periods': int(value)})


@contextmanager
def overflow_ignored() -> Iterator[None]:
    """Let runs that diverge overflow without a warning: their rows record it."""
    with warnings.catch_warnings(), np.errstate(all='ignore'):
        warnings.simplefilter('ignore')
        yield


def lost_row(job: Job, why: str) -> dict[str, Any]:
    """Return the row of a job that came to no result."""
    borders = {'largest': None, 'accurate': None} if job.survival else dict.fromkeys(SCORES)
    return borders | {'survived': False, 'why': why}
