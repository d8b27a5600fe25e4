"""Identification: inertial parameters and friction from recorded torques, with errors."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.identification.base_parameters import (
    BaseParameters,
    all_parameters,
    base_of,
    typical_sizes,
)
from ur5_ros.analysis.identification.drives import drives_alone
from ur5_ros.analysis.identification.friction import (
    FEATURES,
    LINEAR,
    TEMPERATURE,
    Family,
    choose_family,
    folds_of,
)
from ur5_ros.analysis.identification.inertia import physical, with_parameters
from ur5_ros.analysis.identification.joint_friction import joint_friction_of
from ur5_ros.analysis.identification.least_squares import Estimate, blocks_of, least_squares
from ur5_ros.analysis.identification.motors import Motors, motors_from, with_motors
from ur5_ros.analysis.identification.payload import PayloadEstimate, payload_from
from ur5_ros.analysis.identification.result import Identified, Prediction
from ur5_ros.analysis.identification.rows import Rows, last_fifth, of_three, rows_of
from ur5_ros.analysis.identification.samples import has_currents_alone
from ur5_ros.analysis.identification.simulation_gate import simulate
from ur5_ros.analysis.validate import no_arm
from ur5_ros.errors import InputError
from ur5_ros.model.friction import JointFriction
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES

__all__ = ['Identified', 'base_of', 'identify', 'identify_payload']

#: Share of the base parameters that a motion must determine.
LEAST = 0.5

#: Times that fit and families of friction are found in turn, and a residual that is rounding.
FAMILY_PASSES, ROUNDING = 3, 1e-8

#: Viscous and Coulomb friction, of which a fit begins.
_BOTH = tuple(range(LINEAR))


class _Fit(NamedTuple):
    """A fit, and which features of friction its last columns are: (joint, feature)."""

    estimate: Estimate
    friction: tuple[tuple[int, int], ...]


class _Solution(NamedTuple):
    """The result of windows: the linear fit, the best one and the physical parameters."""

    linear: _Fit
    best: _Fit
    families: tuple[Family, ...]
    determined: np.ndarray
    """Which base parameters the motion determines, shape (b,)."""
    x: np.ndarray
    """Physical parameters, shape (66,)."""
    block: np.ndarray
    features: np.ndarray


def identify(
    runs: Sequence[Run], arm: ArmParameters | None = None, test: Run | None = None,
    name: str = 'identified', payload: Run | None = None,
) -> Identified:
    """
    Fit base parameters, rotor inertia and friction to the torques of runs, then a physical arm.

    Base parameters by weighted least squares on the measured states, with standard errors; the
    family of friction by its error on parts left out; then the physical arm nearest to the fit
    and to the arm that is there.

    Parameters
    ----------
    runs : sequence of Run
        Recordings that excite every joint, such as of the experiment ``exciting``.
    arm : ArmParameters, optional
        Geometry, gravity and limits, and where to begin; the first run's by default.
    test : Run, optional
        Another recording to predict; by default the last fifth of the first run is predicted
        from a fit without it, and the result is the fit of everything.
    name : str
        Name of the new arm.
    payload : Run, optional
        Recording of the same arm with a load at its tool, which is then determined from motor
        currents where both have them, else from torques.

    Raises
    ------
    InputError
        If no arm is known, torques are not recorded, or the motion excites too little.

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
    arm = arm_of(runs[0]) if arm is None else arm
    every = [*runs, *([test] if test is not None else [])]
    if any(map(has_currents_alone, every)):
        return drives_alone(runs, arm, test, name, payload)
    rows, base = rows_of(runs, arm), base_of(arm)
    found = _solve(rows, base, arm)
    if test is None:
        kept, tried = last_fifth(rows)
        tested, tried_name = _solve(kept, base, arm), f'the last fifth of {runs[0].name}'
    else:
        tested, tried, tried_name = found, rows_of([test], arm), test.name
    bodies = with_parameters(arm, found.x, name)
    worst = simulate(bodies)
    if not np.isfinite(worst):
        raise InputError('the identified arm does not move as an arm in simulation; give another '
                         '--arm to begin with')
    motors = motors_from(rows.effort, rows.current, found.features, rows.sliding, found.block,
                         (tried.effort, tried.current, tried.friction), tried_name)
    estimate, count = found.best.estimate, len(base.columns)
    keep = found.determined
    error = estimate.error[:count][keep]
    away = np.abs(base.combination @ found.x - estimate.value[:count])[keep]
    named = np.array(base.names)
    viscous, viscous_error, coulomb, coulomb_error = _by_joint(found.linear)
    return Identified(
        arm=with_motors(replace(bodies, friction=_arm_friction(found, rows, motors)), motors,
                        runs[0] if test is None else test),
        base=dict(zip(named[keep].tolist(), zip(estimate.value[:count][keep].tolist(),
                                                error.tolist(), strict=True), strict=True)),
        not_excited=tuple(named[~keep].tolist()),
        covariance=estimate.covariance[:count, :count][np.ix_(keep, keep)],
        viscous=viscous, viscous_error=viscous_error, coulomb=coulomb,
        coulomb_error=coulomb_error, family=found.families, terms=_terms(found.best),
        condition=estimate.condition,
        moved=float(np.max(away / np.maximum(error, 1e-9), initial=0.0)),
        train=_predict(rows, base, found, ', '.join(run.name for run in runs)),
        test=_predict(tried, base, tested, tried_name), motors=motors,
        payload=_payload(payload, arm, found, motors), simulated=worst)


