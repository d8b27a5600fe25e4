"""The report of an identification: torque predicted and measured, what is left, parameters."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.analysis.identification.prediction import Prediction
from ur5_ros.analysis.identification.result import Identified
from ur5_ros.analysis.identification.words import unit_of, with_error
from ur5_ros.analysis.report.document import html_document, markup, write_document
from ur5_ros.analysis.report.figure import Figure, packed
from ur5_ros.analysis.report.figures import curve
from ur5_ros.analysis.report.html import figure_data, figure_section
from ur5_ros.analysis.report.palette import JOINT_COLOURS, MEASURED, REFERENCE, SHORT_NAMES
from ur5_ros.analysis.report.rounding import RESOLUTION
from ur5_ros.signals import JOINT_NAMES

#: Points that a scatter plot has of each joint.
POINTS = 600


def write_identification_html(found: Identified, path: str | Path) -> None:
    """Write the report of an identification; InputError if it cannot be written."""
    write_document(identification_html(found), path)


def identification_html(found: Identified) -> str:
    """Return the report as text; nothing from a bag becomes markup."""
    plots = identification_figures(found)
    words = ''.join(f'<li>{markup(sentence)}</li>' for sentence in found.sentences())
    body = ''.join([
        f'<h1>Identification from {markup(found.train.run)}: arm {markup(found.arm.name)}</h1>\n',
        f'<ul>{words}</ul>\n', figure_section('Torque', plots), _joints(found), _base(found)])
    return html_document(f'identification: {found.arm.name}', body,
                         [figure_data(plot) for plot in plots])


def identification_figures(found: Identified) -> list[Figure]:
    """Return the figures: torque of each joint, what is left against speed, error by joint."""
    test = found.test
    return [_errors(found), _against_speed(test)] + [
        _torque(test, i) for i in range(6)]


def _torque(test: Prediction, i: int) -> Figure:
    t, series = test.series['time'], test.series
    traces = [curve(t, series['torque'][:, i], 'measured', MEASURED),
              curve(t, series['predicted'][:, i], 'predicted', REFERENCE, 'dot')]
    return Figure(f'torque-{i}', f'Torque, {JOINT_NAMES[i]}',
                  f'Measured and predicted on {test.run}, means over 0.15 s; a gap where the '
                  'joint rests and friction has no direction.', traces, 'torque [N m]')


def _against_speed(test: Prediction) -> Figure:
    step = max(1, len(test.series['error']) // POINTS)
    speed, error = test.series['speed'][1:-1:step], test.series['error'][::step]
    error = np.where(np.abs(error) < RESOLUTION['N m'], 0.0, error)
    scale = np.where(test.torque_rms > 0.0, test.torque_rms, 1.0)
    traces: list[dict[str, Any]] = [
        {'type': 'scatter', 'mode': 'markers', 'name': SHORT_NAMES[i], 'x': packed(speed[:, i]),
         'y': packed(error[:, i] / scale[i]), 'marker': {'color': JOINT_COLOURS[i], 'size': 4}}
        for i in range(6)]
    return Figure('speed', 'Residual torque against speed', 'Measured minus predicted torque, as '
                  'a share of the torque of the joint; a step at zero speed or a slope is '
                  'friction that the model does not have.', traces, 'share of the torque',
                  x='speed [rad/s]')


def _errors(found: Identified) -> Figure:
    names = list(SHORT_NAMES)
    traces: list[dict[str, Any]] = [
        {'type': 'bar', 'name': name, 'x': names, 'y': packed(values), 'marker': {'color': colour}}
        for name, values, colour in (
            ('torque', found.test.torque_rms, '#8a929a'),
            ('error in training', found.train.error_rms, MEASURED),
            ('error held out', found.test.error_rms, REFERENCE))]
    return Figure('errors', 'Error by joint', f'Root mean square over windows; held out: '
                  f'{found.test.run}.', traces, 'torque [N m]', x='joint', log=True)


def _joints(found: Identified) -> str:
    head = ('joint', 'viscous [N m s/rad]', 'Coulomb [N m]', 'family of friction',
            'left out: none, linear, family [N m]', 'rotor [kg m^2]')
    rows = []
    for i, name in enumerate(JOINT_NAMES):
        family = found.family[i]
        rows.append((
            name, _value(found.viscous[i], found.viscous_error[i]),
            _value(found.coulomb[i], found.coulomb_error[i]), family.name,
            f'{family.held_out_none:.3g}, {family.held_out_linear:.3g}, {family.held_out:.3g}',
            f'{found.arm.armature[i]:.4g}'))
    return _table('Joints', head, rows)


def _base(found: Identified) -> str:
    rows = [(name, _value(value, error), unit_of(name))
            for name, (value, error) in found.base.items()]
    rows += [(name, 'not excited', '') for name in found.not_excited]
    return _table('Base parameters', ('name', 'value', 'unit'), rows)


def _value(value: float, error: float) -> str:
    return with_error(value, error).replace('+-', '±')


def _table(title: str, head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    top = ''.join(f'<th>{markup(name)}</th>' for name in head)
    body = ''.join('<tr>' + ''.join(f'<td>{markup(cell)}</td>' for cell in row) + '</tr>\n'
                   for row in rows)
    return (f'<h2>{markup(title)}</h2>\n<table><thead><tr>{top}</tr></thead>'
            f'<tbody>{body}</tbody></table>\n')
