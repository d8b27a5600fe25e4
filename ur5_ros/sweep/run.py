"""One run of a sweep, from its few values to its row in the table."""

import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.result import FAIL, PASS, Result
from ur5_ros.analysis.validate import validate
from ur5_ros.control.settings import settings_from
from ur5_ros.errors import InputError
from ur5_ros.launcher.two_nodes import run_two_nodes
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import RunConfig, arm_named, run_config
from ur5_ros.sim.limits import check_initial_state
from ur5_ros.sweep.batch_validation import marks_of
from ur5_ros.sweep.spec import RunSpec, SweepSpec, altered
from ur5_ros.sweep.units import quantity

#: Keys of a specification besides ``sim.<parameter>`` and ``control.<parameter>``.
SPEC_KEYS = {
    'experiment': 'a name', 'arm': 'a name', 'control_arm': 'a name',
    'duration': 'a number of seconds above zero', 'control_rate': 'a whole number',
    'physics_rate': 'a whole number', 'initial_error': 'one number or six',
}

#: What a sweep decides itself, and the key to give instead.
SWEEP_DECIDES = {
    'sim.arm': 'arm', 'control.arm': 'control_arm', 'control.experiment': 'experiment',
    'sim.stop_after': 'duration', 'sim.control_rate': 'control_rate',
    'sim.physics_rate': 'physics_rate', 'sim.bag': 'keep', 'control.bag': 'keep',
    'sim.gui': 'nothing',
}

#: Largest joint error beyond which a run counts as diverged [rad].
DIVERGED_ERROR = math.pi

#: Numbers of every run, beside the validator's checks.
METRICS = ('max_error', 'rms_error', 'final_error', 'max_torque', 'max_speed')


def config_of(spec: SweepSpec, run: RunSpec) -> RunConfig:
    """Return the parameters of one run."""
    values = {'experiment': spec.experiment, 'duration': spec.duration, **spec.fixed, **run.values}
    sides: dict[str, dict[str, Any]] = {'sim': {'seed': (spec.seed + run.number) % 2**31},
                                        'control': {}}
    rest: dict[str, Any] = {}
    for key, value in values.items():
        if key in SWEEP_DECIDES:
            raise InputError(f'{key} is not for a sweep; give {SWEEP_DECIDES[key]} instead')
        side, _, name = key.partition('.')
        if name and side in sides:
            sides[side][name] = value
        elif key in SPEC_KEYS:
            rest[key] = _value(key, value, run)
        else:
            raise InputError(f'unknown key {key!r}; give sim.<parameter>, control.<parameter> '
                             f'or one of: {", ".join(SPEC_KEYS)}')
    try:
        config = run_config(**rest, sim=sides['sim'], control=sides['control'])
        rate = config.sim.control_rate
        settings_from(config.control, arm_named(config.control.arm), rate)
        check_initial_state(arm_named(config.sim.arm), config.sim.initial_positions)
        return config
    except InputError as refusal:
        values_text = ', '.join(f'{key} = {value}' for key, value in run.values.items())
        raise InputError(f'run {run.number} ({values_text}): {refusal}') from None


def _value(key: str, value: Any, run: RunSpec) -> Any:
    """Return a value of one of :data:`SPEC_KEYS`; refused if it is of another kind."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if SPEC_KEYS[key] == 'a name':
        good = isinstance(value, str)
    elif key == 'duration':
        good = value is None or (number and value > 0.0)
    elif key == 'initial_error':
        good = number or (isinstance(value, list) and len(value) == 6)
    else:
        good = number and value == round(value)
        value = round(value) if good else value
    if not good:
        raise InputError(f'run {run.number}: {key} is {value!r}; give {SPEC_KEYS[key]}')
    return value


def row_of(spec: SweepSpec, run: RunSpec, bags: Path | None) -> dict[str, Any]:
    """
    Run and judge one run.

    ``bags``: folder for the bags that are to be kept; none are if not given.  Returned: ``index``,
    the values, ``status`` (pass, fail, diverged or failed), ``success``, ``why``, the metrics, and
    verdict and value of every check.
    """
    config = config_of(spec, run)
    folder = bags / f'{run.number:06d}' if bags is not None else None
    by_nodes = spec.engine == 'nodes'
    try:
        if by_nodes:
            with TemporaryDirectory(prefix='ur5-sweep-') as away:
                measured = _judged(spec, _by_nodes(config, folder or Path(away) / 'run'))
        else:
            measured = _judged(spec, _by_loop(config, folder if spec.keep == 'all' else None))
    except (InputError, ArithmeticError, np.linalg.LinAlgError) as error:
        measured = {'status': 'failed', 'success': False, 'why': str(error)}
    if spec.keep == 'failures' and folder is not None:
        if by_nodes and measured['success']:
            rmtree(folder)
        elif not by_nodes and not measured['success']:
            _by_loop(config, folder)  # the same run again, to the bit
    return inputs_of(run) | measured


def inputs_of(run: RunSpec) -> dict[str, Any]:
    """Return the beginning of a run's row: its index and its values; lists as JSON text."""
    return {'index': run.number,
            **{key: json.dumps(value) if isinstance(value, list) else value
               for key, value in run.values.items()}}


