"""The report of an identification opens from disk, loads nothing, and shows what was found."""

import base64
import re

import numpy as np
import pytest

from ur5_ros.analysis.identification.identify import identify
from ur5_ros.analysis.report.identification import (
    identification_figures,
    identification_html,
    write_identification_html,
)
from ur5_ros.errors import InputError


@pytest.fixture(scope='module')
def found(looped):
    return identify([looped('exciting', duration=20.0, control_rate=500, sim={
        'noise.velocity': 1e-3, 'friction.viscous': [2.0, 2.0, 2.0, 0.5, 0.5, 0.5]})])


def numbers(data):
    return np.frombuffer(base64.b64decode(data['bdata']), dtype='<f4')


def test_it_names_every_parameter_and_loads_nothing(found, tmp_path):
    write_identification_html(found, tmp_path / 'page.html')
    text = (tmp_path / 'page.html').read_text(encoding='utf-8')
    plain = re.sub(r'<script.*?</script>', '', text, flags=re.DOTALL)
    assert not re.search(r'(src|href)\s*=', plain)
    for name in [*found.base, *found.not_excited, 'wrist_3_joint', 'family of friction']:
        assert name in plain
    assert 'nan' not in plain


def test_measured_and_predicted_torque_of_each_joint_differ_by_the_error(found):
    plots = {plot.key: plot for plot in identification_figures(found)}
    assert {'errors', 'speed', *(f'torque-{i}' for i in range(6))} == set(plots)
    for i in range(6):
        measured, predicted = (numbers(trace['y']) for trace in plots[f'torque-{i}'].traces)
        if len(measured) == len(predicted):
            left = np.sqrt(np.nanmean((measured - predicted)**2))
            assert left < 4.0 * found.test_rms[i] + 1e-6
    bars = [numbers(trace['y']) for trace in plots['errors'].traces]
    np.testing.assert_allclose(bars[2], found.test_rms, rtol=1e-6)


def test_a_name_from_a_bag_is_text(found):
    named = found._replace(test=found.test._replace(run='<script>alert(1)</script>'))
    assert '<script>alert(1)' not in identification_html(named)


def test_a_file_that_cannot_be_written_is_refused(found, tmp_path):
    with pytest.raises(InputError, match='cannot be written'):
        write_identification_html(found, tmp_path / 'no' / 'page.html')