def identify_payload(run: Run, arm: ArmParameters | None = None) -> PayloadEstimate:
    """
    Return the load at the tool that the torque of one run shows, beyond the arm's own bodies.

    ``arm``: the arm without the load; by default the one that the run names.
    """
    arm = arm_of(run) if arm is None else arm
    if has_currents_alone(run):
        raise InputError(f'{run.name}: motor currents alone are recorded; give a run without the '
                         'load beside it: ur5 identify UNLOADED --payload LOADED')
    rows = rows_of([run], arm)
    return payload_from(rows, rows.inertial @ all_parameters(arm), rows.friction, None,
                        run.name)


def fit_base(runs: Sequence[Run], arm: ArmParameters) -> Estimate:
    """Return base parameters, then viscous and Coulomb friction, before any physical arm."""
    rows = rows_of(runs, arm)
    return _fit(rows, base_of(arm), rows.friction, [_BOTH] * 6,
                blocks_of(rows.time, rows.run)).estimate


def arm_of(run: Run) -> ArmParameters:
    """Return the arm that a run names: the law's, else the plant's."""
    record = run.law_record
    if record is None:
        raise InputError(no_arm(run))
    return record.arm


def _solve(rows: Rows, base: BaseParameters, arm: ArmParameters) -> _Solution:
    """Return fits, families of friction and the physical parameters of windows."""
    block, features = blocks_of(rows.time, rows.run), rows.friction
    linear = _fit(rows, base, features, [_BOTH] * 6, block)
    determined = _determined(linear.estimate, base, arm)
    best, families = linear, [Family(_BOTH, 0.0, 0.0, 0.0)] * 6
    for _ in range(FAMILY_PASSES):
        chosen = families
        families = _families(rows, base, features, best, block)
        if [family.features for family in families] == [family.features for family in chosen]:
            break
        best = _fit(rows, base, features, [family.features for family in families], block)
    keep = np.flatnonzero(determined)
    x = physical(base.combination[keep], best.estimate.value[keep],
                 _information(best.estimate.factor, keep), all_parameters(arm),
                 typical_sizes(arm))
    return _Solution(linear, best, tuple(families), determined, x, block, features)


def _fit(rows: Rows, base: BaseParameters, features: np.ndarray, chosen: Sequence[Sequence[int]],
         block: np.ndarray) -> _Fit:
    """Fit the base parameters and, for each joint, the features of friction chosen for it."""
    # feature after feature, so that viscous friction of six joints comes first
    friction = tuple((joint, feature) for feature in range(len(FEATURES))
                     for joint in range(6) if feature in chosen[joint])
    columns = np.zeros((*rows.effort.shape, len(friction)))
    for place, (joint, feature) in enumerate(friction):
        columns[:, joint, place] = features[:, joint, feature]
    # The friction of a joint that sticks is whatever holds it: its torque is not known then.
    known = rows.sliding | np.array([not family for family in chosen])
    still = ~known.any(axis=0)
    if still.any():
        raise InputError(f'{JOINT_NAMES[int(np.argmax(still))]} does not move in these runs; '
                         'record one that moves every joint')
    x = np.concatenate([rows.inertial[..., base.columns], columns], axis=-1)
    return _Fit(least_squares(x, rows.effort, known, block), friction)


def _determined(estimate: Estimate, base: BaseParameters, arm: ArmParameters) -> np.ndarray:
    """Return which base parameters the motion determines, better than to their typical size."""
    count = len(base.columns)
    typical = np.abs(base.combination) @ typical_sizes(arm)
    determined = estimate.determined[:count] & (estimate.error[:count] < typical)
    if determined.mean() < LEAST:
        lost = [name for name, known in zip(base.names, determined, strict=True) if not known]
        raise InputError(
            f'these runs excite {determined.sum()} of {count} base parameters, too few to tell '
            f'the parameters apart; not excited: {", ".join(lost)}; record the experiment '
            'exciting, or one made by ur5 excite')
    return determined


def _families(rows: Rows, base: BaseParameters, features: np.ndarray, fit: _Fit,
              block: np.ndarray) -> list[Family]:
    """Return the family of friction of each joint, from what the rigid arm leaves."""
    count = len(base.columns)
    left = rows.effort - rows.inertial[..., base.columns] @ fit.estimate.value[:count]
    wrong = left - _friction_torque(features, fit)
    if np.abs(wrong[rows.sliding]).max(initial=0.0) < ROUNDING * np.abs(rows.effort).max():
        return [Family(_BOTH, 0.0, 0.0, 0.0)] * 6
    families = []
    for i in range(6):
        use = rows.sliding[:, i]
        part = np.unique(block[use], return_inverse=True)[1]
        families.append(choose_family(features[use, i], np.zeros((use.sum(), 0)), left[use, i],
                                      folds_of(part)))
    return families


