"""The figures of the report as plain data, thinned so that the file stays small."""


from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import PARTS, Run
from ur5_ros.analysis.report.figure import Figure, packed
from ur5_ros.analysis.report.palette import AXIS_COLOURS, MEASURED, REFERENCE, SHORT_NAMES
from ur5_ros.analysis.report.palette import JOINT_COLOURS as COLOURS
from ur5_ros.analysis.report.palette import SERIES_COLOURS as SERIES
from ur5_ros.analysis.report.rounding import without_rounding
from ur5_ros.analysis.result import Result
from ur5_ros.signals import JOINT_NAMES

#: A curve is drawn through the least and the greatest value of each of so many pieces.
CURVE_PIECES = 360


def figures(result: Result) -> list[Figure]:
    """Return every figure that the result has the series for, in the order of the report."""
    series = result.series
    if 'run' not in series:
        return []
    found = []
    if 'tool' in series:
        found += _tool_figures(series)
    found += _joint_figures(series['run'])
    if 'dynamics' in series:
        found += _error_figures(series)
    elif 'tool' in series and series['run'].reference is not None:
        found.append(_error_figure(series['run']))
    found += _torque_figures(series) + _residual_figures(series)
    if 'smoothed' in series:
        t, unexplained_torque = series['smoothed']
        found.append(Figure(
            'smoothed', 'Torque that the arm does not explain', 'Recorded torque minus inverse '
            'dynamics, smoothed over blocks.',
            [curve(t, unexplained_torque[:, i], name, COLOURS[i])
             for i, name in enumerate(SHORT_NAMES)],
            'torque [N m]', wide=True))
    if 'surplus' in series:
        run = series['run']
        found.append(Figure(
            'energy', 'Energy balance', 'Energy that the arm gained minus work done on it; a '
            'passive arm keeps it at zero or below.',
            [curve(run.t[1:], series['surplus'], 'surplus', MEASURED)], 'energy [J]'))
    found += _contact_figures(series) + _timing_figures(series)
    return [without_rounding(figure) for figure in found]


def curve(t, values, name: str, colour: str, dash: str = 'solid', width: float = 1.6) -> dict:
    """
    Return a curve, thinned to its envelope.

    ``t``, ``values`` (n,): abscissa and ordinate; NaN makes a gap; ``dash``: ``solid``, ``dash``
    or ``dot``; ``width``: of the line [px].
    """
    rows = envelope(np.asarray(values, dtype=float))
    return {'type': 'scatter', 'mode': 'lines', 'name': name, 'x': packed(t[rows]),
            'y': packed(values[rows]),
            'line': {'color': colour, 'width': width, 'dash': dash}}


