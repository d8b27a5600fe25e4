"""Friction from motor currents: motor torque beyond the torque of the motion."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.signals import JOINT_NAMES

#: Speed below which dry friction has no direction [rad/s], and length of a block [s].
MOVING, BLOCK = 0.01, 1.0


class MotorFriction(NamedTuple):
    """Per joint: how a current becomes torque, and what friction takes of it."""

    drive: np.ndarray
    """Joint torque of a current [N m/A], shape (6,); NaN where it is not determined."""
    drive_error: np.ndarray
    viscous: np.ndarray
    """[N m s/rad]."""
    viscous_error: np.ndarray
    coulomb: np.ndarray
    """[N m]."""
    coulomb_error: np.ndarray
    test_run: str
    without: np.ndarray
    """RMS of drive x current - target torque on the test run [N m]; the drive fitted alone."""
    with_: np.ndarray
    """The same with friction taken off [N m]."""

    def to_plain(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {'test_run': self.test_run, 'joints': {
            name: {field: float(getattr(self, field)[i]) for field in self._fields
                   if field != 'test_run'} for i, name in enumerate(JOINT_NAMES)}}

    def sentences(self) -> list[str]:
        """Return the outcome in words."""
        words = ['from motor currents, joints 1 to 6: viscous friction '
                 + ', '.join(f'{v:.3g} +- {e:.1g}' for v, e in
                             zip(self.viscous, self.viscous_error, strict=True))
                 + ' N m s/rad, Coulomb friction '
                 + ', '.join(f'{v:.3g} +- {e:.1g}' for v, e in
                             zip(self.coulomb, self.coulomb_error, strict=True)) + ' N m']
        listed = ', '.join(f'{a:.3g} to {b:.3g}' for a, b in
                           zip(self.without, self.with_, strict=True))
        words.append(f'with it the torque error from currents on {self.test_run} goes from '
                     f'{listed} N m RMS')
        for name, a, b in zip(JOINT_NAMES, self.without, self.with_, strict=True):
            if b > a:
                words.append(f'not on {name}: there its friction in the test run is another '
                             '(speed, load and temperature change it)')
        return words


def motor_friction(runs: Sequence[Run], test: Run | None = None) -> MotorFriction | None:
    """
    Fit current = (torque + viscous qd + Coulomb sign(qd)) / drive, joint by joint.

    The result is tried on ``test``, by default the last run fitted; None where no currents are
    recorded.

    """
    runs = [run for run in runs if run.current is not None]
    if not runs or (test is not None and test.current is None):
        return None
    test = test or runs[-1]
    number = np.full((8, 6), np.nan)
    for joint in range(6):
        x, y, block = (np.concatenate(parts) for parts in zip(
            *(_rows(run, joint, i) for i, run in enumerate(runs)), strict=True))
        if len(y) < 100 or np.linalg.matrix_rank(x) < 3:
            continue
        value, covariance = _fit(x, y, block)
        plain, _ = _fit(x[:, :1], y, block)
        drive = 1.0 / value[0]
        number[0, joint], number[1, joint] = drive, drive**2 * np.sqrt(covariance[0, 0])
        for row, i in ((2, 1), (4, 2)):
            friction = value[i] * drive
            slope = np.array([-friction, 1.0]) * drive  # of friction in (value[0], value[i])
            part = covariance[np.ix_([0, i], [0, i])]
            number[row, joint] = friction
            number[row + 1, joint] = np.sqrt(slope @ part @ slope)
        x, y, _ = _rows(test, joint, 0)
        number[6, joint] = np.sqrt(np.mean((y / plain[0] - x[:, 0])**2))
        number[7, joint] = np.sqrt(np.mean((drive * y - x @ (drive * value))**2))
    drive, drive_error, viscous, viscous_error, coulomb, coulomb_error, without, left = number
    return MotorFriction(drive, drive_error, viscous, viscous_error, coulomb, coulomb_error,
                         test.name, without, left)


def _rows(run: Run, joint: int, which: int):
    torque, qd = run.states.effort[:, joint], run.states.qd[:, joint]
    current = run.required_current[:, joint]
    use = np.isfinite(torque) & np.isfinite(current) & (np.abs(qd) > MOVING)
    x = np.column_stack([torque, qd, np.sign(qd)])[use]
    return x, current[use], (run.t[use] // BLOCK).astype(int) + 1_000_000 * which


def _fit(x: np.ndarray, y: np.ndarray, block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return least squares and its covariance, errors taken as dependent within blocks."""
    bread = np.linalg.inv(x.T @ x)
    value = bread @ (x.T @ y)
    scores = x * (y - x @ value)[:, None]
    sums = np.zeros((len(np.unique(block)), x.shape[1]))
    np.add.at(sums, np.unique(block, return_inverse=True)[1], scores)
    return value, bread @ (sums.T @ sums) @ bread
