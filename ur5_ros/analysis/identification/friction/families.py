"""Families of friction, linear in their parameters, and which of them held-out motion confirms."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

#: Stribeck speeds that are tried [rad/s].
STRIBECK_SPEEDS = (0.02, 0.05, 0.1, 0.2)

#: Features of friction by their place, each a torque or current per unit of its parameter.
FEATURES = ('viscous', 'Coulomb', 'asymmetric', 'asymmetric viscous', 'viscous cubic',
            'load-dependent',
            *(f'Stribeck {speed:g} rad/s' for speed in STRIBECK_SPEEDS),
            'viscous by temperature', 'Coulomb by temperature')

#: What every family with friction has: the first two features.
LINEAR = 2

#: The place of the first feature of temperature.
TEMPERATURE = FEATURES.index('viscous by temperature')

#: Features that friction never takes away from itself, and the place of the first Stribeck speed.
STRIBECK = 6
POSITIVE = (STRIBECK - 1, *range(STRIBECK, STRIBECK + len(STRIBECK_SPEEDS)))

#: Parts into which a recording is cut, each predicted from the others, and by how much the error
#: must shrink, squared, for friction at all and for each further parameter.
FOLDS, FIRST_GAIN, GAIN = 5, 0.2, 0.05


class Family(NamedTuple):
    """The features that friction of a joint takes."""

    features: tuple[int, ...]
    """Places in :data:`FEATURES`; empty where there is no friction."""
    held_out: float
    """Error on parts left out of the fit, root mean square."""
    held_out_linear: float
    """The same of viscous and Coulomb friction alone."""
    held_out_none: float
    """The same without friction."""

    @property
    def name(self) -> str:
        """Return what the family is called."""
        if not self.features:
            return 'none'
        more = [FEATURES[i] for i in self.features if i >= LINEAR]
        return ', '.join(['viscous and Coulomb', *more])


def friction_features(speed: np.ndarray, direction: np.ndarray, load: np.ndarray,
                      warmer: np.ndarray | None = None) -> np.ndarray:
    """
    Return the features of friction, shape (n, 6, 12).

    ``speed``, ``direction``, ``load`` (n, 6): speed [rad/s], direction of dry friction (-1 to 1),
    torque that the joint carries at rest [N m]; ``warmer`` (n, 6): temperature above that of the
    arm's numbers [K].
    """
    warmer = np.zeros_like(speed) if warmer is None else warmer
    return np.stack([
        speed, direction, np.ones_like(speed), np.abs(speed), speed**3, direction * np.abs(load),
        *(direction * np.exp(-(speed / each)**2) for each in STRIBECK_SPEEDS),
        speed * warmer, direction * warmer], axis=-1)


def choose_family(features: np.ndarray, others: np.ndarray, y: np.ndarray,
                  fold: np.ndarray) -> Family:
    """
    Return the family that predicts parts of a recording left out of its fit best.

    Parameters are added one by one, as long as the error left out shrinks by :data:`GAIN`; at most
    one Stribeck speed, and no part that would drive the joint on.

    ``features`` (n, 12): of one joint; ``others`` (n, p): columns that every family has beside
    friction; p may be zero; ``y`` (n,): what is to be explained; ``fold`` (n,): part that each row
    belongs to, from :func:`folds_of`.
    """
    x = np.column_stack([others, features])
    grams = [_gram(x[fold == each], y[fold == each]) for each in np.unique(fold)]
    fixed = tuple(range(others.shape[1]))

    def error(chosen: Sequence[int]) -> float:
        return _held_out(grams, (*fixed, *(others.shape[1] + i for i in chosen)))

    whole = np.sum([gram[0] for gram in grams], axis=0)
    along = np.sum([gram[1] for gram in grams], axis=0)

    def resists(chosen: Sequence[int]) -> bool:
        pick = np.array([*fixed, *(others.shape[1] + i for i in chosen)])
        value = np.linalg.lstsq(whole[np.ix_(pick, pick)], along[pick], rcond=1e-12)[0]
        sign = np.sign(value[0]) if fixed else 1.0  # of the drive, where there is one
        return all(sign * value[len(fixed) + place] > 0.0
                   for place, i in enumerate(chosen) if i in POSITIVE)

    none, linear = error(()), error(range(LINEAR))
    if linear > (1.0 - FIRST_GAIN) * none:
        return Family((), *np.sqrt([none, linear, none]))
    chosen: tuple[int, ...] = tuple(range(LINEAR))
    best = linear
    while True:
        trials = {i: error((*chosen, i)) for i in _further(chosen)
                  if np.any(features[:, i]) and resists((*chosen, i))}
        i = min(trials, key=trials.__getitem__, default=-1)
        if i < 0 or trials[i] > (1.0 - GAIN) * best:
            return Family(tuple(sorted(chosen)), *np.sqrt([best, linear, none]))
        chosen, best = (*chosen, i), trials[i]


def folds_of(block: np.ndarray) -> np.ndarray:
    """Return the part of each row, neighbouring blocks together, shape as ``block``."""
    return block * FOLDS // (block.max() + 1)


def _further(chosen: Sequence[int]) -> list[int]:
    speeds = range(STRIBECK, STRIBECK + len(STRIBECK_SPEEDS))
    taken = any(i in speeds for i in chosen)
    return [i for i in range(LINEAR, len(FEATURES))
            if i not in chosen and not (taken and i in speeds)]


def _gram(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, int]:
    return x.T @ x, x.T @ y, float(y @ y), len(y)


def _held_out(grams, columns: Sequence[int]) -> float:
    """Return the mean square error of each part, predicted from the others."""
    pick = np.array(columns, dtype=int)
    total = sum(g[0] for g in grams), sum(g[1] for g in grams)
    wrong = count = 0.0
    for gram, along, square, n in grams:
        value = np.linalg.lstsq((total[0] - gram)[np.ix_(pick, pick)],
                                (total[1] - along)[pick], rcond=1e-12)[0]
        wrong += square - 2.0 * value @ along[pick] + value @ gram[np.ix_(pick, pick)] @ value
        count += n
    return max(wrong, 0.0) / max(count, 1.0)
