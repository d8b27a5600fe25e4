"""A law in a file: as good as a built-in one, and refused in one line where it is wrong."""

import numpy as np
import pytest
from law_files import LAW
from numpy.testing import assert_allclose

from ur5_ros.config import load_arm
from ur5_ros.control.controller import Controller
from ur5_ros.errors import InputError
from ur5_ros.signals import ArmState

ARM = load_arm('ur5_real')
START = np.array([0.3, -1.2, 1.5, -1.9, -1.4, 0.2])
STATE = ArmState(1_000_000, START, np.zeros(6), np.zeros(6))
LATER = ArmState(2_000_000, START + 0.01, np.full(6, 0.1), np.zeros(6))

GRAVITY_PD = """return (gravity_torque(state.q, self.arm)
                - self.gains.kp @ (state.q - reference.q)
                - self.gains.kd @ (state.qd - reference.qd))"""


def answers(tmp_path, text, **control):
    file = tmp_path / 'my_law.py'
    file.write_text(text, encoding='utf-8')
    controller = Controller(ARM, {'law_file': str(file), 'kp': 50.0, 'kd': 5.0, **control}, 1000)
    return [controller.update(state).torque for state in (STATE, LATER)]


@pytest.mark.parametrize('convention', ['total', 'gravity_excluded'])
def test_a_law_in_a_file_gives_what_the_same_built_in_one_gives(tmp_path, convention):
    control = {'kp': 50.0, 'kd': 5.0, 'effort_convention': convention}
    mine = answers(tmp_path, LAW.format(body=GRAVITY_PD), effort_convention=convention)
    own = Controller(ARM, {'mode': 'gravity_pd', **control}, 1000)
    for torque, state in zip(mine, (STATE, LATER), strict=True):
        for part, expected in zip(torque, own.update(state).torque, strict=True):
            assert_allclose(part, expected, atol=1e-12)


def test_it_may_be_a_subclass_of_a_built_in_law_with_its_parts(tmp_path):
    text = ('from ur5_ros.control.laws.slotine_li import SlotineLi\n'
            'class Law(SlotineLi):\n    pass\n')
    mine = answers(tmp_path, text)
    own = Controller(ARM, {'mode': 'slotine_li', 'kp': 50.0, 'kd': 5.0}, 1000)
    for torque, state in zip(mine, (STATE, LATER), strict=True):
        assert_allclose(np.array(torque), np.array(own.update(state).torque), atol=0.0)


def test_a_file_that_was_changed_is_read_again(tmp_path):
    first = answers(tmp_path, LAW.format(body='return [1.0] * 6'))
    second = answers(tmp_path, LAW.format(body='return [2.0] * 6   # and longer'))
    assert_allclose([first[0].total[0], second[0].total[0]], [1.0, 2.0])


@pytest.mark.parametrize(('text', 'words'), [
    (LAW.format(body='return [float("nan")] * 6'), 'torque of joint 1 is nan; return finite'),
    (LAW.format(body='return [0.0, 0.0, float("inf"), 0, 0, 0]'), 'torque of joint 3 is inf'),
    (LAW.format(body='return [0.0] * 5'), r'torque has the shape \(5,\); return six numbers'),
    (LAW.format(body='return None'), r'returns nothing \(None\); return six numbers or a Torque'),
    (LAW.format(body='return "far"'), 'returns text; return six numbers'),
    (LAW.format(body='return ["1"] * 6'), 'returns text'),
    (LAW.format(body='return [1j] * 6'), 'returns complex numbers'),
    (LAW.format(body='import numpy; return numpy.ones(6) * (1 + 0j)'), 'complex numbers'),
    (LAW.format(body='yield 0.0'), 'returns no numbers but generator'),
    (LAW.format(body='return [[0.0], [0.0, 1.0]]'), 'returns no numbers but list'),
    (LAW.format(body='return [0.0] * 1000'), r'torque has the shape \(1000,\)'),
    (LAW.format(body='state.q[0] = 1.0'), r'ValueError: .* read-only \(line 9\)'),
    (LAW.format(body='reference.qdd[:] = 0.0'), r'ValueError: .* read-only \(line 9\)'),
    (LAW.format(body='raise SystemExit(0)'), r'SystemExit: 0 \(line 9\)'),
    (LAW.format(body='raise ValueError("a\\nb" + "x" * 100_000)'),
     r'ValueError: a bx{197} \(line 9\)'),
    (LAW.format(body='raise ValueError("\\udcff\\x1b[31m")'), r'ValueError: \?\?\[31m'),
    ('raise SystemExit(0)\n', r'SystemExit: 0 \(line 1\)'),
    (LAW.format(body='return 1 / 0'), r'ZeroDivisionError: division by zero \(line 9\)'),
    ('x = 1\n', r'defines no class Law; give it one with __init__\(arm, gains, parameters\)'),
    ('Law = 3\n', 'defines no class Law'),
    ('import no_such_module\n', r"No module named 'no_such_module' \(line 1\)"),
    ('class Law\n', r'SyntaxError: .* \(line 1\)'),
    ('class Law:\n    def __init__(self):\n        pass\n', 'takes 1 positional argument'),
    ('class Law:\n    def __init__(self, arm, gains, parameters):\n        pass\n',
     r'class Law has no __call__\(state, reference, dt\)'),
    ('class Law:\n    def __init__(self, *a):\n        pass\n    def __call__(self, state):\n'
     '        return [0.0] * 6\n', 'takes 2 positional arguments'),
])
def test_what_is_wrong_with_a_file_is_said_in_one_line(tmp_path, text, words):
    with pytest.raises(InputError, match=words) as refusal:
        answers(tmp_path, text)
    assert '\n' not in str(refusal.value)
    assert 'my_law.py' in str(refusal.value)


def test_a_file_that_is_not_there_or_a_folder_is_named(tmp_path):
    with pytest.raises(InputError, match=r'no file none\.py; give a Python file'):
        Controller(ARM, {'law_file': 'none.py'}, 1000)
    with pytest.raises(InputError, match='is a folder; give a Python file'):
        Controller(ARM, {'law_file': str(tmp_path)}, 1000)


def test_a_file_that_is_no_text_is_refused_in_one_line(tmp_path):
    file = tmp_path / 'my_law.py'
    for content in (b'\xff\xfe\x00', b's = "\xe4"\n', b'x = 1\x00\n'):
        file.write_bytes(content)
        with pytest.raises(InputError, match='Error: ') as refusal:
            Controller(ARM, {'law_file': str(file)}, 1000)
        assert '\n' not in str(refusal.value) and 'my_law.py' in str(refusal.value)


def test_what_raises_in_reset_is_said_in_one_line(tmp_path):
    text = LAW.format(body='return [0.0] * 6')
    text += '\n    def reset(self):\n        raise KeyError(3)\n'
    file = tmp_path / 'my_law.py'
    file.write_text(text, encoding='utf-8')
    controller = Controller(ARM, {'law_file': str(file), 'kp': 50.0, 'kd': 5.0}, 1000)
    controller.update(STATE)
    with pytest.raises(InputError, match=r'my_law\.py: KeyError: 3 \(line 12\)'):
        controller.update(LATER._replace(stamp=STATE.stamp + 2_000_000_000))


def test_a_running_node_takes_no_file_from_the_network():
    with pytest.raises(InputError, match='law_file is read at the start only'):
        Controller(ARM, {'kd': 20.0}, 1000).change({'law_file': 'other.py'})
