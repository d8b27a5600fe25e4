"""A report draws signals: what rounding leaves is a number in words."""

from dataclasses import replace

import numpy as np

from ur5_ros.analysis.report.figure import Figure
from ur5_ros.analysis.report.figures import curve, figures
from ur5_ros.analysis.report.html import figure_section, html_text
from ur5_ros.analysis.report.rounding import without_rounding
from ur5_ros.analysis.validate import validate
from ur5_ros.config import load_arm

T = np.linspace(0.0, 1.0, 200)


def plot(scale: float, log: bool = True, unit: str = 'N m') -> Figure:
    return Figure('one', 'One', '', [curve(T, scale * (1.2 + np.sin(9 * T)), 'a', '#000000')],
                  f'torque [{unit}]', log=log)


def test_the_residual_of_a_perfect_model_is_a_sentence_and_one_of_a_wrong_model_a_plot(looped):
    result = validate(looped('kebria_fig11', 'ur5', 2.0))
    shown = {figure.key: figure for figure in figures(result)}
    for key in ('residual_sim', 'error_sampled'):
        assert not shown[key].traces
        assert shown[key].note.startswith('Within rounding: at most ')
    assert shown['torque'].traces and shown['error'].traces
    assert 'id="plot-residual_sim"' not in html_text(result)
    run = looped('kebria_fig11', 'ur5', 2.0)
    wrong = validate(replace(run, control=replace(run.control, arm=load_arm('ur5_description'))))
    assert {figure.key: figure for figure in figures(wrong)}['residual_control'].traces


def test_noise_beside_a_signal_leaves_a_logarithmic_plot(looped):
    both = plot(1.0)
    both.traces.append(curve(T, np.full(200, 1e-13), 'noise', '#000000'))
    assert [trace['name'] for trace in without_rounding(both).traces] == ['a']
    assert len(without_rounding(both._replace(log=False)).traces) == 2


def test_small_signals_and_figures_without_a_unit_stay():
    for scale, unit in ((1e-8, 'N m'), (1e-10, 'rad'), (1e-5, 'mm')):
        assert without_rounding(plot(scale, unit=unit)).traces
    counts = plot(1e-13)._replace(y='answers')
    assert without_rounding(counts) == counts


def test_a_figure_without_curves_has_no_empty_plot():
    words = figure_section('Figures', [without_rounding(plot(1e-13))])
    assert 'class="plot"' not in words and 'Within rounding: at most 2.2e-13 N m.' in words
