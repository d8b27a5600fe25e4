"""Right solutions get full marks on every seed; usual mistakes lose their line and are named."""

import contextlib
import json
import re
import time
from functools import partial
from pathlib import Path

import pytest
from command import Command
from thorough import times

from ur5_ros.course.grade import EXERCISES, exercise_named, grade, judge
from ur5_ros.errors import InputError

HERE = Path(__file__).resolve().parent
SOLUTIONS = HERE / 'solutions'
STARTERS = HERE.parents[1] / 'docs/course/starters'
SEEDS = range(times(3, 20))
DEGREES = 'degrees instead of radians'

#: Exercise, what of the right solution is replaced by what, the line lost, the mistake named.
MISTAKES = [
    ('dynamics', 'return -sum(m * linear', 'return sum(m * linear', 'gravity', "gravity's sign"),
    ('kinematics', 'return frames(q)[-1]', 'return np.diag([-1, -1, 1, 1.0]) @ frames(q)[-1]',
     'pose', 'base turned by pi (base_link, not base)'),
    ('kinematics', 'return frames(q)[-1]', 'return frames(np.deg2rad(q))[-1]', 'pose', DEGREES),
    ('kinematics', '[[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s],\n'
     '                                [0.0, sa, ca, d],',
     '[[c, -s, 0.0, a], [s * ca, c * ca, -sa, -sa * d],\n'
     '                                [s * sa, c * sa, ca, ca * d],',
     'pose', "Craig's (modified) DH parameters for standard ones"),
    ('dynamics', 'return 0.5 * (np.einsum', 'return (np.einsum', 'Coriolis',
     'Christoffel symbols without the half'),
    ('kinematics', 'q + 2 * np.pi * np.round((q_near - q) / (2 * np.pi))',
     '(q + np.pi) % (2 * np.pi) - np.pi', 'inverse',
     'missing +-2 pi: not the turn nearest to q_near'),
    ('computed_torque', 'return stamp, ', 'return stamp + 1_000_000, ', 'stamp',
     'wrong stamp: it is that of the state answered'),
    ('computed_torque', 'return stamp, M @ a + C @ qd + g',
     'late = getattr(self, "late", g)\n        self.late = M @ a + C @ qd + g\n'
     '        return stamp, late', 'torque', 'torque a period late'),
    ('computed_torque', 'M @ a + C @ qd + g', 'M @ a + C @ qd - g', 'torque', "gravity's sign"),
    ('identification', 'return np.sqrt(noise * np.diag(np.linalg.inv(Y.T @ Y)))',
     'return noise * np.diag(np.linalg.inv(Y.T @ Y))', 'standard errors',
     'variances instead of standard errors'),
    ('friction', 'return viscous * qd + coulomb', 'return -viscous * qd - coulomb', 'torque',
     "friction's sign"),
    ('contact', 'jacobian(q, ARM).T @ wrench', 'jacobian(q, ARM) @ wrench', 'joint torque',
     'J instead of its transpose'),
    ('contact', 'effort - C.T @ qd + g', 'effort - C.T @ qd', 'observer', 'no gravity'),
]


@pytest.mark.thorough
@pytest.mark.parametrize('name', EXERCISES)
def test_a_right_solution_gets_full_marks_on_every_seed(name, record_property):
    record_property('seeds', len(SEEDS))
    for seed in SEEDS:
        found = judge(exercise_named(name), str(SOLUTIONS / f'{name}.py'), seed)
        assert found['why'] == ''
        assert [mark for mark in found['marks'] if mark.points < mark.of] == []


@pytest.mark.parametrize('name', EXERCISES)
def test_the_points_of_an_exercise_add_up_to_ten(name):
    assert sum(line.points for line in exercise_named(name).lines) == 10.0


@pytest.mark.parametrize(('name', 'right', 'wrong', 'line', 'mistake'), MISTAKES,
                         ids=[f'{each[0]}: {each[4]}' for each in MISTAKES])
def test_a_usual_mistake_loses_its_line_and_is_named(
        tmp_path, name, right, wrong, line, mistake):
    text = (SOLUTIONS / f'{name}.py').read_text(encoding='utf-8')
    assert text.count(right) == 1
    file = tmp_path / 'solution.py'
    file.write_text(text.replace(right, wrong), encoding='utf-8')
    for seed in (0, 7):
        marks = {mark.line: mark for mark in judge(exercise_named(name), str(file), seed)['marks']}
        assert marks[line].points == 0.0
        assert marks[line].mistake == mistake
        assert '\n' not in marks[line].reason


def test_at_least_twelve_mistakes_are_known_here():
    assert len(MISTAKES) >= 12


def solution(tmp_path, text):
    file = tmp_path / 'solution.py'
    file.write_text(text, encoding='utf-8')
    return file


