"""Motor currents: how a current becomes joint torque, and what friction takes of it."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.external_torque import unexplained_torque
from ur5_ros.analysis.identification.friction.families import (
    FEATURES,
    LINEAR,
    TEMPERATURE,
    Family,
    choose_family,
    folds_of,
)
from ur5_ros.analysis.identification.words import or_dash
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

#: Fewest windows that a joint's motor is fitted to.
FEWEST_WINDOWS = 40


class Motors(NamedTuple):
    """What motor currents give, joint by joint; NaN where the run does not determine it."""

    drive: np.ndarray
    """Joint torque that a current makes [N m/A], of the chosen family, shape (6,)."""
    drive_error: np.ndarray
    viscous: np.ndarray
    """Of the linear family [N m s/rad]."""
    viscous_error: np.ndarray
    coulomb: np.ndarray
    """Of the linear family [N m]."""
    coulomb_error: np.ndarray
    family: tuple[Family | None, ...]
    """The family of friction that was chosen."""
    terms: tuple[dict[str, tuple[float, float]], ...]
    """Its parameters in N m a unit, each with its standard error."""
    model: tuple[np.ndarray | None, ...]
    """Current [A] a unit of torque and of each feature, shape (13,)."""
    test_run: str
    without: np.ndarray
    """RMS of drive x current - torque on the test run [N m]; the drive fitted alone."""
    with_: np.ndarray
    """The same with friction taken off [N m]."""
    current_rms: np.ndarray
    """Error of the predicted current on the test run, root mean square [A]."""
    current_rms_linear: np.ndarray
    """The same with viscous and Coulomb friction alone [A]."""

    def to_plain(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        numbers = [field for field in self._fields
                   if field not in ('family', 'terms', 'model', 'test_run')]
        return {'test_run': self.test_run, 'joints': {name: {
            **{field: float(getattr(self, field)[i]) for field in numbers},
            'family': family.name if family else None,
            'terms': {term: {'value': value, 'error': error}
                      for term, (value, error) in terms.items()},
        } for i, (name, family, terms) in enumerate(
            zip(JOINT_NAMES, self.family, self.terms, strict=True))}}

    def friction_torque(self, effort: np.ndarray, current: np.ndarray,
                        features: np.ndarray) -> np.ndarray:
        """
        Return what friction took of each window, shape (n, 6); NaN where it is not known.

        Parameters
        ----------
        effort, current : numpy.ndarray, shape (n, 6)
            Torque without friction [N m] and current [A].
        features : numpy.ndarray, shape (n, 6, 12)
            Of friction; that of the temperature is left out of the torque.

        """
        torque = np.full_like(effort, np.nan)
        for i, model in enumerate(self.model):
            if model is not None:
                warm = features[:, i, TEMPERATURE:] @ model[1 + TEMPERATURE:]
                torque[:, i] = (current[:, i] - warm) / model[0] - effort[:, i]
        return torque

    def sentences(self) -> list[str]:
        """Return the outcome in words."""
        words = ['from motor currents, joints 1 to 6: '
                 + _listed(self.drive, self.drive_error) + ' N m/A; viscous '
                 + _listed(self.viscous, self.viscous_error) + ' N m s/rad; Coulomb '
                 + _listed(self.coulomb, self.coulomb_error) + ' N m']
        lost = [name for name, drive in zip(JOINT_NAMES, self.drive, strict=True)
                if np.isnan(drive)]
        if lost:
            words.append(f'not excited: the drives of {", ".join(lost)}, whose torque is too '
                         'small beside their friction')
        words.append(f'current predicted on {self.test_run} within '
                     + _plain(self.current_rms) + ' A RMS a joint ('
                     + _plain(self.current_rms_linear)
                     + ' A with viscous and Coulomb friction alone)')
        listed = ', '.join('-' if np.isnan(a) else f'{a:.3g} to {b:.3g}' for a, b in
                           zip(self.without, self.with_, strict=True))
        words.append(f'with it the torque error from currents on {self.test_run} goes from '
                     f'{listed} N m RMS')
        for name, a, b in zip(JOINT_NAMES, self.without, self.with_, strict=True):
            if b > a:
                words.append(f'not on {name}: there its friction in the test run is another '
                             '(speed, load and temperature change it)')
        return words


def motors_from(
    effort: np.ndarray, current: np.ndarray, features: np.ndarray, sliding: np.ndarray,
    block: np.ndarray, test: tuple[np.ndarray, np.ndarray, np.ndarray], test_run: str,
) -> Motors | None:
    """
    Fit current = (torque + friction) / drive, joint by joint.

    ``effort``, ``current`` (n, 6): torque without friction [N m] and current [A] of the windows;
    ``features`` (n, 6, 12): of friction; ``sliding`` (n, 6): where friction has a direction;
    ``block`` (n,): blocks of neighbours.  Returned: None where no currents are recorded.
    """
    if np.isnan(current).all() or np.isnan(test[1]).all():
        return None
    joints = [_joint(effort[:, i], current[:, i], features[:, i], sliding[:, i], block,
                     (test[0][:, i], test[1][:, i], test[2][:, i])) for i in range(6)]
    numbers = {name: np.array([getattr(joint, name) for joint in joints])
               for name in _JointMotor._fields if name not in ('family', 'terms', 'model')}
    return Motors(**numbers, family=tuple(joint.family for joint in joints),
                  terms=tuple(joint.terms for joint in joints),
                  model=tuple(joint.model for joint in joints), test_run=test_run)


def with_motors(arm: ArmParameters, motors: Motors | None, run: Run) -> ArmParameters:
    """Return the arm with torque constants and what it leaves unexplained on a robot's run."""
    if run.sim is not None:  # every step of a simulator can be explained
        return arm
    if motors is not None and np.isfinite(motors.drive).all() and (motors.drive > 0.0).all():
        arm = replace(arm, torque_constant=motors.drive)
    return replace(arm, unexplained_torque=unexplained_torque(run, arm))


