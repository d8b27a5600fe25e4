"""Recordings of real robots, each through the commands: an arm that moves, or one line."""

import contextlib
import io
import json
import re
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from side_by_side import Row, arguments, publish

from ur5_ros.analysis.identification.inertia import pseudo_inertia
from ur5_ros.cli.run import run
from ur5_ros.config import load_arm
from ur5_ros.config.validation import load_marks
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.regressor import inertial_parameters

#: Columns of the recordings of the UR10e, which have no names.
UR10E_COLUMNS = 'timestamp,actual_q,actual_qd,actual_current,' + '-,' * 6 + 'target_moment'

#: Length of the simulation with an identified arm [s], its rate [Hz], and the largest joint error
#: of an arm that moves as an arm [rad].
SECONDS, RATE, FOLLOWS = 10.0, 500, 0.02


class Source(NamedTuple):
    """Recordings of one robot."""

    option: str
    what: str
    pattern: str
    arm: str
    columns: str = ''


SOURCES = (
    Source('ur5', 'folder of the UR5 logs', '*.csv.gz', 'ur5_controller'),
    Source('ur10e', 'folder dataset_ur10e', '*.csv', 'ur10e_controller', UR10E_COLUMNS),
    Source('ur-rtde', 'folder of ur_rtde logs of a UR5e', '*.csv', 'ur5e'),
    Source('ur10', 'folder of the bag ur10_exciting_trajectory.db3', '*.db3', 'ur10'))


def command(*words: object) -> tuple[int, str]:
    """Return the exit code of a command and its complaint, empty where it has none."""
    error = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(error):
        code = run([str(word) for word in words])
    return code, error.getvalue().strip() if code else ''


def tried(path: Path, source: Source, folder: Path) -> dict[str, Any]:
    """Return how one recording fares: import, verdict, identification, and the arm of it."""
    found = tried_in(path, source, folder)
    lines = [line.replace(f'{path.parent}/', '').replace(f'{folder}/', '')
             for line in found['lines']]
    return found | {'lines': lines}


def tried_in(path: Path, source: Source, folder: Path) -> dict[str, Any]:
    """Return how one recording fares, complaints with the folders of this run in them."""
    found: dict[str, Any] = {'robot': source.option, 'lines': []}
    options: tuple[object, ...] = ('--arm', source.arm)
    place = path
    if path.suffix != '.db3':
        place = folder / path.name.partition('.')[0]
        columns = ('--columns', source.columns) if source.columns else ()
        code, line = command('import', path, '--out', place, *options, *columns)
        if code:
            return found | {'code': code, 'lines': [line]}
        options = ()
    found |= judged(place, options, folder)
    file = folder / f'{place.stem}_arm.yaml'
    found['code'], line = command('identify', place, *options, '-o', file)
    found['lines'].append(line)
    way_out = re.search(r'give --effort (\w+)', line)
    if found['code'] and way_out:
        found['code'], line = command('identify', place, *options, '-o', file, '--effort',
                                      way_out[1])
        found |= {'effort': way_out[1], 'lines': [*found['lines'], line]}
    return found | (moved(file) if file.exists() else {})


def judged(place: Path, options: tuple[object, ...], folder: Path) -> dict[str, Any]:
    """Return the figures of the checks whose marks come from such recordings."""
    file = folder / 'judged.json'
    file.unlink(missing_ok=True)
    code, line = command('validate', place, *options, '--json', file)
    if not file.exists():
        return {'validate': code, 'lines': [line]}
    checks = {check['name']: check for check in json.loads(file.read_text())['checks']}
    figures = {name: checks[name]['value'] for name in ('kinematics', 'effort')}
    misfits = checks['effort'].get('details', {}).get('misfits', {})
    return {'validate': code, **figures, 'misfits': misfits}


def moved(file: Path) -> dict[str, Any]:
    """Return whether an arm file loads, is one of bodies, and moves in the simulator."""
    arm = load_arm(str(file))
    bodies = inertial_parameters(arm).reshape(6, 10)
    least = min(float(np.linalg.eigvalsh(pseudo_inertia(body))[0] / body[0]) for body in bodies)
    simulated = as_run(run_closed_loop(run_config(
        'multi_sine', str(file), control_arm=str(file), control_rate=RATE, duration=SECONDS)))
    error = simulated.states.q - simulated.required_reference.q
    return {'least_pseudo_inertia': least, 'tracking_error': float(np.abs(error).max())}