def ended(*command):
    """Return whether no such process is there, or soon will be."""
    looked_for, until = '\0'.join((*command, '')).encode(), time.monotonic() + 20.0
    while time.monotonic() < until:
        found = []
        for path in Path('/proc').glob('[0-9]*/cmdline'):
            with contextlib.suppress(OSError):  # it may end meanwhile
                found.append(path.read_bytes())
        if looked_for not in found:
            return True
        time.sleep(0.05)
    return False


@pytest.mark.parametrize(('text', 'words'), [
    ('import os\nos.abort()\n', r'ended by signal 6 \(SIGABRT\)'),
    ('import os\nos._exit(3)\n', 'ended with code 3'),
    ('import no_such_module\n', r"No module named 'no_such_module' \(line 1\)"),
    ('def friction_torque(:\n', 'SyntaxError'),
    ('raise SystemExit(0)\n', 'cannot be imported: SystemExit'),
    ('import numpy as np\nkept = np.ones(2**27)\n', 'more than 512 MB of memory'),
])
def test_a_file_that_breaks_is_judged_with_no_points(tmp_path, text, words):
    found = grade('friction', solution(tmp_path, text))
    assert found.points == 0.0 and not found.full
    assert re.search(words, found.why)
    assert '\n' not in found.why


def test_an_endless_loop_ends_with_a_verdict_and_leaves_no_process(tmp_path):
    began = time.monotonic()
    text = 'import subprocess\nsubprocess.Popen(["sleep", "98765"])\nwhile True:\n    pass\n'
    found = grade('friction', solution(tmp_path, text), seconds=6.0)
    assert 'no result after 6 s; an endless loop?' in found.why
    assert time.monotonic() - began < 40.0
    assert ended('sleep', '98765')


FRICTION = (SOLUTIONS / 'friction.py').read_text(encoding='utf-8')
TORQUE = 'return viscous * qd + coulomb * np.sign(qd)'
assert FRICTION.count(TORQUE) == 1


@pytest.mark.parametrize('begins', [
    'import sys\nfor _ in range(20):\n    print("x" * 10**6)\n    print("y" * 10**6, '
    'file=sys.stderr)\n',
    'import threading, time\nthreading.Thread(target=time.sleep, args=(1000,)).start()\n',
    'import subprocess\nsubprocess.Popen(["sleep", "98764"])\n',
    'open("litter.txt", "w").write("x")\n',
    'import os\nos.chdir("/")\n',
    'import numpy as np\nnp.float = float\nnp.seterr(all="raise")\n',
], ids=['prints megabytes', 'leaves a thread', 'leaves a process', 'writes a file',
        'goes elsewhere', 'adds to numpy'])
def test_what_a_right_solution_does_besides_costs_nothing_and_stays_with_its_process(
        tmp_path, monkeypatch, begins):
    monkeypatch.chdir(tmp_path)
    began = time.monotonic()
    found = grade('friction', solution(tmp_path, begins + FRICTION), seconds=300.0)
    assert found.full, found
    assert time.monotonic() - began < 250.0  # no thread and no pipe is waited for
    assert [path.name for path in tmp_path.iterdir()] == ['solution.py']
    assert ended('sleep', '98764')


@pytest.mark.parametrize(('begins', 'words'), [
    ('import os\nos._exit(0)\n', 'ended with code 0 before there was a result'),
    ('import numpy as np\nnp.allclose = lambda *a, **k: True\n', 'replaces numpy.allclose; leave'),
    ('import math\nmath.pi = 3\n', 'replaces math.pi'),
    ('import ur5_ros.course.exercise as e\ne.compare = lambda *a: ("", "")\n',
     'replaces ur5_ros.course.exercise.compare'),
    ('with open("big", "wb") as file:\n    for _ in range(100):\n'
     '        file.write(bytes(10**6))\n', r'File too large \(line 3\)'),
    ('raise KeyboardInterrupt\n', r'imported: KeyboardInterrupt \(line 1\)'),
    ('input()\n', 'EOFError'),
    ('class E(Exception):\n    def __str__(self):\n        raise ValueError\nraise E()\n',
     r'E: its text cannot be shown \(line 4\)'),
])
def test_a_file_that_would_be_judged_wrongly_is_not_judged(tmp_path, begins, words):
    found = grade('friction', solution(tmp_path, begins + FRICTION))
    assert found.points == 0.0 and not found.full
    assert re.search(words, found.why), found.why
    assert '\n' not in found.why


def test_a_file_that_is_no_text_is_judged_with_no_points(tmp_path):
    file = tmp_path / 'solution.py'
    for content in (b's = "\xe4\xff"\n', b'x = 1\x00\n', 'x = 1'.encode('utf-16')):
        file.write_bytes(content)
        found = judge(exercise_named('friction'), str(file), 0)
        assert 'cannot be imported: ' in found['why'] and '\n' not in found['why']


