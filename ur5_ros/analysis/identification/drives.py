"""Drives and friction from motor currents alone, the bodies of the arm taken as they are."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.identification.friction.families import Family
from ur5_ros.analysis.identification.friction.joint_friction import joint_friction_of
from ur5_ros.analysis.identification.least_squares import blocks_of
from ur5_ros.analysis.identification.motors import Motors, motors_from, with_motors
from ur5_ros.analysis.identification.payload import payload_from
from ur5_ros.analysis.identification.prediction import without_torque
from ur5_ros.analysis.identification.result import Identified
from ur5_ros.analysis.identification.rows import last_fifth, rows_of
from ur5_ros.analysis.identification.samples import has_currents_alone
from ur5_ros.analysis.identification.simulation_gate import simulate
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters

_NOTHING = Family((), 0.0, 0.0, 0.0)


def drives_alone(runs: Sequence[Run], arm: ArmParameters, test: Run | None, name: str,
                 payload: Run | None) -> Identified:
    """
    Fit drive gains and friction to motor currents where no torque is recorded.

    The torque is that of the arm on the measured motion; its gravity gives the scale.  Bodies and
    rotors stay those of the arm, and none of them is called identified.

    Raises
    ------
    InputError
        If some of the runs have torques, or no joint moves enough.

    """
    every = [*runs, *(run for run in (test, payload) if run is not None)]
    for run in every:
        if not has_currents_alone(run):
            raise InputError(f'{run.name}: has torques, and another run motor currents alone; '
                             'give runs of one kind')
    rows = rows_of(runs, arm)
    kept, tried = last_fifth(rows) if test is None else (rows, rows_of([test], arm))
    tried_name = f'the last fifth of {runs[0].name}' if test is None else test.name
    motors = motors_from(
        kept.effort, kept.current, kept.friction, kept.sliding, blocks_of(kept.time, kept.run),
        (tried.effort, tried.current, tried.friction), tried_name)
    if motors is None or not np.isfinite(motors.drive).any():
        raise InputError('no joint moves enough in these runs for its drive to be found; record '
                         'the experiment exciting, or one made by ur5 excite')
    friction = joint_friction_of(
        motors.family, kept.friction,
        motors.friction_torque(kept.effort, kept.current, kept.friction), kept.sliding,
        (motors.viscous, motors.coulomb))
    found = with_motors(replace(arm, name=name, friction=friction), motors, runs[0])
    return Identified(
        arm=found, base={}, not_excited=(), covariance=np.zeros((0, 0)), viscous=motors.viscous,
        viscous_error=motors.viscous_error, coulomb=motors.coulomb,
        coulomb_error=motors.coulomb_error, family=(_NOTHING,) * 6, terms=({},) * 6,
        condition=np.nan, moved=0.0, train=without_torque(kept, runs[0].name),
        test=without_torque(tried, tried_name), motors=motors,
        payload=_payload(payload, arm, motors), simulated=simulate(found))


def _payload(run: Run | None, arm: ArmParameters, motors: Motors):
    if run is None:
        return None
    rows = rows_of([run], arm)
    return payload_from(rows, rows.effort, rows.friction, motors, run.name)
