"""The public Python API: loaded when used, described whole, every example true."""

import doctest
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest

import ur5_ros

ROOT = Path(__file__).resolve().parents[2]
#: What a process may have imported when `import ur5_ros` is over, beside the standard library.
HEAVY = ('numpy', 'numba', 'pybullet', 'rclpy', 'msgspec', 'yaml', 'plotly', 'mcap')


def test_the_package_by_itself_loads_nothing_else():
    code = (f'import sys\nimport ur5_ros\n'
            f'print([name for name in sys.modules if name.startswith({("ur5_ros.", *HEAVY)!r})])')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == '[]'


def test_the_model_loads_neither_simulator_nor_ros():
    code = ('import sys\nfrom ur5_ros import Controller, gravity_torque, load_run\n'
            'print([name for name in ("rclpy", "pybullet", "viser") if name in sys.modules])')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == '[]'


def test_a_name_that_is_not_public_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'simulate'"):
        _ = ur5_ros.simulate
    assert set(ur5_ros.__all__) <= set(dir(ur5_ros))


def test_type_checkers_see_what_the_interpreter_loads(tmp_path):
    lines = [f'reveal_type(ur5_ros.{name})' for name in ur5_ros.__all__]
    (tmp_path / 'user.py').write_text('\n'.join(['import ur5_ros', *lines, '']), 'utf-8')
    done = subprocess.run(
        [sys.executable, '-m', 'mypy', '--strict', '--follow-imports=silent',
         f'--cache-dir={tmp_path / "cache"}', 'user.py'],
        cwd=tmp_path, capture_output=True, text=True, env=os.environ | {'MYPYPATH': str(ROOT)})
    revealed = [line for line in done.stdout.splitlines() if 'Revealed type' in line]
    assert len(revealed) == len(ur5_ros.__all__), done.stdout
    assert done.returncode == 0 and '"Any"' not in done.stdout, done.stdout


@pytest.mark.parametrize('name', [name for name in ur5_ros.__all__ if name != 'JOINT_NAMES'])
def test_the_example_of_a_name_runs_and_prints_what_it_says(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = inspect.getdoc(getattr(ur5_ros, name))
    example = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    assert any(f' {name}' in each.source for each in example.examples), 'no example'
    report = []
    doctest.DocTestRunner(optionflags=doctest.REPORT_NDIFF).run(example, out=report.append)
    assert not report, ''.join(report)
