"""Summary of a sweep's table: success rates with confidence, maps of two keys, worst runs."""

import itertools
import json
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import polars

from ur5_ros.sweep.spec import SweepSpec, is_random
from ur5_ros.sweep.table import input_keys

#: Standard normal quantile of a two-sided 95 % interval.
_Z = 1.959963984540054

#: Most values of a key that make one line, or one row of a map, each.
MOST_VALUES = 60


class Rate(NamedTuple):
    """How many of some runs succeeded."""

    runs: int
    successes: int
    low: float
    """Lower end of the 95 % interval."""
    high: float
    """Upper end of it."""

    @property
    def rate(self) -> float:
        """Share of successes."""
        return self.successes / self.runs


class HeatMap(NamedTuple):
    """A number over two keys."""

    x: str
    y: str
    what: str
    x_values: list[Any]
    y_values: list[Any]
    z: list[list[float | None]]
    """Rows by y; None where no run has a number."""


def rate_of(runs: int, successes: int) -> Rate:
    """
    Return a success rate with Wilson's 95 % interval.

    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209; unlike the normal one it stays inside 0 to 1.

    """
    share = successes / runs
    middle = share + _Z**2 / (2 * runs)
    half = _Z * math.sqrt(share * (1 - share) / runs + _Z**2 / (4 * runs**2))
    scale = 1 + _Z**2 / runs
    return Rate(runs, successes, max(0.0, (middle - half) / scale),
                min(1.0, (middle + half) / scale))


def overall(table: polars.DataFrame) -> Rate:
    """Return the success rate of all runs."""
    return rate_of(table.height, int(table['success'].sum()))


def rates_by(table: polars.DataFrame, key: str) -> dict[Any, Rate]:
    """Return the success rate for each value of a key, in the order of the values."""
    groups = table.group_by(key).agg(polars.len().alias('runs'), polars.col('success').sum())
    found = {row[key]: rate_of(row['runs'], int(row['success']))
             for row in groups.iter_rows(named=True)}
    return {value: found[value] for value in sorted(found, key=_order)}


def _order(value: Any) -> tuple[bool, Any]:
    """Return what sorts values of a key; lists, which the table holds as text, by number."""
    if isinstance(value, str) and value.startswith('['):
        value = json.loads(value)
    return value is None, 0 if value is None else value


def discrete_keys(table: polars.DataFrame, spec: SweepSpec) -> list[str]:
    """Return the keys with few enough values to be shown one by one."""
    drawn = {key for key, axis in spec.vary.items() if is_random(axis)}
    return [key for key in input_keys(spec) if key not in drawn
            and key in table.columns and table[key].n_unique() <= MOST_VALUES]


def heat_maps(table: polars.DataFrame, spec: SweepSpec, numbers: list[str]) -> list[HeatMap]:
    """Return maps of the success rate and of medians over every pair of keys."""
    maps = []
    keys = [key for key in discrete_keys(table, spec) if table[key].n_unique() > 1]
    for x, y in itertools.combinations(keys, 2):
        cells = table.group_by(x, y).agg(
            polars.col('success').mean().alias('success rate'),
            *(polars.col(number).median() for number in numbers)).to_dicts()
        found = {(cell[x], cell[y]): cell for cell in cells}
        x_values, y_values = (sorted(table[key].unique().to_list(), key=_order)
                              for key in (x, y))
        for what in ('success rate', *numbers):
            z = [[_finite(found.get((a, b), {}).get(what)) for a in x_values] for b in y_values]
            maps.append(HeatMap(x, y, what, x_values, y_values, z))
    return maps


def criterion_share(table: polars.DataFrame, success: Mapping[str, float]) -> polars.Series | None:
    """Return each run's largest value as a share of its limit; None without limits to compare."""
    names = [name for name, limit in success.items() if name in table.columns and limit > 0.0]
    if not names:
        return None
    shares = [(polars.col(name).abs() / success[name]).fill_null(math.inf).fill_nan(math.inf)
              for name in names]
    return table.select(polars.max_horizontal(*shares).alias('share'))['share']


def worst_runs(
    table: polars.DataFrame, count: int = 10, success: Mapping[str, float] | None = None,
) -> list[dict[str, Any]]:
    """Return the worst rows: failures first, then by the criterion of success, then by error."""
    share = criterion_share(table, success or {})
    if share is None and 'max_error' in table.columns:
        share = table['max_error'].fill_null(math.inf).fill_nan(math.inf)
    if share is None:
        return table.sort('success', 'index').head(count).to_dicts()
    ranked = table.with_columns(share.alias('_share'))
    return (ranked.sort('success', '_share', 'index', descending=[False, True, False])
            .drop('_share').head(count).to_dicts())


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