def _information(factor: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Return the square root of what is known of some parameters alone, (k, k)."""
    others = np.setdiff1d(np.arange(factor.shape[1]), keep)
    square = np.zeros((factor.shape[1],) * 2)
    triangle = np.asarray(np.linalg.qr(
        np.vstack([factor[:, [*others, *keep]], square]), mode='r'))
    return triangle[-len(keep):, -len(keep):]


def _by_joint(linear: _Fit) -> list[np.ndarray]:
    """Return viscous friction, its error, Coulomb friction and its error, (6,) each."""
    start = len(linear.estimate.value) - 12
    value, error = linear.estimate.value[start:], linear.estimate.error[start:]
    return [value[:6], error[:6], value[6:], error[6:]]


def _arm_friction(found: _Solution, rows: Rows, motors: Motors | None) -> JointFriction:
    """Return the friction of each joint: of the torque, of the motors where that has none."""
    own = [family if family.features else None for family in found.families]
    torque = rows.effort - rows.inertial @ found.x - _by_temperature(rows, found.best)
    viscous, _, coulomb, _ = _by_joint(found.linear)
    if motors is None:
        return joint_friction_of(own, rows.friction, torque, rows.sliding, (viscous, coulomb))
    of_motors = motors.friction_torque(rows.effort, rows.current, rows.friction)
    families = [each or family for each, family in zip(own, motors.family, strict=True)]
    has = np.array([each is not None for each in own])
    linear = (np.where(has, viscous, motors.viscous), np.where(has, coulomb, motors.coulomb))
    return joint_friction_of(families, rows.friction, np.where(has, torque, of_motors),
                             rows.sliding, linear)


def _by_temperature(rows: Rows, fit: _Fit) -> np.ndarray:
    """Return the torque of friction that a joint has for being warmer than usual, (n, 6)."""
    part = np.zeros_like(rows.friction)
    part[..., TEMPERATURE:] = rows.friction[..., TEMPERATURE:]
    return _friction_torque(part, fit)


def _terms(fit: _Fit) -> tuple[dict[str, tuple[float, float]], ...]:
    start = len(fit.estimate.value) - len(fit.friction)
    terms: tuple[dict[str, tuple[float, float]], ...] = tuple({} for _ in range(6))
    for (joint, feature), value, error in zip(
            fit.friction, fit.estimate.value[start:], fit.estimate.error[start:], strict=True):
        terms[joint][FEATURES[feature]] = float(value), float(error)
    return terms


def _friction_torque(features: np.ndarray, fit: _Fit) -> np.ndarray:
    """Return the torque of friction of each window, shape (n, 6)."""
    torque = np.zeros(features.shape[:2])
    start = len(fit.estimate.value) - len(fit.friction)
    for (joint, feature), value in zip(fit.friction, fit.estimate.value[start:], strict=True):
        torque[:, joint] += value * features[:, joint, feature]
    return torque


def _predict(rows: Rows, base: BaseParameters, found: _Solution, run: str) -> Prediction:
    """Return how well the arm and the fit predict the torque of windows, three at a time."""
    fit = found.best
    friction = _friction_torque(rows.friction, fit)
    with_friction = np.isin(np.arange(6), [joint for joint, _ in fit.friction])
    value = fit.estimate.value[:len(base.columns)]
    predicted, fitted = rows.inertial @ found.x, rows.inertial[..., base.columns] @ value
    unknown = np.where(rows.sliding | ~with_friction, 0.0, np.nan)
    wrong, wrong_fit = (of_three(rows, rows.effort - torque - friction + unknown)
                        for torque in (predicted, fitted))
    known = np.isfinite(wrong)
    return Prediction(
        run, np.sqrt(np.mean(rows.effort**2, axis=0)), _rms(wrong),
        np.where(known.any(axis=0), np.abs(np.where(known, wrong, 0.0)).max(axis=0), np.nan),
        _rms(wrong_fit), {'time': rows.time, 'speed': rows.speed, 'torque': rows.effort,
                          'predicted': predicted + friction + unknown, 'error': wrong})


def _rms(values: np.ndarray) -> np.ndarray:
    """Return the root mean square of each column's numbers; NaN where it has none."""
    known = np.isfinite(values)
    square = np.sum(np.where(known, values, 0.0)**2, axis=0)
    count = known.sum(axis=0)
    return np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)


def _payload(run: Run | None, arm: ArmParameters, found: _Solution, motors: Motors | None):
    if run is None:
        return None
    rows = rows_of([run], arm)
    features = rows.friction
    expected = rows.inertial @ found.x + _friction_torque(features, found.best)
    if np.isnan(rows.current).all():
        motors = None
    return payload_from(rows, expected, features, motors, run.name)
