"""What a person types who meets a node for the first time: --help, and one parameter set."""

import subprocess
import sys
from pathlib import Path

import pytest

from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS

BIN = Path(sys.executable).parent


def run(*command: str, env=None) -> subprocess.CompletedProcess:
    return subprocess.run([str(BIN / command[0]), *command[1:]], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=60, env=env)


@pytest.mark.parametrize(('program', 'parameters'), [
    ('sim_node', SIM_PARAMETERS), ('control_node', CONTROL_PARAMETERS)])
@pytest.mark.parametrize('option', ['--help', '-h'])
def test_help_names_every_parameter_within_eighty_columns(program, parameters, option):
    done = run(program, option)
    assert (done.returncode, done.stderr) == (0, '')
    assert max(map(len, done.stdout.splitlines())) <= 80
    for parameter in parameters:
        assert f'\n  {parameter.name}: ' in done.stdout


def test_help_may_be_read_in_part():
    done = subprocess.run(['bash', '-c', f'{BIN}/sim_node --help | head -n 1'], timeout=60,
                          capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert done.stdout.startswith('usage: sim_node ') and done.stderr == ''


def test_a_parameter_of_a_running_node_is_set_and_refusals_are_one_line(ros):
    ros.start('sim', lockstep=False, bag='')
    environment = dict(ros.environment)
    done = run('ur5', 'set', 'ur5_sim', 'payload.mass', '2.0', env=environment)
    assert (done.returncode, done.stdout) == (0, 'ur5_sim payload.mass: 2.0\n'), done.stderr
    for arguments, words in ((('payload.mass', '-1'), 'payload.mass'),
                             (('payload.weight', '1'), 'has no parameter')):
        done = run('ur5', 'set', 'ur5_sim', *arguments, env=environment)
        assert done.returncode == 2 and words in done.stderr and done.stderr.count('\n') == 1


def test_a_node_that_is_not_there_is_named_with_those_that_are(ros):
    done = run('ur5', 'set', '/nowhere', 'payload.mass', '2.0', env=dict(ros.environment))
    assert done.returncode == 2 and 'no node /nowhere answers' in done.stderr
