"""Two runs side by side: the same? where do they part, and how fast does the difference grow?"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import NodeRecord, Run
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES

#: Within this two runs are the same on machines of different fingerprints.
TOLERANCE = 1e-9

_UNITS = {'position': 'rad', 'velocity': 'rad/s', 'effort': 'N m', 'command': 'N m'}


class Difference(NamedTuple):
    """How far one quantity of two runs differs."""

    quantity: str
    unit: str
    compared: int
    """Rows that both runs have."""
    different: int
    """Rows in which a bit differs."""
    first_s: float | None
    """Time of the first one since the beginning of the first run [s]."""
    first_joint: str
    largest: float
    """Largest difference."""
    growth: dict[str, float]
    """Largest difference within 1, 10, 100, ... periods of the first one, and at the end."""


class Comparison(NamedTuple):
    """Two runs side by side."""

    run_a: str
    run_b: str
    only_a: int
    """States that only the first run has."""
    only_b: int
    differences: tuple[Difference, ...]
    parameters: dict[str, list[Any]]
    """Parameters that differ: name to both values."""
    same_machine: bool | None
    """Whether both name the same fingerprint; None where one names none."""

    @property
    def identical(self) -> bool:
        """Whether both have the same states and commands to the last bit."""
        return not (self.only_a or self.only_b or any(d.different for d in self.differences))

    @property
    def same(self) -> bool:
        """Whether they are one run repeated: identical, or within 1e-9 on another machine."""
        close = not self.only_a and not self.only_b and all(
            d.largest <= TOLERANCE for d in self.differences)
        return self.identical or (self.same_machine is False and close)

    def to_plain(self) -> dict[str, Any]:
        """Return the comparison as plain values."""
        return {'format': 'ur5_ros comparison', 'version': 1, 'same': self.same,
                'identical': self.identical, **self._asdict(),
                'differences': [difference._asdict() for difference in self.differences]}


def compare(a: Run, b: Run) -> Comparison:
    """Compare two runs, state by state, matched by stamp."""
    stamp, rows_a, rows_b = np.intersect1d(a.stamp, b.stamp, assume_unique=True,
                                           return_indices=True)
    if not len(stamp):
        raise InputError(f'{a.name} and {b.name} have no stamp in common: {_span(a)} and '
                         f'{_span(b)}')
    pairs = {'position': (a.states.q, b.states.q), 'velocity': (a.states.qd, b.states.qd),
             'effort': (a.states.effort, b.states.effort)}
    if a.command is not None and b.command is not None:
        pairs['command'] = (a.command, b.command)
    return Comparison(
        a.name, b.name, len(a.stamp) - len(stamp), len(b.stamp) - len(stamp),
        tuple(_difference(name, stamp, left[rows_a], right[rows_b])
              for name, (left, right) in pairs.items()),
        {**_parameters('simulator', a.sim, b.sim), **_parameters('controller', a.control,
                                                                 b.control)},
        _same_machine(a, b))


def _difference(name: str, stamp: np.ndarray, a: np.ndarray, b: np.ndarray) -> Difference:
    a, b = np.ascontiguousarray(a), np.ascontiguousarray(b)
    both_unknown = np.isnan(a) & np.isnan(b)
    bits = (a.view(np.uint64) != b.view(np.uint64)) & ~both_unknown
    rows = bits.any(axis=1)
    size = np.abs(a - b)
    size[both_unknown] = 0.0
    size[np.isnan(size)] = np.inf
    per_row = size.max(axis=1, initial=0.0)
    if not rows.any():
        return Difference(name, _UNITS[name], len(stamp), 0, None, '', 0.0, {})
    first = int(np.argmax(rows))
    growth, periods = {}, 1
    while first + periods < len(stamp):
        span = f'within {periods} period{"s" if periods > 1 else ""}'
        growth[span] = float(per_row[first:first + periods].max())
        periods *= 10
    growth['at the end'] = float(per_row[-1])
    return Difference(
        name, _UNITS[name], len(stamp), int(rows.sum()), float(stamp[first] - stamp[0]) * 1e-9,
        JOINT_NAMES[int(np.argmax(size[first]))], float(per_row.max()), growth)


def _parameters(name: str, a: NodeRecord | None, b: NodeRecord | None) -> dict[str, list[Any]]:
    left: Mapping[str, Any] = a.parameters if a else {}
    right: Mapping[str, Any] = b.parameters if b else {}
    return {f'{name} {key}': [left.get(key), right.get(key)]
            for key in sorted(left.keys() | right.keys())
            if key != 'bag' and left.get(key) != right.get(key)}


def _same_machine(a: Run, b: Run) -> bool | None:
    sides = [(x, y) for x, y in ((a.sim, b.sim), (a.control, b.control)) if x and y]
    named = [(x.fingerprint, y.fingerprint) for x, y in sides if x.fingerprint and y.fingerprint]
    return all(x == y for x, y in named) if named else None


def _span(run: Run) -> str:
    return f'{run.stamp[0] * 1e-9:.9g} to {run.stamp[-1] * 1e-9:.9g} s'
