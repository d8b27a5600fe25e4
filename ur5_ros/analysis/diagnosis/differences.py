"""Which parameters two arms differ in, ranked by the torque that each explains."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.residual_blocks import SampleBlocks
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor, link_parameters

#: Blocks that are looked at.
MOST_BLOCKS = 150

#: Differences are named until so much of the squared residual is explained.
EXPLAINED_SHARE = 0.9995

#: Field -> what it is called, unit.
_LINKS = {'mass': ('mass', 'kg'), 'com': ('centre of mass', 'm'), 'inertia': ('tensor', 'kg m^2'),
          'armature': ('rotor inertia', 'kg m^2')}


class Difference(NamedTuple):
    """A parameter in which the plant is another than the controller's arm."""

    parameter: str
    """Such as ``centre of mass 3``."""
    plant: Any
    """Its value in the plant, a number or a list of them."""
    law: Any
    unit: str
    alone: float
    """Share of the squared residual that mending this one explains; negative: it adds to it."""
    together: float
    """Share explained when this one and all before it are mended."""

    def words(self) -> str:
        """Return the difference in words."""
        return (f'{_of_link(self.parameter)} is {_number(self.plant)} {self.unit} instead of '
                f'{_number(self.law)} {self.unit}')


class Mending(NamedTuple):
    """Every difference, and what mending all of them leaves."""

    differences: tuple[Difference, ...]
    """The order is that in which mending explains most."""
    before: float
    """Unexplained torque, root mean square [N m]."""
    after: float
    """The same with every difference mended [N m]."""

    def words(self) -> str:
        """Return the differences that matter in words, and the names of the others."""
        count = 1 + next((i for i, each in enumerate(self.differences)
                          if each.together > EXPLAINED_SHARE), len(self.differences) - 1)
        named = [each for i, each in enumerate(self.differences)
                 if i < count or each.parameter.startswith(('gravity', 'geometry'))]
        rest = ', '.join(_of_link(each.parameter) for each in self.differences
                         if each not in named)
        share = self.differences[count - 1].together
        return '; '.join(each.words() for each in named) + (
            f' ({share:.2%} of the squared residual; smaller: {rest})' if rest else '')


def _of_link(parameter: str) -> str:
    """Return ``mass of link 3`` for ``mass 3``."""
    return re.sub(r' (\d)$', r' of link \1', parameter)


def differences(law: ArmParameters, plant: ArmParameters, samples: SampleBlocks,
                weight: np.ndarray) -> Mending:
    """
    Return the parameters in which two arms differ, those first that explain most.

    Each is mended alone, then one after the other, always the one that leaves least.

    ``weight`` (b, 6): weight of each block and joint.
    """
    keep = np.unique(np.linspace(0, len(samples.q) - 1, MOST_BLOCKS).astype(int))
    torque, w = _Torque(samples.rows(keep), law), weight[keep]
    state = _state(law)

    def left(each: _State) -> float:
        return float(np.sum((torque.missing(each) * w)**2))

    items, before = _items(law, plant), left(state)
    alone = {name: left(mend(state)) for name, mend, *_ in items}
    found: list[Difference] = []
    while items:
        trials = [left(mend(state)) for _, mend, *_ in items]
        best = int(np.argmin(trials))
        name, mend, mine, its, unit = items.pop(best)
        state = mend(state)
        found.append(Difference(name, its, mine, unit, 1.0 - alone[name] / before,
                                1.0 - trials[best] / before))
    return Mending(tuple(found), *(float(np.sqrt(np.mean(torque.missing(each)[w > 0.0]**2)))
                                   for each in (_state(law), state)))


class _State(NamedTuple):
    """An arm on its way from the law's to the plant's: it need not be one that can exist."""

    mass: np.ndarray
    com: np.ndarray
    inertia: np.ndarray
    armature: np.ndarray
    geometry: ArmParameters
    """Whose DH parameters and angle offsets it has."""
    gravity: ArmParameters
    """Whose gravity it has."""


#: What makes one difference good.
_Mend = Callable[[_State], _State]


class _Torque:
    """The torque that a state does not explain, from the regressors of both arms."""

    def __init__(self, samples: SampleBlocks, law: ArmParameters):
        self._samples, self._law = samples, law
        self._effort = samples.effort.mean(axis=1)
        self._qdd = samples.qdd.mean(axis=1)
        self._regressors: dict[tuple[str, str], np.ndarray] = {}

    def missing(self, state: _State) -> np.ndarray:
        """Return the unexplained torque of each block, shape (b, 6)."""
        key = state.geometry.name, state.gravity.name
        if key not in self._regressors:
            seen = self._samples
            arm = replace(state.geometry, gravity=state.gravity.gravity)
            angles = seen.q - self._law.angle_offset + arm.angle_offset
            self._regressors[key] = dynamics_regressor(
                angles, seen.qd, seen.qdd, arm).mean(axis=1)
        links = link_parameters(state.mass, state.com, state.inertia)
        return self._effort - self._regressors[key] @ links - state.armature * self._qdd


def _state(arm: ArmParameters) -> _State:
    return _State(*arm.bodies, arm.armature, arm, arm)


def _items(law: ArmParameters, plant: ArmParameters) -> list[tuple]:
    """Return (name, what mends it, value of law, value of plant, unit) of each difference."""
    items: list[tuple] = []
    if any(_differ(getattr(law, name), getattr(plant, name))
           for name in ('a', 'd', 'alpha', 'angle_offset')):
        items.append(('geometry (DH a2, a3, d1, d4, d5, d6)',
                      lambda state: state._replace(geometry=plant),
                      *([*arm.a[1:3].tolist(), *arm.d[[0, 3, 4, 5]].tolist()]
                        for arm in (law, plant)), 'm'))
    if _differ(law.gravity, plant.gravity):
        upright = not law.gravity[:2].any() and not plant.gravity[:2].any()
        items.append(('gravity', lambda state: state._replace(gravity=plant),
                      *(float(arm.gravity[2]) if upright else arm.gravity.tolist()
                        for arm in (law, plant)), 'm/s^2'))
    mine, its = _state(law), _state(plant)
    for field, (name, unit) in _LINKS.items():
        for i in range(6):
            one, other = getattr(mine, field)[i], getattr(its, field)[i]
            if _differ(one, other):
                items.append((f'{name} {i + 1}', _mender(field, i, other), _plain(one),
                              _plain(other), unit))
    return items


def _mender(field: str, i: int, value: np.ndarray) -> _Mend:
    """Return what gives a state another value of link or joint i."""
    def mend(state: _State) -> _State:
        whole = np.array(getattr(state, field))
        whole[i] = value
        changed: dict[str, Any] = {field: whole}
        return state._replace(**changed)
    return mend


def _differ(one, other) -> bool:
    return bool(np.max(np.abs(np.asarray(one) - other)) > 1e-12)


def _plain(value: Any) -> float | list[float]:
    """Return a number, a vector, or a tensor as xx, yy, zz, xy, xz, yz."""
    value = np.asarray(value)
    if value.ndim == 2:
        value = value[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return value.tolist()


def _number(value: float | Sequence[float]) -> str:
    if isinstance(value, float):
        return f'{value:.5g}'
    return '[' + ', '.join(f'{each:.5g}' for each in value) + ']'
