"""Which bodies touch each other: reported once when it begins and when it ends."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ur5_ros.sim.world.contact import Contacts

#: Time without force after which a contact has ended [s]: a bounce or a rattle is one contact.
SEPARATION_TIME = 0.02

#: Columns of a contact point with its place.
_PLACE = slice(2, 5)


class ContactMonitor:
    """
    Pairs of bodies with a force between them.

    ``control_rate``: control periods a second [Hz].

    """

    def __init__(self, control_rate: int):
        self._quiet_periods = max(1, round(SEPARATION_TIME * control_rate))
        self._quiet: dict[tuple[str, str], int] = {}
        self._steady: list[tuple[str, str]] | None = []
        """Pairs of the last steady step, all with a force: nothing begins, nothing ends."""

    def clear(self) -> None:
        """Forget every contact, as a reset does."""
        self._quiet.clear()
        self._steady = []

    def update(self, steps: Sequence['Contacts']) -> list[tuple[str, dict[str, Any]]]:
        """Take note of a control period."""
        steady = self._steady
        if steady is not None:
            for step in steps:
                if step.acting != len(steady) or step.pairs != steady:
                    break
            else:
                return []
        touching = {pair for step in steps if step.pairs
                    for pair, (x, y, z) in zip(step.pairs, step.force.tolist(), strict=True)
                    if x or y or z}
        last = steps[-1].pairs if steps else []
        self._steady = None
        if touching == self._quiet.keys():
            for pair in touching:
                self._quiet[pair] = 0
            if touching == set(last):
                self._steady = last
            return []
        return self._changes(_felt(steps))

    def _changes(self, felt: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]],
                 ) -> list[tuple[str, dict[str, Any]]]:
        """Return what begins and what ends."""
        reports = []
        for pair, (force, place) in felt.items():
            if pair not in self._quiet:
                size = float(np.linalg.norm(force))
                reports.append((f'{pair[0]} touches {pair[1]} with {size:.4g} N', {
                    'bodies': list(pair), 'active': True, 'force': force.tolist(),
                    'place': place.tolist()}))
            self._quiet[pair] = 0
        for pair in [pair for pair in self._quiet if pair not in felt]:
            self._quiet[pair] += 1
            if self._quiet[pair] >= self._quiet_periods:
                del self._quiet[pair]
                reports.append((f'{pair[0]} and {pair[1]} no longer touch', {
                    'bodies': list(pair), 'active': False}))
        return reports


def _felt(steps: Sequence['Contacts']) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """Return, by pair, the force on the first body [N] and where it acts, of the largest step."""
    found: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]] = {}
    for each in steps:
        size = np.abs(each.force).sum(axis=1)
        for pair in {each.pairs[i] for i in np.flatnonzero(size)}:
            rows = [i for i, other in enumerate(each.pairs) if other == pair and size[i] > 0.0]
            force = each.force[rows].sum(axis=0)
            if pair not in found or np.linalg.norm(force) > np.linalg.norm(found[pair][0]):
                place = np.average(each.points[rows, _PLACE], axis=0, weights=size[rows])
                found[pair] = force, place
    return dict(sorted(found.items()))
