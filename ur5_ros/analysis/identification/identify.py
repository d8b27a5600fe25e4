"""Identification: inertial parameters and friction from recorded torques, with errors."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.identification.friction import MotorFriction, motor_friction
from ur5_ros.analysis.identification.inertia import physical, with_parameters
from ur5_ros.analysis.residual_blocks import SLOW, SampleBlocks, sample_blocks
from ur5_ros.analysis.result import plain
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.regressor import LINK_PARAMETERS, dynamics_regressor, inertial_parameters
from ur5_ros.signals import JOINT_NAMES

#: Blocks taken of one run.
BLOCKS = 1200

#: Speed that a joint must keep for its dry friction to count [rad/s].
MOVING = 0.01

#: Names of the 66 parameters: ten a link, then the rotors.
NAMES = tuple(f'{name}{i}' for i in range(1, 7) for name in LINK_PARAMETERS) + tuple(
    f'rotor{i}' for i in range(1, 7))


class Identified(NamedTuple):
    """The parameters of an arm found from runs."""

    arm: ArmParameters
    """Physical parameters that predict the same torques."""
    base: dict[str, tuple[float, float]]
    """Base parameter -> value and standard error; dependent ones are folded into them."""
    viscous: np.ndarray
    """Viscous friction [N m s/rad], shape (6,)."""
    viscous_error: np.ndarray
    coulomb: np.ndarray
    """Coulomb friction [N m], shape (6,)."""
    coulomb_error: np.ndarray
    condition: float
    """Condition number of the scaled regressor."""
    moved: float
    """Distance of the physical parameters from the fit, in its standard errors; 0 = on it."""
    torque_rms: np.ndarray
    """Torque of the test run, root mean square [N m], shape (6,)."""
    test_rms: np.ndarray
    """Error of the predicted torque on it, root mean square [N m], shape (6,)."""
    test_max: np.ndarray
    """Largest error [N m], shape (6,)."""
    test_run: str
    """Name of the test run."""
    motors: MotorFriction | None
    """Friction from motor currents, where they are recorded."""

    def to_plain(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return plain({
            'format': 'ur5_ros identification', 'version': 1, 'arm': self.arm.name,
            'base_parameters': {name: {'value': value, 'error': error}
                                for name, (value, error) in self.base.items()},
            'viscous_friction': _joints(self.viscous, self.viscous_error),
            'coulomb_friction': _joints(self.coulomb, self.coulomb_error),
            'condition': self.condition, 'moved_sigma': self.moved,
            'test': {'run': self.test_run, 'torque_rms': self.torque_rms.tolist(),
                     'error_rms': self.test_rms.tolist(), 'error_max': self.test_max.tolist()},
            'motors': self.motors.to_plain() if self.motors else None,
        })

    def sentences(self) -> list[str]:
        """Return the outcome in words."""
        words = [f'{len(self.base)} base parameters, condition number {self.condition:.3g}',
                 f'torque predicted on {self.test_run} within '
                 + ', '.join(f'{value:.2g}' for value in self.test_rms) + ' N m RMS a joint, of '
                 + ', '.join(f'{value:.3g}' for value in self.torque_rms) + ' N m']
        for what, unit, value, error in (
                ('viscous friction', 'N m s/rad', self.viscous, self.viscous_error),
                ('Coulomb friction', 'N m', self.coulomb, self.coulomb_error)):
            listed = ', '.join(f'{v:.3g} +- {e:.1g}' for v, e in zip(value, error, strict=True))
            words.append(f'{what} in the torque, joints 1 to 6: {listed} {unit}')
        if self.moved > 3.0 and self.test_rms.max() > 1e-3 * self.torque_rms.max():
            words.append(f'the fit is no physical arm; the nearest is {self.moved:.2g} standard '
                         'errors away: record a run that excites the joints more')
        return words + (self.motors.sentences() if self.motors else [])


def identify(
    runs: Sequence[Run], arm: ArmParameters | None = None, test: Run | None = None,
    name: str = 'identified',
) -> Identified:
    """
    Fit base parameters, rotor inertia and friction to the torques of runs, by least squares.

    The motion is averaged over blocks, in which encoder noise of the rates cancels but for its
    ends. Each joint is weighed by what it leaves unexplained in a first pass. Standard errors are
    taken over blocks.

    Parameters
    ----------
    runs : sequence of Run
        Recordings that excite every joint, such as of the experiment ``exciting``.
    arm : ArmParameters, optional
        Geometry, gravity and limits, and where to begin; the first run's by default.
    test : Run, optional
        Another recording to predict; by default the last fifth of the first run, which is then
        kept out of the fit.
    name : str
        Name of the new arm.

    Raises
    ------
    InputError
        If no arm is known, no torques are recorded, or the motion does not determine the
        parameters.

    Examples
    --------
    >>> from ur5_ros import identify, load_run, run_closed_loop, run_config
    >>> _ = run_closed_loop(run_config('exciting', duration=12.0), folder='excited')
    >>> found = identify([load_run('excited')])
    >>> bool(found.test_rms.max() < 1e-9)  # [N m], on the part that was kept out of the fit
    True

    """
    if not runs:
        raise InputError('no run given; give one or more')
    if arm is None:
        record = runs[0].law_record
        if record is None:
            raise InputError(f'{runs[0].name}: the bag names no arm; give one: --arm NAME')
        arm = record.arm
    samples = [_samples(run, arm) for run in runs]
    if test is not None:
        tested, tested_on = _samples(test, arm), test.name
    else:
        tested_on = f'the last fifth of {runs[0].name}'
        keep = len(samples[0].q) * 4 // 5
        tested = samples[0].rows(slice(keep, None))
        samples[0] = samples[0].rows(slice(0, keep))
    combination, columns = base_of(arm)
    x, y, known = (np.concatenate(parts) for parts in zip(
        *(_rows(each, arm, columns) for each in samples), strict=True))
    value, error, condition = _least_squares(x, y, known)
    count = len(columns)
    start = np.concatenate([inertial_parameters(arm), arm.armature])
    full = physical(combination, value[:count], start)
    away = np.abs(combination @ full - value[:count])
    found = with_parameters(arm, full, name)
    viscous, coulomb = value[count:count + 6], value[count + 6:]
    wrong, torque = _prediction_error(tested, found, viscous, coulomb)
    return Identified(
        found, {NAMES[c]: (float(v), float(e)) for c, v, e in
                zip(columns, value, error, strict=False)},
        viscous, error[count:count + 6], coulomb, error[count + 6:], condition,
        float(np.max(away / np.maximum(error[:count], 1e-9))),
        torque, np.sqrt(np.nanmean(wrong**2, axis=0)), np.nanmax(np.abs(wrong), axis=0),
        tested_on,
        motor_friction(runs, test))


def base_of(arm: ArmParameters, states: int = 500) -> tuple[np.ndarray, np.ndarray]:
    """
    Return which combinations of the 66 parameters motion and torque determine.

    Dependent columns show as zeros on the diagonal of the QR decomposition over spread states
    (Gautier 1991) and are folded into the columns before them.

    Returns
    -------
    combination : numpy.ndarray, shape (b, 66)
        Base parameters = combination @ parameters.
    columns : numpy.ndarray, shape (b,)
        Which columns of the regressor are independent.

    """
    random = np.random.default_rng(1)
    q, qd, qdd = random.uniform(-1.0, 1.0, (3, states, 6)) * np.array([np.pi, 2.0, 5.0])[
        :, None, None]
    w = _inertial_columns(q, qd, qdd, arm).reshape(-1, 66)
    size = np.linalg.norm(w, axis=0)
    size[size == 0.0] = 1.0
    w = w / size
    diagonal = np.abs(np.diag(np.linalg.qr(w, mode='r')))
    columns, others = np.flatnonzero(diagonal > 1e-8), np.flatnonzero(diagonal <= 1e-8)
    folded, *_ = np.linalg.lstsq(w[:, columns], w[:, others], rcond=None)
    combination = np.zeros((len(columns), 66))
    combination[np.arange(len(columns)), columns] = 1.0
    combination[:, others] = folded * size[others] / size[columns][:, None]
    combination[np.abs(combination) < 1e-10] = 0.0
    return combination, columns


def _samples(run: Run, arm: ArmParameters) -> SampleBlocks:
    if np.isnan(run.states.effort).all():
        raise InputError(f'{run.name}: no torques are recorded; they are needed')
    samples = sample_blocks(run, arm, BLOCKS)
    if samples is None:
        raise InputError(f'{run.name}: too few states with a torque follow each other')
    return samples


def _inertial_columns(q, qd, qdd, arm: ArmParameters) -> np.ndarray:
    return np.concatenate([dynamics_regressor(q, qd, qdd, arm), qdd[..., None] * np.eye(6)],
                          axis=-1)


def _rows(samples: SampleBlocks, arm: ArmParameters, columns: np.ndarray):
    """Return block means of regressor (b, 6, p) and torque (b, 6), and which rows count."""
    x = _inertial_columns(samples.q, samples.qd, samples.qdd, arm)[..., columns].mean(axis=1)
    speed, direction = samples.qd_next, np.sign(samples.qd_next)
    friction = [part.mean(axis=1)[:, :, None] * np.eye(6) for part in (speed, direction)]
    least = SLOW if samples.exact else MOVING
    known = (np.abs(speed) > least).all(axis=1) & (np.abs(direction.mean(axis=1)) == 1.0)
    return np.concatenate([x, *friction], axis=-1), samples.effort.mean(axis=1), known


def _least_squares(x: np.ndarray, y: np.ndarray, known: np.ndarray):
    """Return values, standard errors over blocks and the condition number, joints weighed."""
    still = ~known.any(axis=0)
    if still.any():
        raise InputError(f'{JOINT_NAMES[int(np.argmax(still))]} does not move in these runs; '
                         'record one that moves every joint')
    weight = known / np.sqrt(np.mean(y**2, axis=0) + 1e-12)
    scale = np.sqrt(np.mean(y**2))
    for _ in range(2):
        rows = (x * weight[..., None]).reshape(-1, x.shape[-1])
        size = np.linalg.norm(rows, axis=0)
        if np.any(size == 0.0):
            raise InputError('a parameter has no effect in these runs; record one that moves '
                             'every joint')
        tall, square = np.linalg.qr(rows / size)
        u, s, vt = np.linalg.svd(square)
        u = tall @ u
        if s[-1] < 1e-9 * s[0]:
            raise InputError(f'these runs do not tell the parameters apart (condition number '
                             f'{s[0] / s[-1]:.2g}); record the experiment exciting')
        value = (vt.T @ ((u.T @ (y * weight).ravel()) / s)) / size
        left = y - x @ value
        rms = np.sqrt(np.sum((left * known)**2, axis=0) / known.sum(axis=0))
        if rms.max() < 1e-9 * scale:
            break
        final = weight
        weight = known / np.maximum(rms, 1e-6 * scale)
    else:
        weight = final
    blocks = ((left * weight).ravel()[:, None] * u).reshape(len(y), 6, -1).sum(axis=1)
    bread = vt.T / s
    error = np.sqrt(((bread @ blocks.T)**2).sum(axis=1)) / size
    return value, error, float(s[0] / s[-1])


def _prediction_error(samples: SampleBlocks, arm: ArmParameters, viscous, coulomb):
    """Return error (m, 6), NaN where a joint sticks, and RMS of the torque on a run."""
    torque = inverse_dynamics(samples.q, samples.qd, samples.qdd, arm)
    torque = torque + viscous * samples.qd_next + coulomb * np.sign(samples.qd_next)
    wrong = samples.effort - torque
    # The friction of a joint that sticks is not determined by its motion.
    slips = np.abs(samples.qd_next) > (SLOW if samples.exact else MOVING)
    if coulomb.any():
        wrong = np.where(slips if samples.exact else slips.all(axis=1)[:, None], wrong, np.nan)
    wrong = wrong.reshape(-1, 6) if samples.exact else wrong.mean(axis=1)
    return wrong, np.sqrt(np.mean(samples.effort.reshape(-1, 6)**2, axis=0))


def _joints(value: np.ndarray, error: np.ndarray) -> dict[str, dict[str, float]]:
    return {name: {'value': float(v), 'error': float(e)}
            for name, v, e in zip(JOINT_NAMES, value, error, strict=True)}
