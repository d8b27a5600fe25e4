"""A sweep in ten lines of YAML, and the runs that it asks for."""

import itertools
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import msgspec
import numpy as np

from ur5_ros.config import config_folder, parse_yaml, read_yaml
from ur5_ros.config.records import Meta, Record, validate
from ur5_ros.errors import InputError

#: Most runs that one sweep may ask for.
MOST_RUNS = 1_000_000

Pair = Annotated[list[float], Meta(min_length=2, max_length=2)]
Fixed = bool | int | float | str | list[float]


class Axis(Record, frozen=True, kw_only=True):
    """Values of one key: a range, or random ones; a plain list of values needs no axis."""

    first: float | None = msgspec.field(name='from', default=None)
    last: float | None = msgspec.field(name='to', default=None)
    count: Annotated[int, Meta(ge=1, le=MOST_RUNS)] | None = None
    scale: Literal['linear', 'log'] = 'linear'
    uniform: Pair | None = None
    log_uniform: Pair | None = None
    normal: Pair | None = None
    size: Annotated[int, Meta(ge=1, le=36)] | None = None


class SweepSpec(Record, frozen=True, kw_only=True):
    """What ``ur5 sweep`` reads; docs/sweeps.md describes every key."""

    name: Annotated[str, Meta(pattern=r'^[A-Za-z0-9_.-]+$')]
    question: str = ''
    experiment: str = 'kebria_fig11'
    duration: Annotated[float, Meta(gt=0.0, le=86400.0)] | None = None
    engine: Literal['loop', 'nodes'] = 'loop'
    judge: Literal['checks', 'metrics'] = 'checks'
    keep: Literal['none', 'failures', 'all'] = 'none'
    seed: Annotated[int, Meta(ge=0, le=2**31 - 1)] = 0
    samples: Annotated[int, Meta(ge=1, le=MOST_RUNS)] = 1
    success: dict[str, float] = {}
    fixed: dict[str, Fixed] = {}
    cases: list[dict[str, Fixed]] = []
    vary: dict[str, list[Fixed] | Axis] = {}


def altered(spec: SweepSpec, **values: Any) -> SweepSpec:
    """Return a specification with other values."""
    return msgspec.structs.replace(spec, **values)


class RunSpec(NamedTuple):
    """One run of a sweep: small enough to travel, complete enough to be repeated alone."""

    number: int
    values: dict[str, Any]
    """Key to value of everything that differs between the runs."""


def load_sweep(name: str) -> SweepSpec:
    """
    Return a sweep specification.

    ``name``: A name of ``config/sweeps``, or the path of a YAML file.
    """
    path = Path(name)
    if not path.is_file() and '/' not in name and not name.endswith(('.yaml', '.yml')):
        path = config_folder() / 'sweeps' / f'{name}.yaml'
    if not path.is_file():
        known = ', '.join(sorted(p.stem for p in (config_folder() / 'sweeps').glob('*.yaml')))
        raise InputError(f'no sweep {name}; give the path of a YAML file, or one of: {known}')
    return _spec(read_yaml(path), str(path))


def parse_sweep(text: str, source: str) -> SweepSpec:
    """Return a sweep specification from its text; refuses as :func:`load_sweep`."""
    return _spec(parse_yaml(text, source), source)


def _spec(data: Any, source: str) -> SweepSpec:
    spec = validate(SweepSpec, data, source)
    _check(spec, source)
    return spec


def expand(spec: SweepSpec) -> Iterator[RunSpec]:
    """
    Yield the runs of a sweep: every combination of cases and values, ``samples`` times.

    Random values of run i come from the generator seeded with (seed, i), so that they depend on
    nothing else.

    """
    grid = {key: _values(axis) for key, axis in spec.vary.items() if not is_random(axis)}
    drawn = {key: axis for key, axis in spec.vary.items()
             if isinstance(axis, Axis) and is_random(axis)}
    cases: list[Mapping[str, Any]] = list(spec.cases) or [{}]
    combinations = itertools.product(cases, *grid.values(), range(spec.samples))
    for index, (case, *point) in enumerate(combinations):
        values = {**case, **dict(zip(grid, point, strict=False))}
        if drawn:
            random = np.random.default_rng([spec.seed, index])
            values.update({key: _draw(axis, random) for key, axis in drawn.items()})
        yield RunSpec(index, values)


