"""Identification: inertial parameters and friction from recorded torques, with errors."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.identification.base_parameters import (
    BaseParameters,
    all_parameters,
    base_of,
)
from ur5_ros.analysis.identification.drives import drives_alone
from ur5_ros.analysis.identification.fitting import Fit, Solution, fit_linear, solve
from ur5_ros.analysis.identification.friction.families import TEMPERATURE
from ur5_ros.analysis.identification.friction.joint_friction import joint_friction_of
from ur5_ros.analysis.identification.inertia import with_parameters
from ur5_ros.analysis.identification.least_squares import Estimate, blocks_of
from ur5_ros.analysis.identification.motors import Motors, motors_from, with_motors
from ur5_ros.analysis.identification.payload import PayloadEstimate, payload_from
from ur5_ros.analysis.identification.prediction import predict
from ur5_ros.analysis.identification.result import Identified
from ur5_ros.analysis.identification.rows import Rows, last_fifth, rows_of
from ur5_ros.analysis.identification.samples import has_currents_alone
from ur5_ros.analysis.identification.simulation_gate import simulate
from ur5_ros.analysis.validate import no_arm
from ur5_ros.errors import InputError
from ur5_ros.model.friction import JointFriction
from ur5_ros.model.parameters import ArmParameters

__all__ = ['Identified', 'base_of', 'identify', 'identify_payload']


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
    found = solve(rows, base, arm)
    if test is None:
        kept, tried = last_fifth(rows)
        tested, tried_name = solve(kept, base, arm), f'the last fifth of {runs[0].name}'
    else:
        tested, tried, tried_name = found, rows_of([test], arm), test.name
    motors = motors_from(rows.effort, rows.current, rows.friction, rows.sliding,
                         blocks_of(rows.time, rows.run),
                         (tried.effort, tried.current, tried.friction), tried_name)
    bodies, largest_error = _bodies(arm, found, name)
    viscous, viscous_error, coulomb, coulomb_error = found.linear_friction()
    parameters, not_excited, covariance = _base_values(found, base)
    return Identified(
        arm=with_motors(replace(bodies, friction=_arm_friction(found, rows, motors)), motors,
                        runs[0] if test is None else test),
        base=parameters, not_excited=not_excited, covariance=covariance,
        viscous=viscous, viscous_error=viscous_error, coulomb=coulomb,
        coulomb_error=coulomb_error, family=found.families,
        terms=found.best.friction_terms(), condition=found.best.estimate.condition,
        moved=_moved(found, base),
        train=predict(rows, base, found, ', '.join(run.name for run in runs)),
        test=predict(tried, base, tested, tried_name), motors=motors,
        payload=_payload(payload, arm, found, motors), simulated=largest_error)


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
    return fit_linear(rows_of(runs, arm), base_of(arm)).estimate


def arm_of(run: Run) -> ArmParameters:
    """Return the arm that a run names: the law's, else the plant's."""
    record = run.law_record
    if record is None:
        raise InputError(no_arm(run))
    return record.arm


def _bodies(arm: ArmParameters, found: Solution, name: str) -> tuple[ArmParameters, float]:
    """Return the physical arm, and its largest tracking error in a simulation [rad]."""
    bodies = with_parameters(arm, found.x, name)
    largest_error = simulate(bodies)
    if not np.isfinite(largest_error):
        raise InputError('the identified arm does not move as an arm in simulation; give another '
                         '--arm to begin with')
    return bodies, largest_error


def _base_values(found: Solution, base: BaseParameters) -> tuple[
        dict[str, tuple[float, float]], tuple[str, ...], np.ndarray]:
    """Return name -> value and error of what is excited, names of the rest, and covariance."""
    keep, names = found.determined, np.array(base.names)
    values = zip(found.best.base[keep].tolist(), found.best.base_error[keep].tolist(),
                 strict=True)
    count = len(base.columns)
    covariance = found.best.estimate.covariance[:count, :count][np.ix_(keep, keep)]
    return dict(zip(names[keep].tolist(), values, strict=True)), tuple(
        names[~keep].tolist()), covariance


def _moved(found: Solution, base: BaseParameters) -> float:
    """Return how far the physical parameters are from the fit, in its standard errors."""
    away = np.abs(base.combination @ found.x - found.best.base)
    sigma = away / np.maximum(found.best.base_error, 1e-9)
    return float(np.max(sigma[found.determined], initial=0.0))


def _arm_friction(found: Solution, rows: Rows, motors: Motors | None) -> JointFriction:
    """Return the friction of each joint: of the torque, of the motors where that has none."""
    own = [family if family.features else None for family in found.families]
    torque = rows.effort - rows.inertial @ found.x - _by_temperature(rows, found.best)
    viscous, _, coulomb, _ = found.linear_friction()
    if motors is None:
        return joint_friction_of(own, rows.friction, torque, rows.sliding, (viscous, coulomb))
    of_motors = motors.friction_torque(rows.effort, rows.current, rows.friction)
    families = [each or family for each, family in zip(own, motors.family, strict=True)]
    has = np.array([each is not None for each in own])
    linear = (np.where(has, viscous, motors.viscous), np.where(has, coulomb, motors.coulomb))
    return joint_friction_of(families, rows.friction, np.where(has, torque, of_motors),
                             rows.sliding, linear)


def _by_temperature(rows: Rows, fit: Fit) -> np.ndarray:
    """Return the torque of friction that a joint has for being warmer than usual, (n, 6)."""
    part = np.zeros_like(rows.friction)
    part[..., TEMPERATURE:] = rows.friction[..., TEMPERATURE:]
    return fit.friction_torque(part)


def _payload(run: Run | None, arm: ArmParameters, found: Solution,
             motors: Motors | None) -> PayloadEstimate | None:
    """Return the load at the tool of a run, None without one."""
    if run is None:
        return None
    rows = rows_of([run], arm)
    expected = rows.inertial @ found.x + found.best.friction_torque(rows.friction)
    if np.isnan(rows.current).all():
        motors = None
    return payload_from(rows, expected, rows.friction, motors, run.name)
