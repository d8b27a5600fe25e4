"""Which causes act together: fitted, kept to what a body can have, and chosen one by one."""

from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.diagnosis.measurement import MEASUREMENT, is_possible
from ur5_ros.model.parameters import ArmParameters

#: A cause must explain this many times the noise.
MIN_SIGNAL = 40.0

#: Number of standard errors from which on a value is significant.
SIGNIFICANT = 5.0

#: A change of the values by less than this share of the largest makes no confounder.
SMALLEST_CHANGE = 1e-3

#: A load's centre of mass is within this distance of the tool flange [m].
LARGEST_COM_DISTANCE = 1.0

#: A gravity whose size is not none, once or twice the arm's, within this share of it, must leave
#: this many times less than another cause does; less than that share does not count.
COMMON, ODD, NEGLIGIBLE = 0.05, 10.0, 1e-9

#: Causes in the body of one link, and how many times less than another cause one must leave: of a
#: simulated arm, and of a robot, whose torques may be measured wrongly instead.
LINKS, RARE, RARER = tuple(f'body of link {i}' for i in range(1, 6)), 3.0, 12.0

#: Most causes that are added at once.
TOGETHER = 2

#: An effort that is measured wrongly must explain this share of what others leave.
MOST = 0.5

#: Singular values under this share of the largest are rounding; and the part of a parameter that
#: may lie along them.
RANK, LOST = 1e-10, 1e-3


class Causes(NamedTuple):
    """The unexplained torque in blocks, and what may explain it."""

    torque: np.ndarray
    """Unexplained torque [N m], shape (b, 6)."""
    weight: np.ndarray
    """Weight of each block and joint; zero where it does not count, shape (b, 6)."""
    units: Mapping[str, np.ndarray]
    """Torque that a unit of each cause adds, name -> (b, 6, parameters)."""
    arm: ArmParameters
    """The arm of the law: what a cause adds to it must be physical."""


class Fit(NamedTuple):
    """Causes fitted together."""

    names: tuple[str, ...]
    value: np.ndarray
    """All parameters, cause after cause."""
    error: np.ndarray
    """Their standard errors."""
    left: float
    """What stays unexplained, squared, as a share of everything."""
    determined: np.ndarray
    """Whether the motion determines each parameter."""
    confounders: tuple[str, ...] = ()
    """Causes that are not needed, but that this motion does not separate from those found."""

    def part(self, name: str, causes: Causes) -> slice:
        """Return where the parameters of a cause are."""
        start = sum(causes.units[other].shape[-1]
                    for other in self.names[:self.names.index(name)])
        return slice(start, start + causes.units[name].shape[-1])


def choose(causes: Causes, least: float) -> Fit:
    """
    Add the best cause as long as it is significant, then drop those that no longer are.

    Where no single one is, several that act together may be.
    """
    chosen: tuple[str, ...] = ()
    best = fit(causes, chosen)
    while len(chosen) < len(causes.units):
        more = _compatible(causes, chosen)
        for together in range(1, min(TOGETHER, len(more)) + 1):
            if together > 1:
                more = [name for name in more if name not in LINKS]
            trials = [fit(causes, (*chosen, *names)) for names in combinations(more, together)]
            if not trials:
                continue
            trial = min(trials, key=lambda each: _effective_left(each, causes))
            if _is_significant(best, trial, causes, least):
                break
        else:
            break
        chosen, best = trial.names, trial
    for name in chosen:
        without = tuple(other for other in chosen if other != name)
        trial = fit(causes, without)
        if not _is_significant(trial, best, causes, least):
            chosen, best = without, trial
    return best


def _compatible(causes: Causes, chosen: tuple[str, ...]) -> list[str]:
    """Return the causes that may be added: the body of one link goes with friction alone."""
    others = [name for name in chosen if not name.endswith('friction')]
    more = [name for name in causes.units if name not in chosen]
    if any(name in LINKS for name in others):
        return [name for name in more if name.endswith('friction')]
    return [name for name in more if not others or name not in LINKS]


def with_confounders(best: Fit, causes: Causes) -> Fit:
    """
    Return the fit with errors as wide as what other causes would change.

    A cause that explains too little to be named may still act, and the causes found have then
    taken its share: where one is significant and changes them, it is a confounder.

    """
    confounders, error = [], best.error
    if any(name in (*MEASUREMENT, *LINKS) for name in best.names):
        return best  # it is there because nothing else does nearly as well
    for name in causes.units:
        if name in best.names or not best.names or name in (*MEASUREMENT, *LINKS):
            continue
        trial = fit(causes, (*best.names, name))
        count = len(best.value)
        moved = np.abs(trial.value[:count] - best.value)
        significant = np.abs(trial.value[count:]) > SIGNIFICANT * trial.error[count:]
        if significant.any() and (moved > SIGNIFICANT * best.error).any():
            error = np.maximum(error, np.hypot(moved, trial.error[:count]))
            if moved.max() > SMALLEST_CHANGE * np.abs(best.value).max():
                confounders.append(name)
    return best._replace(error=error, confounders=tuple(confounders))