def number_of_runs(spec: SweepSpec) -> int:
    """Return how many runs :func:`expand` yields."""
    sizes = [len(_values(axis)) for axis in spec.vary.values() if not is_random(axis)]
    return math.prod(sizes) * spec.samples * max(1, len(spec.cases))


def is_random(axis: list | Axis) -> bool:
    """Return whether the values of a key are drawn, run by run."""
    return isinstance(axis, Axis) and axis.count is None


def has_drawn_keys(spec: SweepSpec) -> bool:
    """Return whether some key is drawn at random, so that rates have an interval."""
    return any(is_random(axis) for axis in spec.vary.values())


def _values(axis: list | Axis) -> list:
    if isinstance(axis, list):
        return axis
    first, last, count = axis.first or 0.0, axis.last or 0.0, axis.count or 0  # all are given
    spread = np.geomspace if axis.scale == 'log' else np.linspace
    return spread(first, last, count).tolist()


def _draw(axis: Axis, random: np.random.Generator) -> float | list[float]:
    if axis.normal is not None:
        middle, deviation = axis.normal
        values = random.normal(middle, deviation, axis.size or 1)
    elif axis.uniform is not None:
        low, high = axis.uniform
        values = random.uniform(low, high, axis.size or 1)
    else:
        low, high = map(math.log, axis.log_uniform or ())
        values = np.exp(random.uniform(low, high, axis.size or 1))
    return values.tolist() if axis.size else float(values[0])


def _check(spec: SweepSpec, source: str) -> None:
    if spec.judge == 'metrics' and not spec.success:
        raise InputError(f'{source}: judge is metrics and success is empty; say what success is, '
                         'such as max_error: 0.1')
    for key, axis in spec.vary.items():
        if isinstance(axis, list):
            if not axis:
                raise InputError(f'{source}: vary.{key} is empty; give at least one value')
        else:
            _check_axis(f'{source}: vary.{key}', axis)
        if key in spec.fixed:
            raise InputError(f'{source}: {key} stands in fixed and in vary; remove one')
    for number, case in enumerate(spec.cases):
        both = (case.keys() & spec.vary.keys()) | (case.keys() & spec.fixed.keys())
        if both:
            raise InputError(f'{source}: {min(both)} of cases.{number} stands in fixed or vary '
                             'too; remove one')
        if case.keys() != spec.cases[0].keys():
            raise InputError(f'{source}: cases.{number} has the keys {", ".join(sorted(case))}; '
                             f'give every case {", ".join(sorted(spec.cases[0]))}')
    runs = number_of_runs(spec)
    if runs > MOST_RUNS:
        raise InputError(f'{source}: {runs} runs; at most {MOST_RUNS}')


def _check_axis(where: str, axis: Axis) -> None:
    random = [name for name in ('uniform', 'log_uniform', 'normal') if getattr(axis, name)]
    ranged = axis.first is not None or axis.last is not None or axis.count is not None
    if len(random) + ranged != 1:
        raise InputError(f'{where}: give a list, or from, to and count, or one of uniform, '
                         'log_uniform and normal')
    if ranged:
        if axis.first is None or axis.last is None or axis.count is None:
            raise InputError(f'{where}: from, to and count go together; give all three')
        low, high, log = axis.first, axis.last, axis.scale == 'log'
        if axis.size is not None:
            raise InputError(f'{where}: size goes with random values; remove it')
    else:
        low, high = getattr(axis, random[0])
        log = random[0] == 'log_uniform'
        if random[0] == 'normal':
            if high < 0.0:
                raise InputError(f'{where}: standard deviation {high}; give zero or more')
            return
    if low > high or (low == high and not (ranged and axis.count == 1)):
        raise InputError(f'{where}: the range {low:g} to {high:g} is empty; '
                         'give the lower end first')
    if log and low <= 0.0:
        raise InputError(f'{where}: {low:g} on a logarithmic scale; give more than zero')