def rows_of(found: dict[str, dict[str, Any]]) -> list[Row]:
    """Return the figures of all recordings."""
    arms = {name: each for name, each in found.items() if 'tracking_error' in each}
    ended = [each['code'] in (0, 2) and all('\n' not in line for line in each['lines'])
             for each in found.values()]
    good = [each['least_pseudo_inertia'] > 0.0 and each['tracking_error'] < FOLLOWS
            for each in arms.values()]
    marks = load_marks()
    largest = max((name for name in found if found[name].get('kinematics') is not None),
                  key=lambda name: found[name]['kinematics'])
    return [
        Row('recordings that end in an arm or one line', f'{len(found)} recordings',
            float(np.mean(ended)), 1.0, True,
            f'{len(arms)} arms, {len(found) - len(arms)} times one line'),
        Row('arms that load, have positive pseudo-inertias and follow a motion for '
            f'{SECONDS:g} s', f'{len(arms)} arms', float(np.mean(good)) if good else 0.0, 1.0,
            True, f'joint error up to {max(each["tracking_error"] for each in arms.values()):.1g} '
            'rad' if arms else ''),
        Row('kinematics, the largest', 'its mark',
            found[largest]['kinematics'] / marks['kinematics'], 1.0, False,
            f'{found[largest]["kinematics"]:.3f}, {largest}'),
        *_effort_rows(arms, marks['effort'])]


def _effort_rows(arms: dict[str, dict[str, Any]], mark: float) -> list[Row]:
    """Return what the right meaning of the effort leaves, and the next one: target torque."""
    misfits = {name: each['misfits'] for name, each in arms.items()
               if each['robot'] in ('ur5', 'ur10e')}
    if not misfits:
        return []
    right = max(misfits, key=lambda name: misfits[name]['total'])
    least = {name: min(value for meaning, value in each.items()
                       if meaning not in ('total', 'current')) for name, each in misfits.items()}
    wrong = min(least, key=least.__getitem__)
    most = misfits[right]['total']
    return [Row('effort, most that joint torque leaves', 'its mark', most / mark, 1.0, False,
                f'{most:.3f}, {right}'),
            Row('effort, least that another meaning leaves', 'its mark', least[wrong] / mark, 1.0,
                True, f'{least[wrong]:.3f}, {wrong}')]


def made(folder: Path) -> Path:
    """Return a folder with a log of a simulated arm, as ur_rtde writes it."""
    simulated = as_run(run_closed_loop(run_config('exciting', 'ur5e', control_rate=125,
                                                  duration=12.0)))
    names = ['timestamp', *(f'{name}_{i}' for name in ('actual_q', 'actual_qd', 'target_moment')
                            for i in range(6))]
    np.savetxt(folder / 'simulated.csv', np.column_stack([simulated.t, *simulated.states]),
               delimiter=',', header=','.join(names), comments='')
    return folder


def main() -> None:
    """Try every recording and keep the table."""
    options = arguments(__doc__, 1)
    for source in SOURCES:
        options.add_argument(f'--{source.option}', type=Path, help=source.what)
    given = options.parse_args()
    found = {}
    with tempfile.TemporaryDirectory() as place:
        folders = {source: getattr(given, source.option.replace('-', '_')) for source in SOURCES}
        if given.quick:
            (Path(place) / 'made').mkdir()
            folders = {SOURCES[2]: made(Path(place) / 'made')}
        for source, folder in folders.items():
            for path in sorted(folder.rglob(source.pattern)) if folder is not None else ():
                found[path.name] = tried(path, source, Path(place))
                print(path.name, found[path.name], flush=True)
    if not found:
        print(f'give folders of recordings: {", ".join(f"--{each.option}" for each in SOURCES)}')
        return
    publish('real_recordings', 'Recordings of real robots, each by itself', rows_of(found),
            {'recordings': found}, keep=not given.quick)


if __name__ == '__main__':
    main()