def fit(causes: Causes, names: tuple[str, ...]) -> Fit:
    """
    Return causes fitted together, kept to what a body can have.

    Friction and rotor inertia that would be less than nothing are left out, joint by joint; a
    load that no body can be explains nothing.

    """
    y = (causes.torque * causes.weight).ravel()
    total = float(y @ y)
    if not names:
        return Fit((), np.zeros(0), np.zeros(0), 1.0, np.zeros(0, dtype=bool))
    x = (np.concatenate([causes.units[name] for name in names], axis=-1)
         * causes.weight[..., None]).reshape(y.size, -1)
    lowest = np.concatenate([_lowest(name, causes) for name in names])
    use = np.ones(x.shape[1], dtype=bool)
    for _ in range(x.shape[1]):
        value, error, determined = _least_squares(x * use, y, len(causes.torque))
        below = use & (value < lowest)
        if not below.any():
            break
        use &= ~below
    found = Fit(names, value, error, float(np.sum((y - x @ value)**2)) / total, determined)
    if 'payload' in names and not _can_be_a_load(found, causes):
        return found._replace(left=np.inf)
    if not all(is_possible(name, value[found.part(name, causes)])
               for name in names if name in MEASUREMENT):
        return found._replace(left=np.inf)
    return found


def _least_squares(x: np.ndarray, y: np.ndarray, blocks: int):
    """Return values, standard errors and which parameters are determined, (p,) each."""
    size = np.linalg.norm(x, axis=0)
    size[size == 0.0] = 1.0
    x = x / size
    count = x.shape[1]
    # the same from the triangle of a QR takes a tenth of the time of x's own SVD
    r = np.asarray(np.linalg.qr(np.column_stack([x, y]), mode='r'))[:count]
    u, s, vt = np.linalg.svd(r[:, :count], full_matrices=False)
    keep = s > RANK * max(s[0], 1e-300)
    inverse = np.where(keep, 1.0 / np.maximum(s, 1e-300), 0.0)
    value = vt.T @ (inverse * (u.T @ r[:, count]))
    # Sandwich over blocks: what is left in one block is not independent.
    sums = ((y - x @ value)[:, None] * x).reshape(blocks, 6, count).sum(axis=1)
    bread = vt.T * inverse
    error = np.sqrt(((bread @ (sums @ bread).T)**2).sum(axis=1))
    determined = np.sum(vt[keep]**2, axis=0) > 1.0 - LOST
    return value / size, error / size, determined


def _lowest(name: str, causes: Causes) -> np.ndarray:
    """Return the least value of each parameter of a cause."""
    if name.endswith('friction'):
        return np.zeros(6)
    if name == 'armature':
        return -causes.arm.armature - 1e-9
    return np.full(causes.units[name].shape[-1], -np.inf)


def _can_be_a_load(found: Fit, causes: Causes) -> bool:
    """Return whether the load has no negative mass and its centre within reach."""
    part = found.part('payload', causes)
    value, error = found.value[part], found.error[part]
    if not found.determined[part][:4].all():
        return True  # its size is then not named
    declared = causes.arm.payload.mass
    if value[0] < -1.02 * declared - SIGNIFICANT * error[0]:  # 2 % for the averaging of blocks
        return False
    arm = np.linalg.norm(value[1:4]) - SIGNIFICANT * np.linalg.norm(error[1:4])
    return bool(arm <= LARGEST_COM_DISTANCE * max(abs(value[0]), SIGNIFICANT * error[0]))


def _effective_left(found: Fit, causes: Causes) -> float:
    """
    Return what stays unexplained.

    A gravity unlike any mounting, and an effort that is measured wrongly, must explain much more.
    """
    left = found.left + NEGLIGIBLE
    if any(name in MEASUREMENT for name in found.names):
        return ODD * left
    if any(name in LINKS for name in found.names):
        measured = any(name in MEASUREMENT for name in causes.units)
        return (RARER if measured else RARE) * left
    if found.names[-1:] != ('gravity',):
        return left
    size = float(np.linalg.norm(
        causes.arm.gravity + found.value[found.part('gravity', causes)]))
    times = size / max(float(np.linalg.norm(causes.arm.gravity)), 1e-300)
    return left if min(abs(times - n) for n in (0, 1, 2)) < COMMON else ODD * left


def _is_significant(without: Fit, with_: Fit, causes: Causes, least: float) -> bool:
    if not np.isfinite(without.left):
        return True
    gain = without.left - with_.left
    if any(name in MEASUREMENT for name in set(with_.names) - set(without.names)) and (
            gain < MOST * without.left):
        return False
    more = len(with_.value) - len(without.value)
    noise = with_.left / max(causes.torque.size - len(with_.value), 1)
    return gain > least and gain > 1e-3 * without.left and gain > MIN_SIGNAL * more * noise
