"""Causes in the body of one link: its mass, its centre of mass or its tensor is another."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.diagnosis.selection import LARGEST_COM_DISTANCE, LINKS, Causes, Fit
from ur5_ros.analysis.diagnosis.selection import fit as fit_causes
from ur5_ros.analysis.residual_blocks import SampleBlocks
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import dynamics_regressor, link_parameters

#: One of mass, centre and tensor explains it alone where it leaves at most so many times what all
#: three together leave, or what the means of blocks leave, or rounding where nothing else does.
ALONE, MEANS, ROUNDING = 1.3, 1e-4, 1e-12

#: What a value may be uncertain by, as a share of its change.
VAGUE = 0.3

#: Times that a centre of mass is fitted: the torque is quadratic in it.
PASSES = 5

#: Names of the links, as ur_description has them.
NAMES = ('shoulder', 'upper arm', 'forearm', 'wrist 1', 'wrist 2')


class _Change(NamedTuple):
    """One quantity of a link that explains what is unexplained."""

    field: str
    value: np.ndarray
    """How much it is more than the law's."""
    error: np.ndarray
    left: float
    link: int


def link_units(samples: SampleBlocks, arm: ArmParameters) -> dict[str, np.ndarray]:
    """Return the torque of a unit of the ten parameters of links 1 to 5: name -> (b, 6, 10)."""
    Y = dynamics_regressor(samples.q, samples.qd, samples.qdd, arm).mean(axis=1)
    return {name: Y[..., 10 * i:10 * i + 10] for i, name in enumerate(LINKS)}


def link_torque(name: str, value: np.ndarray, samples: SampleBlocks,
                arm: ArmParameters) -> np.ndarray:
    """Return the torque of a change of a link in each sample, (b, w, 6)."""
    i = LINKS.index(name)
    Y = dynamics_regressor(samples.q, samples.qd, samples.qdd, arm)
    torque: np.ndarray = Y[..., 10 * i:10 * i + 10] @ value
    return torque


def link_cause(name: str, found: Fit, causes: Causes) -> dict[str, Any]:
    """
    Return which of mass, centre of mass and tensor of which link is another, in words.

    ``name``: the link whose ten parameters explain most; others may explain as much.
    """
    others = tuple(each for each in found.names if each != name)
    limit = _limit(found)
    changes = [change for link in LINKS for change in _changes(link, others, causes)
               if change.left <= limit]
    sure = [each for each in changes
            if each.field != 'tensor' and np.linalg.norm(each.error) < VAGUE * np.linalg.norm(
                each.value)]
    sure.sort(key=lambda each: (len(each.value), each.left))
    if not sure:
        links = {each.link for each in changes} | {LINKS.index(name)} | {
            i for i, each in enumerate(LINKS)
            if fit_causes(causes, (*others, each)).left <= ALONE * limit}
        named = ' or '.join(f'{i + 1} ({NAMES[i]})' for i in sorted(links))
        return {'kind': 'link body', 'links': sorted(i + 1 for i in links), 'determined': False,
                'sentence': f"the body of link {named} is another than the controller's arm has, "
                'in mass, centre of mass or tensor; this motion does not determine it'}
    words = ', or '.join(_words(each, causes.arm) for each in sure)
    return {'kind': f'link {sure[0].field}', 'links': [each.link + 1 for each in sure],
            'changes': [{'link': each.link + 1, 'field': each.field,
                         'change': each.value.tolist(), 'error': each.error.tolist()}
                        for each in sure],
            'sentence': words}


def masses_instead_of(name: str, found: Fit, causes: Causes) -> str:
    """Return in words the links whose mass alone would explain as much as a cause does."""
    others = tuple(each for each in found.names if each != name)
    limit = _limit(found)
    alike = []
    for i, link in enumerate(LINKS):
        if link not in causes.units or link in others:
            continue
        change = _mass(i, causes.arm, _refit(link, others, causes))
        if change.left <= limit and change.error[0] < VAGUE * abs(change.value[0]):
            alike.append(_words(change, causes.arm))
    return f'; it would look the same if {" or ".join(alike)}' if alike else ''


def _limit(found: Fit) -> float:
    """Return what one quantity alone may leave where the whole body leaves what was found."""
    return max(MEANS if found.left > ROUNDING else ROUNDING, ALONE * found.left)


def _changes(name: str, others: tuple[str, ...], causes: Causes) -> list[_Change]:
    """Return what each quantity of a link alone leaves beside other causes."""
    i, refit = LINKS.index(name), _refit(name, others, causes)
    return [_mass(i, causes.arm, refit), _centre(i, causes.arm, refit), _tensor(i, refit)]


#: Fits columns of a link's ten parameters (10, p): values, errors and what is left.
_Refit = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, float]]


def _refit(name: str, others: tuple[str, ...], causes: Causes) -> _Refit:
    """Return what fits columns of a link's parameters beside other causes."""
    def refit(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        unit = causes.units[name] @ columns
        trial = fit_causes(causes._replace(units={**causes.units, name: unit}), (*others, name))
        part = slice(-columns.shape[1], None)
        return trial.value[part], trial.error[part], trial.left
    return refit


def _mass(i: int, arm: ArmParameters, refit: _Refit) -> _Change:
    """Return the change of the mass, the centre and the tensor about it as they are."""
    value, error, left = refit(_link(1.0, arm.com[i])[:, None])
    heavy = arm.mass[i] + value[0] > 0.0
    return _Change('mass', value, error, left if heavy else np.inf, i)


def _centre(i: int, arm: ArmParameters, refit: _Refit) -> _Change:
    """Return the change of the centre of mass, the tensor about it as it is."""
    change, error, left = np.zeros(3), np.zeros(3), np.inf
    for _ in range(PASSES):  # the torque is linear in the change about its middle
        middle = arm.com[i] + 0.5 * change
        columns = np.column_stack([0.5 * (
            _link(arm.mass[i], middle + axis) - _link(arm.mass[i], middle - axis))
            for axis in np.eye(3)])
        change, error, left = refit(columns)
    near = np.linalg.norm(arm.com[i] + change) < LARGEST_COM_DISTANCE
    return _Change('centre of mass', change, error, left if near else np.inf, i)


def _tensor(i: int, refit: _Refit) -> _Change:
    return _Change('tensor', *refit(np.eye(10)[:, 4:]), i)


def _link(mass: float, com: np.ndarray) -> np.ndarray:
    """Return the ten parameters of a point mass."""
    return link_parameters(np.array([mass]), com[None], np.zeros((1, 3, 3)))


def _words(change: _Change, arm: ArmParameters) -> str:
    i = change.link
    where = f'of link {i + 1} ({NAMES[i]})'
    if change.field == 'mass':
        return (f'the mass {where} is {arm.mass[i] + change.value[0]:.4g} +- '
                f'{change.error[0]:.1g} kg instead of {arm.mass[i]:.4g} kg')
    here, law = (', '.join(f'{x:.3g}' for x in np.where(np.abs(each) > 1e-9, each, 0.0))
                 for each in (arm.com[i] + change.value, arm.com[i]))
    return (f'the centre of mass {where} is at [{here}] +- {change.error.max():.1g} m instead of '
            f'[{law}] m, in its DH frame')
