"""Figures that an experiment names: expected value, tolerance, and what the run gave."""

from collections.abc import Callable

import numpy as np

from ur5_ros.analysis.checks.contact import tool_force
from ur5_ros.analysis.checks.friction_allowance import friction_allowance
from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.config.experiments import Figure, load_experiment
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics

_AXES = 'xyz'


def experiment_checks(run: Run) -> list[Check]:
    """
    Return one check for every figure that the run's experiment names.

    ``run``: the recording; its time 0 is that of the experiment.
    """
    name = run.control.parameters.get('experiment', '') if run.control else ''
    if not name or run.sim is None:
        return []
    try:
        figures = load_experiment(name).figures
    except InputError:  # the file was on another machine
        return []
    return [_check(run, figure) for figure in figures]


def _check(run: Run, figure: Figure) -> Check:
    begin, end = figure.window
    rows = np.flatnonzero((run.t >= begin) & (run.t <= end))
    if len(rows) < 2 or run.t[-1] < end:
        return not_applicable(figure.name, f'the run ends before {end:g} s')
    if figure.quantity in _TOUCHING and run.contact is None:
        return not_applicable(figure.name, 'the run has no world')
    value = _QUANTITIES[figure.quantity](run, rows, figure)
    if value is None:
        return not_applicable(figure.name, f'nothing was recorded of it between {begin:g} s and '
                              f'{end:g} s')
    unit = _UNITS[figure.quantity]
    force = _force(run, rows) if figure.quantity in _TOUCHING else np.zeros(3)
    more = friction_allowance(run, rows, figure, value, force)
    sentence = f'{value:.6g} {unit}, expected {figure.expected:g} within {figure.tolerance:g}'
    if more:
        sentence += f' and {more:.3g} that friction of joints at rest may hold'
    return judge(figure.name, abs(value - figure.expected), figure.tolerance + more, unit,
                 sentence, figure=value, expected=figure.expected, friction_allowance=more)


def _force(run: Run, rows: np.ndarray) -> np.ndarray:
    return tool_force(run)[rows, :3].mean(axis=0)


def _normal_force(run: Run, rows: np.ndarray, figure: Figure) -> float:
    return abs(float(_force(run, rows)[_AXES.index(figure.axis)]))


def _friction_ratio(run: Run, rows: np.ndarray, figure: Figure) -> float | None:
    force = tool_force(run)[rows, :3]
    normal = force[:, _AXES.index(figure.axis)]
    lateral = np.linalg.norm(np.delete(force, _AXES.index(figure.axis), axis=1), axis=1)
    return float(lateral.mean() / np.abs(normal).mean()) if normal.any() else None


def _stiffness(run: Run, rows: np.ndarray, figure: Figure) -> float | None:
    axis = _AXES.index(figure.axis)
    if run.reference is None:
        return None
    # the force up to a state answers the state before it
    deflection = (_positions(run, run.exact.q[rows - 1])
                  - _positions(run, run.reference.q[rows - 1]))[:, axis].mean()
    return float(_force(run, rows)[axis] / deflection) if deflection else None


def _tool_travel(run: Run, rows: np.ndarray, figure: Figure) -> float:
    first, last = _positions(run, run.exact.q[rows[[0, -1]]])
    return float(np.linalg.norm(last - first))


def _tool_position(run: Run, rows: np.ndarray, figure: Figure) -> float:
    return float(_positions(run, run.exact.q[rows])[:, _AXES.index(figure.axis)].mean())


def _touch_speed(run: Run, rows: np.ndarray, figure: Figure) -> float | None:
    touched = np.flatnonzero(run.required_contact[rows].any(axis=(1, 2)))
    if not len(touched) or rows[touched[0]] < 2:
        return None
    before, at = _positions(run, run.exact.q[rows[touched[0]] - np.array([2, 1])])
    return float(np.linalg.norm(at - before)) * run.control_rate


def _object_travel(run: Run, rows: np.ndarray, figure: Figure) -> float | None:
    names = [body.name for body in run.required_sim.world.bodies if body.free]
    first, last = run.stamp[rows[0]], run.stamp[rows[-1]]
    seen = [poses for stamp, poses in run.objects if first <= stamp <= last]
    if len(seen) < 2 or figure.body not in names:
        return None
    at = names.index(figure.body)
    return float(np.linalg.norm(seen[-1][at, :3] - seen[0][at, :3]))


def _positions(run: Run, q: np.ndarray) -> np.ndarray:
    """Return where the tool is in base [m], shape (n, 3)."""
    arm = run.required_sim.arm
    return forward_kinematics(q + arm.angle_offset, arm)[:, :3, 3]


_QUANTITIES: dict[str, Callable[[Run, np.ndarray, Figure], float | None]] = {
    'normal_force': _normal_force, 'friction_ratio': _friction_ratio, 'stiffness': _stiffness,
    'tool_travel': _tool_travel, 'tool_position': _tool_position, 'touch_speed': _touch_speed,
    'object_travel': _object_travel}
_UNITS = {'normal_force': 'N', 'friction_ratio': '1', 'stiffness': 'N/m', 'tool_travel': 'm',
          'tool_position': 'm', 'touch_speed': 'm/s', 'object_travel': 'm'}
_TOUCHING = ('normal_force', 'friction_ratio', 'stiffness', 'touch_speed')