@pytest.mark.parametrize(('line', 'words'), [
    ('pass', r'friction_torque returns nothing \(None\)'),
    ('yield 1.0', 'returns no numbers but generator'),
    ('return qd * np.nan', 'not finite'),
    ('return np.full(6, np.inf)', 'not finite'),
    (f'{TORQUE} + 0j', 'returns complex numbers'),
    (f'{TORQUE.replace("return ", "return list(map(str, ")}))', 'returns text'),
    ('return qd[:5]', r'returns the shape \(5,\); it should be \(6,\)'),
    ('return np.broadcast_to(0.0, (10**9, 10**9))', 'memory|shape'),
    ('return friction_torque(qd, viscous, coulomb)', 'RecursionError'),
    ('raise SystemExit(0)', r'SystemExit: 0 \(line 7\)'),
    ('raise ValueError("\\udcff\\x1b[31m\\n" + "z" * 10**6)',
     r'ValueError: \?\?\[31m z{190,200} '),
])
def test_an_answer_that_is_no_answer_costs_its_line_in_one_line(tmp_path, line, words):
    file = solution(tmp_path, FRICTION.replace(TORQUE, line))
    mark = judge(exercise_named('friction'), str(file), 0)['marks'][0]
    assert mark.points == 0.0
    assert re.search(words, mark.reason), mark.reason
    assert mark.reason.isprintable() and len(mark.reason) < 300


@pytest.mark.parametrize(('name', 'right', 'other'), [
    ('friction', TORQUE, TORQUE.replace('return', 'given =')
     + '\n    qd[:], viscous[:], coulomb[:] = 0.0, 7.0, 1.0\n    return given'),
    ('friction', TORQUE, TORQUE.replace('return', 'OUT[:] =') + '\n    return OUT\n\n\n'
     'OUT = np.zeros(6)'),
    ('contact', 'return self.estimate', 'q[:], qd[:], effort[:] = 1.0, 2.0, 3.0\n'
     '        return self.estimate'),
    ('computed_torque', 'return stamp, M @ a + C @ qd + g', 'found = M @ a + C @ qd + g\n'
     '        q[:], qd[:], q_ref[:], qd_ref[:], qdd_ref[:] = 1.0, 2.0, 3.0, 4.0, 5.0\n'
     '        return stamp, found'),
], ids=['inputs', 'its own output again', 'states', 'states and reference'])
def test_a_solution_may_change_what_it_is_given_and_what_it_gave(tmp_path, name, right, other):
    text = (SOLUTIONS / f'{name}.py').read_text(encoding='utf-8')
    assert text.count(right) == 1
    file = solution(tmp_path, text.replace(right, other))
    marks = judge(exercise_named(name), str(file), 0)['marks']
    assert [mark for mark in marks if mark.points < mark.of] == []


def test_a_wrong_signature_costs_its_line(tmp_path):
    file = solution(tmp_path, 'def friction_torque(qd):\n    return qd\n')
    marks = judge(exercise_named('friction'), str(file), 0)['marks']
    assert 'takes 1 positional argument but 3 were given' in marks[0].reason


def test_one_line_that_raises_costs_only_that_line(tmp_path):
    text = (SOLUTIONS / 'friction.py').read_text(encoding='utf-8')
    text = text.replace('viscous, coulomb = [], []', 'viscous = 1 / 0')
    marks = {mark.line: mark for mark in grade('friction', solution(tmp_path, text)).marks}
    assert marks['torque'].points == 4.0
    assert marks['fit'].points == 0.0
    assert 'ZeroDivisionError' in marks['fit'].reason


def test_the_command_says_points_by_line_and_its_exit_code_is_the_verdict(tmp_path):
    command = partial(Command(tmp_path), 'grade')
    document = tmp_path / 'grade.json'
    right = command('friction', SOLUTIONS / 'friction.py', '--seed', 3, '--json', document)
    assert right.code == 0
    assert '10 of 10 points' in right.out
    assert json.loads(document.read_text(encoding='utf-8'))['full'] is True
    wrong = command('friction', solution(tmp_path, 'x = 1\n'))
    assert wrong.code == 1
    assert '0/4  torque: there is no function friction_torque' in wrong.out


def test_an_unknown_exercise_and_a_missing_file_are_bad_input(tmp_path):
    command = partial(Command(tmp_path), 'grade')
    assert command('cooking', SOLUTIONS / 'friction.py').code == 2
    missing = command('friction', tmp_path / 'none.py')
    assert missing.code == 2
    assert 'no file' in missing.err and missing.err.count('\n') == 1
    folder = command('friction', tmp_path)
    assert folder.code == 2
    assert 'is a folder' in folder.err and folder.err.count('\n') == 1
    with pytest.raises(InputError, match="unknown exercise 'cooking'; give one of: kinematics"):
        grade('cooking', SOLUTIONS / 'friction.py')


@pytest.mark.parametrize('name', EXERCISES)
def test_a_starter_file_can_be_judged_and_earns_less_than_a_solution(name):
    found = judge(exercise_named(name), str(STARTERS / f'{name}.py'), 0)
    assert found['why'] == ''
    assert any(mark.points < mark.of for mark in found['marks'])