def envelope(values: np.ndarray, pieces: int = CURVE_PIECES) -> np.ndarray:
    """Return the rows of least and greatest value of each piece, in order; all where few."""
    n = len(values)
    if n <= 2 * pieces:
        return np.arange(n)
    size = -(-n // pieces)
    whole = n // size
    blocks = values[:whole * size].reshape(whole, size)
    first = np.arange(whole) * size
    low = first + np.argmin(np.where(np.isnan(blocks), np.inf, blocks), axis=1)
    high = first + np.argmax(np.where(np.isnan(blocks), -np.inf, blocks), axis=1)
    tail = np.arange(whole * size, n)
    if len(tail):
        rest = values[tail]
        tail = np.array([tail[0], tail[-1], tail[np.argmax(np.nan_to_num(rest, nan=-np.inf))]])
    return np.unique(np.concatenate([[0], low, high, tail, [n - 1]]))


def _tool_figures(series) -> list[Figure]:
    run, tool = series['run'], series['tool']
    t, known = run.t, bool(np.isfinite(tool.distance).any())
    found = [Figure(
        'path', 'Tool path from above', 'Position of the tool in the frame base, seen along z: '
        f'measured{" and reference" if known else ""}.',
        [*([path_trace(tool.desired_position, 'reference', REFERENCE, 'dot')] if known else ()),
         path_trace(tool.position, 'measured', MEASURED)],
        'y in base [m]', x='x in base [m]', first=True, equal=True)]
    if known:
        found.append(Figure(
            'pose_error', 'Tool error', 'Distance of the tool from its reference, and angle '
            'between them.',
            [curve(t, magnitudes(tool.distance * 1e3), 'position [mm]', MEASURED),
             curve(t, magnitudes(tool.angle * 1e3), 'orientation [mrad]', SERIES[1])],
            'error [mm, mrad]', log=True, first=True))
    for key, title, measured, desired, unit in (
            ('position', 'Tool position', tool.position, tool.desired_position, 'm'),
            ('orientation', 'Tool orientation', tool.orientation,
             tool.desired_orientation, 'rad')):
        names = 'xyz' if key == 'position' else ('rx', 'ry', 'rz')
        traces = []
        for i, name in enumerate(names):
            traces.append(curve(t, measured[:, i], name, AXIS_COLOURS[i]))
            if known:
                traces.append(curve(t, desired[:, i], f'{name}, reference', AXIS_COLOURS[i],
                                    'dot', 2.4))
        caption = ('Position of the tool in the frame base' if key == 'position' else
                   'Rotation vector of the tool in the frame base')
        found.append(Figure(
            key, title, f'{caption}{": measured (line) and reference (dots)" if known else ""}.',
            traces, f'{key} [{unit}]'))
    return found


def path_trace(points: np.ndarray, name: str, colour: str, dash: str = 'solid') -> dict:
    """Return the way of points (n, 3) in the x-y plane; a mark where they are one."""
    if np.ptp(points[:, :2], axis=0).max() < 1e-6:
        return {'type': 'scatter', 'mode': 'markers', 'name': name,
                'x': packed(points[:1, 0]), 'y': packed(points[:1, 1]),
                'marker': {'color': colour, 'size': 10, 'symbol': 'x'}}
    rows = np.unique(np.linspace(0, len(points) - 1, 2 * CURVE_PIECES).round().astype(int))
    return {'type': 'scatter', 'mode': 'lines', 'name': name, 'x': packed(points[rows, 0]),
            'y': packed(points[rows, 1]), 'line': {'color': colour, 'width': 2, 'dash': dash}}


def _joint_figures(run: Run) -> list[Figure]:
    """Return positions and velocities of the joints beside their reference."""
    found = []
    for key, title, measured, field, unit in (
            ('joint_position', 'Joint positions', run.states.q, 'q', 'rad'),
            ('joint_velocity', 'Joint velocities', run.states.qd, 'qd', 'rad/s')):
        traces = [curve(run.t, measured[:, i], name, COLOURS[i])
                  for i, name in enumerate(SHORT_NAMES)]
        desired = None if run.reference is None else getattr(run.reference, field)
        caption = 'Measured.'
        if desired is not None and np.isfinite(desired).any():
            caption = 'Measured (line) and reference (dots).'
            traces += [curve(run.t, desired[:, i], f'{name}, reference', COLOURS[i], 'dot', 2.4)
                       for i, name in enumerate(SHORT_NAMES)]
        found.append(Figure(key, title, caption, traces, f'{title.lower()} [{unit}]',
                            first=run.reference is None and field == 'q'))
    return found


def _error_figure(run: Run) -> Figure:
    """Return the joint error of a law that promises no error equation."""
    error = 1e3 * (run.exact.q - run.required_reference.q)
    return Figure('error', 'Joint error', 'Position minus reference.',
                  [curve(run.t, error[:, i], name, COLOURS[i])
                   for i, name in enumerate(SHORT_NAMES)], 'error [mrad]', wide=True)


def _error_figures(series) -> list[Figure]:
    run, dynamics = series['run'], series['dynamics']
    t, traces = run.t, []
    for i, name in enumerate(SHORT_NAMES):
        traces.append(curve(t, 1e3 * dynamics.error[:, i], name, COLOURS[i]))
        traces.append(curve(t, 1e3 * dynamics.continuous[:, i], f'{name}, theory', COLOURS[i],
                            'dot', 2.4))
    if not np.isfinite(dynamics.continuous).any():
        return [Figure('error', 'Joint error e(t)', 'Position minus reference.', traces[::2],
                       'error [mrad]', wide=True)]
    distance = [curve(t, magnitudes(1e3 * (dynamics.error - dynamics.continuous)[:, i]), name,
                      COLOURS[i])
            for i, name in enumerate(SHORT_NAMES)]
    found = [
        Figure('error', 'Joint error e(t) against theory', "Recorded error (line) and the "
               "solution of e'' + Kd e' + Kp e = 0 from the same start (dots).", traces,
               'error [mrad]', wide=True),
        Figure('error_away', 'Distance of e(t) from the continuous solution', 'What holding the '
               'torque and sampling the reference cost.', distance, '|difference| [mrad]',
               log=True)]
    if run.substeps == 1:
        step = [curve(t[1:], magnitudes(1e3 * (dynamics.error - dynamics.sampled)[1:, i]), name,
                      COLOURS[i]) for i, name in enumerate(SHORT_NAMES)]
        found.append(Figure(
            'error_sampled', 'Distance of e(t) from the sampled equation', 'The loop as it is '
            'sampled, followed from the first state: only rounding should be left.', step,
            '|difference| [mrad]', log=True))
    return found


def _torque_figures(series) -> list[Figure]:
    run = series['run']
    if np.isnan(run.states.effort).all():
        return []
    acted = ("the robot's own target torque" if run.follows_reference
             else 'the torque that acted')
    found = [Figure(
        'torque', 'Joint torques', f'{acted.capitalize()}.',
        [curve(run.t[1:], run.states.effort[1:, i], name, COLOURS[i])
         for i, name in enumerate(SHORT_NAMES)], 'torque [N m]', first=True, wide=True)]
    shown = {name: run.parts[name] for name in PARTS if name in run.parts}
    colours = dict(zip(PARTS, SERIES[1:], strict=False))
    if not shown:
        return found
    for i, joint in enumerate(JOINT_NAMES):
        traces = [curve(run.t[1:], run.states.effort[1:, i], 'acted', SERIES[0], width=2.2)]
        traces += [curve(run.t, part[:, i], name, colours[name])
                   for name, part in shown.items()]
        found.append(Figure(f'torque_{i + 1}', f'Torque, {joint}',
                            f'{acted.capitalize()}, and the parts of the command.', traces,
                            'torque [N m]'))
    return found


def _residual_figures(series) -> list[Figure]:
    run, found = series['run'], []
    for key, title in (('residual_control', "Residual with the controller's arm"),
                       ('residual_sim', "Residual with the simulator's arm")):
        if key not in series:
            continue
        traces = [curve(run.t[:-1], magnitudes(series[key][:, i]), name, COLOURS[i])
                  for i, name in enumerate(SHORT_NAMES)]
        found.append(Figure(key, title, 'What the equations leave unexplained, as torque: '
                            'rounding if model and plant agree.', traces, '|residual| [N m]',
                            log=True))
    return found


def _contact_figures(series) -> list[Figure]:
    if 'external_torque' in series:
        return _external_torque_figures(series)
    if 'observer' not in series:
        return []
    run, (estimate, recorded) = series['run'], series['observer']
    traces = _paired(run.t, recorded, estimate, 'estimated')
    return [Figure('contact', 'Torque of contact', 'Joint torque of all contacts as it was '
                   'recorded (line), and as the momentum observer estimates it from motion and '
                   'motor torque (dots); both through the same filter.', traces, 'torque [N m]',
                   wide=True)]


def _external_torque_figures(series) -> list[Figure]:
    run, (estimate, marks) = series['run'], series['external_torque']
    traces = _paired(run.t, estimate, marks, 'mark')
    return [Figure('contact', 'External torque', 'What a momentum observer finds beside motors, '
                   'model and friction (line), and the mark of each joint above which a contact '
                   'is likely (dots): what friction may hold at rest and a multiple of what the '
                   'model leaves unexplained.', traces, 'torque [N m]', wide=True)]


def _paired(t: np.ndarray, values: np.ndarray, others: np.ndarray,
            word: str) -> list[dict[str, Any]]:
    """Return two curves a joint, the second dotted and named by a word."""
    return [trace for i, name in enumerate(SHORT_NAMES) for trace in (
        curve(t, values[:, i], name, COLOURS[i]),
        curve(t, others[:, i], f'{name}, {word}', COLOURS[i], 'dot'))]


def _timing_figures(series) -> list[Figure]:
    delays = series.get('delays')
    if delays is None or not delays.size:
        return []
    low, high = max(delays.min(), 1e-6), max(delays.max(), 2e-6)
    counts, edges = np.histogram(delays, np.geomspace(low * 0.99, high * 1.01, 80))
    centres = np.sqrt(edges[1:] * edges[:-1])
    bars = {'type': 'bar', 'name': 'answers', 'x': packed(centres * 1e3), 'y': packed(counts),
            'width': packed(np.diff(edges) * 1e3), 'marker': {'color': MEASURED}}
    return [Figure('timing', 'Latency, state to command', "Wall clock from a state's departure "
                   "to its answer's arrival at the simulator.", [bars], 'answers',
                   x='latency [ms]', log=True)]


def magnitudes(values: np.ndarray) -> np.ndarray:
    """Return magnitudes for a logarithmic axis; zero, which it cannot show, makes a gap."""
    size = np.abs(values)
    return np.where(size > 0.0, size, np.nan)
