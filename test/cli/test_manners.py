"""Help fits a screen, errors fit a line, and the exit code says which kind of no it was."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pseudo_terminal import written

from ur5_ros.cli.run import run

COMMANDS = ('demo', 'warm-up', 'validate', 'compare', 'replay', 'resimulate', 'recontrol',
            'import', 'identify', 'excite', 'recover', 'sweep', 'view', 'render', 'urdf', 'arm',
            'experiments', 'set', 'export', 'bench', 'grade')


def test_help_of_every_command_fits_one_screen(ur5):
    whole = ur5('--help')
    assert whole.code == 0
    assert all(f'\n  {command} ' in whole.out for command in COMMANDS)
    assert whole.out.count('\n') <= len(COMMANDS) + 13, 'one line a command'
    for text in (ur5(command, '--help').out for command in COMMANDS):
        assert 4 < text.count('\n') <= 23, 'a terminal of 24 lines, and the prompt'
        assert max(map(len, text.splitlines())) <= 80
    assert max(map(len, whole.out.splitlines())) <= 80


@pytest.mark.parametrize('chosen,threads', [({}, '1'), ({'OPENBLAS_NUM_THREADS': '3'}, '3')])
def test_blas_has_one_thread_unless_the_user_chose(chosen, threads):
    code = ("import os, sys; sys.argv = ['ur5', 'arm']; import atexit; from ur5_ros.cli import "
            "main; atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'])); main()")
    environment = {key: value for key, value in os.environ.items()
                   if key != 'OPENBLAS_NUM_THREADS'} | chosen
    done = subprocess.run([sys.executable, '-c', code], text=True, capture_output=True,
                          env=environment, timeout=60)
    assert done.returncode == 0 and done.stdout.splitlines()[-1] == threads


def test_help_imports_no_simulator_no_ros_and_no_compiler():
    code = ('import sys\nfrom ur5_ros.cli.run import run\nrun(["--help"])\n'
            'slow = {"rclpy", "numba", "pybullet", "plotly", "distributed", "polars", "numpy"}\n'
            'sys.exit(",".join(slow & set(sys.modules)) or 0)')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize('command', ['arm', 'experiments'])
def test_what_comes_with_the_package_is_listed_a_line_each(ur5, command):
    from ur5_ros.config import config_folder
    folder = config_folder() / {'arm': 'arms', 'experiments': 'experiments'}[command]
    out = ur5(command).out
    names = [path.stem for path in folder.glob('*.yaml')]
    for name in names:
        assert sum(line.startswith(f'{name} ') for line in out.splitlines()) == 1
    assert out.count('\n') <= len(names) + 3
    assert out.splitlines()[-1].startswith('next: ur5 demo --')


def test_a_defect_of_the_package_is_no_verdict(monkeypatch, capfd):
    monkeypatch.setattr('ur5_ros.viewer.view', lambda *_: 1 / 0)
    assert run(['view']) == 4
    text = capfd.readouterr().err
    assert len(text.splitlines()) == 1
    assert text.startswith('ur5: internal error (ZeroDivisionError: division by zero); ')
    details = Path(re.search(r'written to (\S+?):? ', text)[1])
    assert 'Traceback' in details.read_text()
    details.unlink()


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
    (('demo', '--control-rate', 'fast'), "--control-rate 'fast'; give a whole number"),
    (('excite', '-o', 'x.yaml', '--seconds', 'long'), "--seconds 'long'; give a number"),
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
    (('view', 'nowhere', '--port', '99999'), '65535'),
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


def test_colours_appear_only_on_a_terminal(ur5):
    plain = ur5('urdf', '--arm', 'ur6')
    assert '\x1b[' not in plain.err
    assert '\x1b[31m' in written('urdf', '--arm', 'ur6')


def test_no_color_is_respected_on_a_terminal(short_run, tmp_path):
    coloured = written('validate', short_run)
    plain = written('validate', short_run, NO_COLOR='1')
    assert '\x1b[32m' in coloured and 'pass' in plain
    assert not re.search(r'\x1b\[[\d;]*3\dm', plain)
    assert '\x1b[' not in written('urdf', '--arm', 'ur6', NO_COLOR='1')


@pytest.mark.parametrize('arguments', [
    ('validate', 'GOLDEN', '--kp', '11'), ('validate', 'GOLDEN', '--control-arm', 'ur5_real'),
    ('compare', 'GOLDEN', 'SHORT'), ('arm',), ('experiments',)], ids=lambda words: ' '.join(words))
def test_sentences_wrap_at_blanks_in_eighty_columns(repo, short_run, arguments):
    folders = {'GOLDEN': str(repo / 'bags/golden'), 'SHORT': str(short_run)}
    words = [folders.get(word, word) for word in arguments]
    text = written(*words, NO_COLOR='1')
    plain = re.sub(r'\x1b\[[^A-Za-z]*[A-Za-z]', '', text).replace('\r\n', '\n')
    # a progress bar goes back to the start of its line
    long = [line for line in plain.replace('\r', '\n').splitlines() if len(line.rstrip()) > 80
            and not any(folder in line for folder in folders.values())]
    assert not long
    assert len(plain.splitlines()) > 3


def test_a_progress_bar_is_drawn_only_on_a_terminal(ur5, short_run, tmp_path):
    picture = 'from ur5_ros.cli.terminal import progress\nwith progress("drawing", 1.0): pass'
    assert 'drawing' in written(script=picture)
    piped = subprocess.run([sys.executable, '-c', picture], capture_output=True, text=True)
    assert piped.stderr == piped.stdout == ''


@pytest.mark.parametrize('shell', ['bash', 'zsh', 'fish'])
def test_completion_can_be_had_for_every_shell(shell):
    done = subprocess.run(
        [sys.executable, '-c', 'import sys; sys.argv[0] = "ur5"\nfrom ur5_ros.cli import main\n'
         'main()'], capture_output=True, text=True,
        env={**os.environ, '_UR5_COMPLETE': f'source_{shell}'})
    assert done.returncode == 0 and 'ur5' in done.stdout, done.stderr


@pytest.mark.parametrize(('typed', 'completed'), [
    ('ur5 re', {'replay', 'resimulate', 'recontrol', 'recover', 'render'}),
    ('ur5 validate --js', {'--json'}),
    ('ur5 demo --arm ur5_', {'ur5_controller', 'ur5_description', 'ur5_kebria2016', 'ur5_real'}),
    ('ur5 demo --experiment keb', {'kebria_fig11'}),
])
def test_a_bash_that_has_the_completion_completes(typed, completed, tmp_path):
    command = tmp_path / 'ur5'
    command.write_text(f'#!{sys.executable}\nfrom ur5_ros.cli import main\nmain()\n')
    command.chmod(0o755)
    script = (f'COMP_WORDS=({typed}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n'
              'eval "$(_UR5_COMPLETE=source_bash ur5)"; _ur5_completion ur5\n'
              'echo "${COMPREPLY[@]}"')
    done = subprocess.run(
        ['bash', '-c', script], capture_output=True, text=True,
        env={**os.environ, 'PATH': f'{tmp_path}{os.pathsep}{os.environ["PATH"]}'})
    assert set(done.stdout.split()) == completed, done.stderr


@pytest.mark.parametrize('shell', ['zsh', 'fish'])
def test_zsh_and_fish_are_answered_too(shell):
    done = subprocess.run(
        [sys.executable, '-c', 'import sys; sys.argv[0] = "ur5"\nfrom ur5_ros.cli import main\n'
         'main()'], capture_output=True, text=True,
        env={**os.environ, '_UR5_COMPLETE': f'complete_{shell}', '_TYPER_COMPLETE_ARGS':
             'ur5 rec', '_TYPER_COMPLETE_FISH_ACTION': 'get-args'})
    assert 'recover' in done.stdout and 'demo' not in done.stdout, done.stderr
