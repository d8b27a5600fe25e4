"""A law of the user in the control node: it runs like a mode, and what is wrong is one line."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ur5_ros.bag.reader import open_bag

LAW = """
import time

from ur5_ros import gravity_torque


class Law:
    def __init__(self, arm, gains, parameters):
        self.arm, self.gains, self.calls = arm, gains, 0

    def __call__(self, state, reference, dt):
        self.calls += 1
        torque = (gravity_torque(state.q + self.arm.angle_offset, self.arm)
                  - self.gains.kp @ (state.q - reference.q)
                  - self.gains.kd @ (state.qd - reference.qd))
        {line}
        return torque
"""
CONTROL = {'arm': 'ur5_real', 'kp': [400.0, 400.0, 300.0, 60.0, 60.0, 60.0],
           'kd': [40.0, 40.0, 30.0, 5.0, 5.0, 5.0]}


@pytest.fixture
def law(tmp_path):
    """Write a law; return its file."""
    def write(text):
        file = tmp_path / 'my_law.py'
        file.write_text(text, encoding='utf-8')
        return str(file)
    return write


def test_a_law_in_a_file_moves_the_arm_as_the_mode_does(ros, law):
    positions = []
    for more in ({'mode': 'gravity_pd'}, {'law_file': law(LAW.format(line=''))}):
        control = ros.start('control', **CONTROL, **more)
        sim = ros.start('sim', arm='ur5_real', stop_after=0.3, payload__mass=2.0)
        assert sim.ends() == 0, sim.text
        assert control.stop() == 0, control.text
        assert 'too late' not in control.text
        folder = max((ros.folder / 'bags').glob('*/sim'), key=lambda path: path.stat().st_mtime)
        positions.append(open_bag(folder).joint_states('/joint_states').position)
    assert np.abs(positions[0][-1] - positions[0][0]).max() > 1e-3  # it moves
    assert_allclose(positions[1], positions[0], atol=1e-9)


@pytest.mark.parametrize(('text', 'words'), [
    ('x = 1\n', 'defines no class Law; give it one with __init__(arm, gains, parameters)'),
    ('import no_such_module\n', "No module named 'no_such_module' (line 1)"),
    ('raise SystemExit(0)\n', 'SystemExit: 0 (line 1)'),
    (None, 'no file'),
])
def test_a_file_that_is_no_law_is_refused_in_one_line(ros, law, tmp_path, text, words):
    file = str(tmp_path / 'none.py') if text is None else law(text)
    control = ros.start('control', law_file=file)
    assert control.ends() == 2, control.text
    lines = [line for line in control.text.splitlines() if line]
    assert len(lines) == 1 and words in lines[0] and file in lines[0], lines


@pytest.mark.parametrize(('line', 'words'), [
    ('torque[2] = float("nan")', 'the torque of joint 3 is nan; return finite numbers'),
    ('torque = torque[:5]', 'the torque has the shape (5,); return six numbers or a Torque'),
    ('torque = None', 'the law returns nothing (None); return six numbers or a Torque'),
    ('raise SystemExit(0)', 'SystemExit: 0 (line 17)'),
])
def test_a_law_that_gives_no_torque_is_a_warning_in_one_line_and_the_node_goes_on(
        ros, law, line, words):
    text = LAW.format(line=f'if self.calls > 50:\n            {line}')
    control = ros.start('control', **CONTROL, law_file=law(text))
    sim = ros.start('sim', arm='ur5_real')
    control.wait_for_line(words)
    assert 'Traceback' not in control.text
    printed = next(each for each in control.text.splitlines() if words in each)
    assert 'my_law.py' in printed
    assert control.stop() == 0, control.text
    assert sim.stop() == 0, sim.text


def test_a_law_that_answers_later_than_a_period_is_said_so_once_and_in_lockstep_waited_for(
        ros, law):
    control = ros.start('control', **CONTROL, law_file=law(LAW.format(line='time.sleep(0.003)')))
    sim = ros.start('sim', arm='ur5_real', stop_after=0.2)
    control.wait_for_line('my_law.py: too late: an answer takes')
    assert sim.ends() == 0, sim.text
    assert control.stop() == 0, control.text
    assert control.text.count('too late') == 1