def _by_loop(config: RunConfig, folder: Path | None) -> Run:
    return as_run(run_closed_loop(config, folder))


def _by_nodes(config: RunConfig, folder: Path) -> Run:
    from ur5_ros.analysis.data.load import load_run  # the bags are read here alone
    folder.mkdir(parents=True)
    run_two_nodes(config, folder, composed=True)
    return load_run(folder)


def _judged(spec: SweepSpec, run: Run) -> dict[str, Any]:
    metrics = metrics_of(run)
    if not metrics['max_error'] <= DIVERGED_ERROR:
        return {'status': 'diverged', 'success': False,
                'why': f'a joint is {metrics["max_error"]:.3g} rad from its reference',
                **metrics, 'states': digest(run)}
    row: dict[str, Any] = {**metrics, 'states': digest(run)}
    if spec.judge == 'checks':
        result = validate(run, marks_of())
        row |= _checks(result)
        failed = [check.sentence for check in result.checks if check.verdict == FAIL]
    missed = _missed(spec.success, row) if spec.success else failed
    return {'status': FAIL if missed else PASS, 'success': not missed,
            'why': '; '.join(missed), **row}


def metrics_of(run: Run) -> dict[str, float]:
    """Return the numbers of :data:`METRICS`, over all joints [rad, N m, rad/s]."""
    assert run.reference is not None, 'every run of a sweep follows a reference'
    error = run.exact.q - run.reference.q
    error = error[np.isfinite(error).all(axis=1)]
    size = np.abs(error)
    return {
        'max_error': float(size.max(initial=0.0)) if len(error) else math.nan,
        'rms_error': float(np.sqrt(np.mean(error**2))) if len(error) else math.nan,
        'final_error': float(size[-1].max()) if len(error) else math.nan,
        'max_torque': float(np.abs(run.exact.effort).max()),
        'max_speed': float(np.abs(run.exact.qd).max()),
    }


def check_success(spec: SweepSpec) -> None:
    """Refuse a condition on a number that no run has."""
    unknown = [name for name in spec.success if name not in METRICS]
    if not unknown:
        return
    columns: list[str] = []
    if spec.judge == 'checks':  # the checks know their names: ask them with a run of a moment
        row = _judged(altered(spec, success={}), _by_loop(run_config(duration=0.02), None))
        columns = [name.removesuffix(': value') for name in row if name.endswith(': value')]
    for name in unknown:
        if name not in columns:
            raise InputError(f'success: unknown column {name!r}; there are: '
                             f'{", ".join([*METRICS, *columns])}')


def digest(run: Run) -> str:
    """Return a SHA-256 over all states, equal if two runs are the same."""
    found = hashlib.sha256(run.stamp.astype('<i8').tobytes())
    for array in run.states:
        found.update(np.ascontiguousarray(array, dtype='<f8').tobytes())
    return found.hexdigest()


def _checks(result: Result) -> dict[str, Any]:
    row: dict[str, Any] = {'verdict': result.verdict}
    for check in result.checks:
        row[f'{check.name}: verdict'] = check.verdict
        row[f'{check.name}: value'] = check.value
    row['causes'] = '; '.join(str(cause.get('sentence', cause)) for cause in result.causes)
    return row


def _missed(success: Mapping[str, float], row: Mapping[str, Any]) -> list[str]:
    """Return the conditions that the run misses."""
    missed = []
    for name, limit in success.items():
        value = row.get(name, row.get(f'{name}: value'))
        if value is None or not value <= limit:
            found = 'not known' if value is None else quantity(name, value)
            missed.append(f'{name} is {found}, more than {quantity(name, limit)}')
    return missed

