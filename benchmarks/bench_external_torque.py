"""Contact on recordings of a real UR10e: pushes are found, free motion raises no alarm."""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench_identification import FITTED, TRIED, csv_run
from side_by_side import Row, arguments, publish

from ur5_ros.analysis.checks.contact_likely import contact_likely
from ur5_ros.analysis.data.run import NodeRecord, Run
from ur5_ros.analysis.identification.arm_file import write_arm
from ur5_ros.analysis.identification.identify import identify
from ur5_ros.analysis.result import Check
from ur5_ros.config import load_arm
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters, with_payload

#: Recordings with a load: the one that it is found on, and the one of the same load.
LOADED, SAME_LOAD = 'ur-20_02_19_14harm50secLoad.csv', 'ur-20_01_31-load.csv'
UNLOADED = 'ur-20_02_19_14harm50sec.csv'


def judged(run: Run, arm: ArmParameters) -> Check:
    """Return the check of a recording with an arm."""
    record = NodeRecord(arm.name, arm, {'mode': 'unknown'})
    return contact_likely(replace(run, control=record))[0][0]


def identified(runs: dict[str, Run], folder: Path) -> ArmParameters:
    """Return the arm of three free recordings, its marks from a fourth, as its file has it."""
    found = identify([runs[name] for name in FITTED], load_arm('ur10e'), runs[TRIED],
                     name='ur10e_identified')
    write_arm(found, folder / 'arm.yaml')
    return load_arm(str(folder / 'arm.yaml'))


def readable(folder: Path) -> dict[str, Run]:
    """Return the recordings of the data set that have all columns, by name."""
    runs = {}
    for path in sorted(folder.rglob('*.csv')):
        try:
            runs[path.name] = csv_run(path)
        except (IndexError, InputError):  # 19 columns in two files
            continue
    return runs


def rows_of(folder: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return the rows of the data set ``dataset_ur10e``."""
    runs = readable(folder)
    with tempfile.TemporaryDirectory() as place:
        arm = identified(runs, Path(place))
    checks = {name: judged(run, arm) for name, run in runs.items() if name not in FITTED}
    pushed = {name: check for name, check in checks.items() if 'push' in name}
    loaded = {name: check for name, check in checks.items() if 'load' in name.lower()
              and 'unload' not in name}
    free = {name: check for name, check in checks.items()
            if name not in pushed and name not in loaded and name != TRIED}
    load = identify([runs[UNLOADED]], arm, payload=runs[LOADED]).payload
    assert load is not None
    declared = judged(runs[SAME_LOAD], with_payload(arm, load.mass, load.com))
    rows = [
        *(Row(f'{name}, largest torque that lasts', 'its mark', check.value, 1.0, True,
              check.sentence) for name, check in pushed.items()),
        Row(f'{len(free)} free recordings, the largest', 'its mark',
            max(check.value for check in free.values()), 1.0, False,
            max(free, key=lambda name: free[name].value)),
        Row(f'{SAME_LOAD}, load not declared', 'its mark', loaded[SAME_LOAD].value, 1.0, True),
        Row(f'{SAME_LOAD}, load of {LOADED} declared', 'its mark', declared.value, 1.0, False,
            f'{load.mass:.3f} kg')]
    return rows, {'ur10e': {name: {'value': check.value, 'sentence': check.sentence}
                            for name, check in checks.items()},
                  'unexplained_torque': arm.unexplained_torque.tolist(),
                  'torque_constant': arm.torque_constant.tolist()}


def main() -> None:
    """Judge the recordings and keep the table."""
    options = arguments(__doc__, 1)
    options.add_argument('--ur10e', type=Path, help='folder dataset_ur10e of the recordings')
    given = options.parse_args()
    if given.ur10e is None:
        print('give --ur10e FOLDER: dataset_ur10e of github.com/shamilmamedov/dynamic_calibration')
        return
    rows, more = rows_of(given.ur10e)
    publish('external_torque', 'External torque on a real robot', rows, more, keep=not given.quick)


if __name__ == '__main__':
    main()
