"""Attribution: why checks of a run fail, as causes with size and error."""

from collections.abc import Sequence
from typing import Any

from ur5_ros.analysis.checks.controller import sampled_cause
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.diagnosis.command_path import path_causes
from ur5_ros.analysis.diagnosis.compensation import NAME, compensation_cause
from ur5_ros.analysis.diagnosis.contact import contact_cause
from ur5_ros.analysis.diagnosis.plant import plant_causes
from ur5_ros.analysis.result import FAIL, Check

#: Checks that need a cause in the plant, and between law and plant.
_PLANT = ('residual, controller arm', 'inverse dynamics')
_PATH = ('command acts', 'states on time', 'error step', 'error recursion', 'error continuous')


def causes(run: Run, checks: Sequence[Check], residual_limit: float = 0.0,
           ) -> list[dict[str, Any]]:
    """
    Return why checks fail, most certain first; empty where no failed check needs a cause.

    ``residual_limit`` is the mark of the residual [N m].

    """
    failed = {check.name for check in checks if check.verdict == FAIL}
    record = run.law_record
    if 'residual, simulator arm' in failed:
        missing = contact_cause(run, residual_limit)
        if missing is not None:
            return [missing]
    found: list[dict[str, Any]] = []
    moved = next((check for check in checks if check.name == 'kinematics'
                  and check.verdict == FAIL), None)
    if moved is not None:  # a torque of wrong velocities shows no cause in the plant
        return [{'kind': 'kinematics', 'sentence': f'{moved.sentence}; torques cannot be judged '
                 'with such velocities'}]
    meaning = next((check for check in checks if check.name == 'effort'
                    and check.verdict == FAIL), None)
    if meaning is not None:  # figures of another unit show no cause in the plant
        return [{'kind': 'effort meaning', 'meaning': meaning.details['meaning'],
                 'sentence': meaning.sentence}]
    sampled = sampled_cause(run, checks)
    if sampled is not None:
        found.append(sampled)
    if failed.intersection((*_PLANT, NAME)) and (cause := compensation_cause(run)):
        found.append(cause)
    if failed.intersection(_PATH):
        found += path_causes(run)
    if failed.intersection(_PLANT) and record is not None:
        plant = plant_causes(run, record.arm)
        if any(cause['kind'] == 'state delay' for cause in found):
            # Late states begin with copies of the first one, which no cause in the plant makes.
            plant = [cause for cause in plant if cause['kind'] != 'unexplained']
        found += plant
    return found
