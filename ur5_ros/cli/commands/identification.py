"""The commands ``ur5 identify`` and ``ur5 excite``: inertia and friction of a recorded arm."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from ur5_ros.analysis.checks.effort import effort_check, no_torque_of_arm
from ur5_ros.analysis.checks.foreign import kinematics_check
from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.identification.arm_file import write_arm
from ur5_ros.analysis.identification.exciting.excitation import Excitation
from ur5_ros.analysis.identification.exciting.excitation import excite as find
from ur5_ros.analysis.identification.exciting.files import refuse_existing, write_excitation
from ur5_ros.analysis.identification.exciting.trial import trial_errors
from ur5_ros.analysis.identification.identify import Identified, identify_payload
from ur5_ros.analysis.identification.identify import identify as fit
from ur5_ros.analysis.identification.words import or_dash, unit_of, with_error
from ur5_ros.analysis.report.palette import SHORT_NAMES
from ur5_ros.analysis.result import FAIL
from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import SUCCESS
from ur5_ros.cli.json_file import write_json
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sweep.batch_validation import marks_of


def identify(runs: list[Path], out: Path | None, test: Path | None, payload: Path | None,
             arm: str | None, json: Path | None, html: Path | None,
             given: Mapping[str, Any]) -> int:
    """Fit the parameters of an arm; see ``ur5 identify --help``."""
    if out is not None and out.exists():
        raise InputError(f'{out} exists; give another file, or remove it')
    start = load_arm(arm) if arm is not None else None
    loaded = _read(payload, given, load=True) if payload is not None else None
    if not runs:
        return _payload_alone(loaded, start, json)
    tested = _read(test, given) if test is not None else None
    fitted = [_read(run, given) for run in runs]
    found = fit(fitted, start, tested, name=out.stem if out is not None else 'identified',
                payload=loaded)
    used = [*fitted, *(run for run in (tested, loaded) if run is not None)]
    _show(found, used)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_arm(found, out)
        print(f'written: {out}')
    if json is not None:
        write_json({**found.to_plain(), 'runs': _notes(used)}, json)
        print(f'written: {json}')
    if html is not None:
        from ur5_ros.analysis.report.identification import write_identification_html
        write_identification_html(found, html)
        print(f'written: {html}')
    if out is not None:
        terminal.show_next(terminal.console(), f'ur5 validate {runs[0]} --arm {out}',
                           'the run, judged with the arm that was found')
    else:
        terminal.show_next(terminal.console(), f'ur5 identify {runs[0]} -o arm.yaml',
                           'the same, with an arm file')
    return SUCCESS


def _read(path: Path, given: Mapping[str, Any], load: bool = False) -> Run:
    """Return a run whose effort is joint torque, or what ``--effort`` states; else InputError."""
    run = load_run(path, **given)
    motion = kinematics_check(run, marks_of()) if run.sim is None else None
    if motion is not None and motion.verdict == FAIL:
        raise InputError(f'{run.name}: {motion.sentence}; give a recording whose velocities are '
                         'those of its positions')
    effort = effort_check(run, marks_of()) if run.sim is None else None
    # a log's target torque that is gravity alone shows a load as it is
    gravity = load and run.follows_reference and effort is not None and (
        effort.details.get('meaning') == 'target')
    if effort is not None and effort.verdict == FAIL and not gravity:
        raise InputError(f'{run.name}: {effort.sentence}')
    if effort is not None and not load and (reason := no_torque_of_arm(run, effort)):
        raise InputError(f'{run.name}: {reason}')
    return run


def excite(out: Path, arm: str, seconds: float, budget: float, acceleration: float,
           clearance: float, seed: int, json: Path | None) -> int:
    """Find an excitation trajectory; see ``ur5 excite --help``."""
    if out.suffix not in ('.yaml', '.yml'):
        raise InputError(f'{out}: an experiment is a YAML file; give a name that ends in .yaml')
    refuse_existing(out)
    record = load_arm(arm)
    with terminal.progress(f'exciting {record.name}', budget, 's') as advance:
        found = find(record, seconds, budget, acceleration=acceleration, clearance=clearance,
                     seed=seed, progress=lambda share: advance(share * budget))
    error, away = trial_errors(found, record)
    trajectory = write_excitation(found.experiment, out)
    _show_excitation(found, error, away)
    print(f'written: {out}, {trajectory}')
    if json is not None:
        write_json({
            'format': 'ur5_ros excitation', 'version': 1, 'arm': record.name,
            'condition': found.condition, 'condition_raw': found.condition_raw,
            'series_tried': found.tried,
            'noise': found.noise.tolist(), 'parameters': {name: {
                'predicted_error': predicted, 'fit_error': own, 'away': far}
                for name, predicted, own, far in zip(
                    found.names, found.error.tolist(), error.tolist(), away.tolist(),
                    strict=True)}}, json)
        print(f'written: {json}')
    return SUCCESS


def _show_excitation(found: Excitation, error: np.ndarray, away: np.ndarray) -> None:
    screen = terminal.console()
    table = Table('parameter', 'predicted error', 'in a trial', 'from truth', 'unit',
                  box=None, pad_edge=False, header_style='bold')
    for name, *numbers in zip(found.names, found.error, error, away, strict=True):
        table.add_row(Text(name), *(f'{number:.2g}' for number in numbers), unit_of(name))
    screen.print(table)
    terminal.show_text(screen, (
        f'condition number {found.condition:.4g} (columns as they are: '
        f'{found.condition_raw:.4g}) after {found.tried} series; errors for torque '
        f'noise of {", ".join(f"{x:.3g}" for x in found.noise)} N m a sample at 100 Hz; the '
        'trial is a fit to a recording of this motion with such noise'))


def _payload_alone(loaded: Run | None, arm: ArmParameters | None, json: Path | None) -> int:
    if loaded is None:
        raise InputError('no run given; give one or more, or --payload RUN')
    found = identify_payload(loaded, arm)
    terminal.show_text(terminal.console(), found.sentence())
    terminal.show_notes(terminal.console(), loaded)
    if json is not None:
        write_json({'format': 'ur5_ros identification', 'version': 1,
                    'payload': found.to_plain(), 'runs': _notes([loaded])}, json)
        print(f'written: {json}')
    return SUCCESS


def _notes(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return how much of each run was used, and what was passed over, assumed or is missing."""
    return [{'run': run.name, 'states': len(run.stamp),
             'dropped': 0 if run.dropped is None else len(run.dropped),
             'notes': [*run.problems, *run.remarks]} for run in runs]


def _show(found: Identified, used: Sequence[Run]) -> None:
    screen = terminal.console()
    base = Table('base parameter', 'value', 'unit',
                  box=None, pad_edge=False, header_style='bold')
    for name, (value, error) in found.base.items():
        base.add_row(Text(name), with_error(value, error), unit_of(name))
    screen.print(base)
    joints = Table('joint', 'viscous\n[N m s/rad]', 'Coulomb\n[N m]', 'torque RMS\n[N m]',
                   'error RMS\n[N m]', 'largest error\n[N m]', box=None, pad_edge=False,
                   header_style='bold')
    for i, name in enumerate(SHORT_NAMES):
        joints.add_row(name, with_error(found.viscous[i], found.viscous_error[i]),
                       with_error(found.coulomb[i], found.coulomb_error[i]),
                       *(or_dash(column[i]) for column in (
                           found.torque_rms, found.test_rms, found.test_max)))
    screen.print(joints)
    for sentence in found.sentences():
        terminal.show_text(screen, sentence)
    for run in used:
        terminal.show_notes(screen, run)