def _plain(values: np.ndarray) -> str:
    return ', '.join(or_dash(each) for each in values)


def _listed(value: np.ndarray, error: np.ndarray) -> str:
    return ', '.join('-' if np.isnan(v) else f'{v:.4g} +- {e:.1g}'
                     for v, e in zip(value, error, strict=True))


class _JointMotor(NamedTuple):
    """:class:`Motors` of one joint."""

    drive: float = np.nan
    drive_error: float = np.nan
    viscous: float = np.nan
    viscous_error: float = np.nan
    coulomb: float = np.nan
    coulomb_error: float = np.nan
    without: float = np.nan
    with_: float = np.nan
    current_rms: float = np.nan
    current_rms_linear: float = np.nan
    family: Family | None = None
    terms: dict[str, tuple[float, float]] = {}
    model: np.ndarray | None = None


def _joint(effort, current, features, sliding, block, test) -> _JointMotor:
    """Return the motor of one joint; columns of the arguments of :func:`motors_from`."""
    use = sliding & np.isfinite(current) & np.isfinite(effort)
    if use.sum() < FEWEST_WINDOWS or np.ptp(effort[use]) == 0.0:
        return _JointMotor()
    x, y = np.column_stack([effort, features])[use], current[use]
    block = np.unique(block[use], return_inverse=True)[1]
    value, covariance = _fit(x[:, :3], y, block)
    alone, _ = _fit(x[:, :1], y, block)
    if alone[0] == 0.0 or not value[0] > np.sqrt(covariance[0, 0]):
        return _JointMotor()  # the torque of this joint is too small beside its friction
    family = choose_family(x[:, 1:], x[:, :1], y, folds_of(block))
    columns = [0, *(1 + i for i in (family.features or range(LINEAR)))]
    best, spread = _fit(x[:, columns], y, block)
    model = np.zeros(x.shape[1])
    model[columns] = best
    _, (viscous, viscous_error), (coulomb, coulomb_error) = _in_torque(value, covariance)
    (drive, drive_error), *found = _in_torque(best, spread)
    terms = dict(zip([FEATURES[i - 1] for i in columns[1:]], found, strict=True))
    have = np.isfinite(test[1]) & np.isfinite(test[0])
    t, i = np.column_stack([test[0], test[2]])[have], test[1][have]
    return _JointMotor(
        drive, drive_error, viscous, viscous_error, coulomb, coulomb_error,
        without=_rms(i / alone[0] - t[:, 0]), with_=_rms((i - t @ model) / best[0]),
        current_rms=_rms(i - t @ model), current_rms_linear=_rms(i - t[:, :3] @ value),
        family=family, terms=terms, model=model)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


def _in_torque(value: np.ndarray, covariance: np.ndarray) -> list[tuple[float, float]]:
    """Return drive [N m/A], then each friction term in torque, each with its error."""
    drive = float(1.0 / value[0])
    found = [(drive, float(drive**2 * np.sqrt(covariance[0, 0])))]
    for i in range(1, len(value)):
        friction = value[i] * drive
        slope = np.array([-friction, 1.0]) * drive  # of friction in (value[0], value[i])
        part = covariance[np.ix_([0, i], [0, i])]
        found.append((float(friction), float(np.sqrt(slope @ part @ slope))))
    return found


def _fit(x: np.ndarray, y: np.ndarray, block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return least squares and its covariance, errors taken as dependent within blocks."""
    bread = np.linalg.pinv(x.T @ x, rcond=1e-12, hermitian=True)
    value = bread @ (x.T @ y)
    scores = x * (y - x @ value)[:, None]
    sums = np.zeros((block.max() + 1, x.shape[1]))
    np.add.at(sums, block, scores)
    return value, bread @ (sums.T @ sums) @ bread
