"""Help fits a screen, errors fit a line, and the exit code says which kind of no it was."""

import os
import pty
import subprocess
import sys
import time

import pytest

COMMANDS = ('demo', 'validate', 'compare', 'replay', 'resimulate', 'recontrol', 'import',
            'identify', 'recover', 'sweep', 'view', 'render', 'urdf')


def test_help_of_every_command_fits_one_screen(ur5):
    whole = ur5('--help')
    assert whole.code == 0
    assert all(f'\n  {command} ' in whole.out for command in COMMANDS)
    for text in (whole.out, *(ur5(command, '--help').out for command in COMMANDS)):
        lines = text.splitlines()
        assert 4 < len(lines) <= 30
        assert max(map(len, lines)) <= 80


def test_help_imports_no_simulator_no_ros_and_no_compiler():
    code = ('import sys\nfrom ur5_ros.cli.run import run\nrun(["--help"])\n'
            'slow = {"rclpy", "numba", "pybullet", "plotly", "distributed", "polars", "numpy"}\n'
            'sys.exit(",".join(slow & set(sys.modules)) or 0)')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_version_is_the_packages(ur5):
    from ur5_ros import __version__
    assert ur5('--version') == (0, f'ur5 {__version__}\n', '')


@pytest.mark.fault(34)
@pytest.mark.parametrize('arguments', [
    ('nonsense',), ('demo', '--nonsense'), ('demo', '--control-rate', 'fast'), ('compare', 'a'),
    ('import', 'log.csv'), ('urdf', '--arm'), ('validate', 'a', 'b'),
])
def test_wrong_usage_is_one_line_that_names_the_help(ur5, arguments):
    ended = ur5(*arguments)
    assert ended.code == 2
    assert ended.out == ''
    assert ended.err.count('\n') == 1 and '--help' in ended.err


@pytest.mark.parametrize(('arguments', 'named'), [
    (('demo', '--arm', 'ur6'), 'ur6'),
    (('demo', '--control-arm', 'ur6'), 'ur6'),
    (('demo', '--experiment', 'fig12'), 'fig12'),
    (('demo', '--control-rate', '0'), 'control_rate'),
    (('demo', '--control-rate', '-5'), 'control_rate'),
    (('demo', '--arm', 'ur5_controller'), 'point mass'),
    (('demo', '--run', 'empty'), 'exists'),
    (('validate',), 'ur5 demo'),
    (('validate', 'nowhere'), 'nowhere'),
    (('validate', 'empty'), 'empty'),
    (('validate', '--all', 'nowhere'), 'nowhere'),
    (('validate', '--all', 'empty'), 'empty'),
    (('validate', 'nowhere', '--kp', 'strong'), 'strong'),
    (('validate', 'nowhere', '--kd', '1,2'), '--kd'),
    (('compare', 'nowhere', 'empty'), 'nowhere'),
    (('replay', 'nowhere'), 'nowhere'),
    (('resimulate', 'nowhere'), 'nowhere'),
    (('recontrol', 'empty'), 'empty'),
    (('import', 'nowhere.csv', '--out', 'new'), 'nowhere.csv'),
    (('identify', 'nowhere'), 'nowhere'),
    (('recover', 'nowhere'), 'nowhere'),
    (('recover', 'empty'), 'empty'),
    (('sweep', 'nowhere.yaml'), 'nowhere.yaml'),
    (('sweep', 'report'), 'folder'),
    (('sweep', 'report', 'empty'), 'empty'),
    (('view', 'nowhere'), 'nowhere'),
    (('render', 'nowhere', '-o', 'picture.png'), 'nowhere'),
    (('urdf', '--arm', 'ur6'), 'ur6'),
    (('urdf', '--arm', 'ur5_controller'), 'tensor'),
])
def test_a_users_mistake_is_one_line_and_code_2(ur5, tmp_path, empty, arguments, named):
    ended = ur5(*arguments)
    assert ended.code == 2, ended
    assert ended.err.count('\n') == 1, ended.err
    assert named in ended.err
    assert sorted(path.name for path in tmp_path.rglob('*')) == ['empty']


def test_a_help_screen_cut_by_head_is_no_error():
    done = subprocess.run(
        f'{sys.executable} -c "from ur5_ros.cli import main; main()" urdf | head -1',
        shell=True, capture_output=True, text=True)
    assert done.stderr == '' and done.stdout.startswith('<?xml')


def test_colours_appear_on_a_terminal_alone(ur5):
    plain = ur5('urdf', '--arm', 'ur6')
    assert '\x1b[' not in plain.err
    reader, terminal = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, '-c', 'from ur5_ros.cli import main; main()', 'urdf', '--arm', 'ur6'],
        stderr=terminal, env={**os.environ, 'TERM': 'xterm'})
    try:
        assert child.wait(60) == 2
        assert '\x1b[' in os.read(reader, 10_000).decode()
    finally:
        os.close(terminal)
        os.close(reader)
        if child.poll() is None:
            child.kill()
            time.sleep(0)
            child.wait()


@pytest.mark.parametrize('shell', ['bash', 'zsh', 'fish'])
def test_completion_can_be_had_for_every_shell(shell):
    done = subprocess.run(
        [sys.executable, '-c', 'import sys; sys.argv[0] = "ur5"\nfrom ur5_ros.cli import main\n'
         'main()'], capture_output=True, text=True,
        env={**os.environ, '_UR5_COMPLETE': f'source_{shell}'})
    assert done.returncode == 0 and 'ur5' in done.stdout, done.stderr
