"""Judge a run: every check, in the order of the report."""

from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np

from ur5_ros.analysis.checks.contact import contact_checks
from ur5_ros.analysis.checks.controller import controller_checks
from ur5_ros.analysis.checks.effort import effort_check
from ur5_ros.analysis.checks.energy import energy_checks
from ur5_ros.analysis.checks.error_dynamics import law_checks
from ur5_ros.analysis.checks.experiment import experiment_checks
from ur5_ros.analysis.checks.foreign import kinematics_check
from ur5_ros.analysis.checks.gains import gains_check
from ur5_ros.analysis.checks.law import law_check
from ur5_ros.analysis.checks.limits import limits_check
from ur5_ros.analysis.checks.model import model_checks
from ur5_ros.analysis.checks.recording import (
    delays,
    pairing_check,
    recording_check,
    repeatability_check,
    timing_check,
)
from ur5_ros.analysis.compensation import robot_compensation
from ur5_ros.analysis.data.run import NodeRecord, Run
from ur5_ros.analysis.diagnosis.attribution import causes
from ur5_ros.analysis.diagnosis.command_path import lateness_check
from ur5_ros.analysis.diagnosis.company import company
from ur5_ros.analysis.diagnosis.compensation import compensation_check
from ur5_ros.analysis.effort.known_arms import LARGEST_MISFIT, arms_by_meaning, fitting_arms
from ur5_ros.analysis.injected import injections
from ur5_ros.analysis.result import FAIL, NOT_APPLICABLE, Check, Result
from ur5_ros.config.validation import Marks, load_marks
from ur5_ros.errors import InputError

#: Checks of the motion itself; without one of them no verdict can be a pass.
EVIDENCE = ('residual, controller arm', 'residual, simulator arm', 'inverse dynamics', 'law',
            'error step', 'error continuous', 'kinematics')


def validate(run: Run, marks: Marks | None = None) -> Result:
    """
    Judge a run.

    Parameters
    ----------
    run : Run
        What :func:`ur5_ros.analysis.data.load.load_run` read.
    marks : Marks, optional
        Pass marks; ``config/validation.yaml`` by default.

    Returns
    -------
    Result
        Checks with verdicts, numbers and sentences.

    Raises
    ------
    InputError
        If the recording contradicts itself, such as gains that make no stable loop.

    Examples
    --------
    >>> from ur5_ros import load_run, run_closed_loop, run_config, validate
    >>> _ = run_closed_loop(run_config('joint_step', duration=0.5), folder='judged')
    >>> result = validate(load_run('judged'))
    >>> result.verdict, result.passed
    ('pass', True)

    """
    marks = marks or load_marks()
    if run.law_record is None:
        raise InputError(no_arm(run))
    law, law_series = law_checks(run, marks)
    model, model_series = model_checks(run, marks)
    energy, energy_series = energy_checks(run, marks)
    contact, contact_series = contact_checks(run, marks)
    checks = [recording_check(run), pairing_check(run, marks), timing_check(run, marks),
              lateness_check(run), repeatability_check(run), *foreign_checks(run, marks), *model,
              law_check(run, marks), *law,
              gains_check(run, marks, law_series.get('dynamics')),
              *controller_checks(run, marks), limits_check(run), *energy, *contact,
              *experiment_checks(run)]
    if robot_compensation(run) is not None:
        checks.append(compensation_check(run))
    if not any(check.name in EVIDENCE and check.verdict != NOT_APPLICABLE for check in checks):
        checks.append(Check('evidence', FAIL, 'nothing in the recording says whether model and '
                            'plant agree: torques, commands, states or the arm are missing'))
    series = {'run': run, 'injected': injections(run), 'delays': delays(run), **law_series,
              **model_series, **energy_series, **contact_series}
    found = (*company(run, checks), *causes(run, checks, marks['residual']))
    return Result(run.name, about(run, marks), tuple(checks), found, series)


def foreign_checks(run: Run, marks: Marks) -> list[Check]:
    """Return the checks of a recording that is not of this package's simulator."""
    if run.sim is not None:
        return []
    return [kinematics_check(run, marks), effort_check(run, marks)]


def no_arm(run: Run) -> str:
    """Return what to do where no arm is known, with the known arms that fit the torques best."""
    sentence = f'{run.name}: no arm is known; give one: --arm NAME'
    if run.described_arm:
        return f'{sentence}; {run.described_arm}'
    if np.isnan(run.states.effort).all():
        return f'{sentence} (no torque is recorded, so no known arm can be compared)'
    fits = fitting_arms(run)
    if fits and min(fit.misfit for fit in fits) > LARGEST_MISFIT:
        other = [(name, each) for name, each in arms_by_meaning(run)[:3]
                 if each.misfit < LARGEST_MISFIT]
        if not other:
            return f'{sentence}; none of the known arms fits the effort as joint torque'
        listed = ', '.join(f'{name} ({each.misfit:.2%} of it stays unexplained as '
                           f'{each.words}: --effort {each.meaning})'
                           for name, each in other)
        return (f'{sentence}; none of the known arms fits the effort as joint torque, but with '
                f'another meaning: {listed}')
    listed = ', '.join(f'{fit.name} ({fit.rms:.3g} N m RMS unexplained)' for fit in fits[:3])
    return f'{sentence}; of the known arms these fit the torques best: {listed}' if fits \
        else sentence


def about(run: Run, marks: Marks) -> dict[str, Any]:
    """Return which run this is and what judged it."""
    return {
        'folder': run.folder,
        'ur5_ros': _version(),
        'marks': marks.name,
        'states': len(run.stamp),
        'remarks': list(run.remarks),
        'duration_s': float(run.t[-1]),
        'control_rate_hz': run.control_rate,
        'physics_rate_hz': run.physics_rate or None,
        'injected': [{'from_s': each.t, 'what': each.text} for each in injections(run)[:200]],
        'events': [{'stamp_s': event.stamp * 1e-9, 'kind': event.kind, 'message': event.message}
                   for event in run.events[:200]],
        'simulator': _node(run.sim),
        'controller': _node(run.control),
    }


@cache
def _version() -> str:
    """Return the version of what judges; to look it up takes a hundredth of a short run."""
    return version('ur5_ros')


def _node(record: NodeRecord | None) -> dict[str, Any] | None:
    if record is None:
        return None
    return {'arm': record.arm_name, 'parameters': dict(record.parameters),
            'changes': [{'after_s': change.stamp * 1e-9, **change.values}
                        for change in record.changes[:200]],
            'versions': dict(record.versions), 'summary': dict(record.summary)}
