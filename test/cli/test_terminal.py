"""On a terminal of 80 columns every command is readable: whole words, units, what to do next."""

import re

import pytest
from pseudo_terminal import written

from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.run_config import run_config


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a run of each kind that the commands below read."""
    folder = tmp_path_factory.mktemp('terminal')
    run_closed_loop(run_config('exciting', duration=12.0), folder / 'bags/exciting')
    run_closed_loop(run_config('joint_step', duration=1.0), folder / 'bags/short')
    run_closed_loop(run_config('joint_step', duration=1.0, sim={'payload.mass': 2.0}),
                    folder / 'bags/loaded')
    return folder


def shown(folder, *arguments, columns: int = 80) -> list[str]:
    """Return the lines that a command leaves on a terminal of this width."""
    printed = written(*arguments, folder=folder, columns=columns, NO_COLOR='1')
    after_bars = printed.rpartition('\x1b[2K')[2]  # a bar erases itself
    text = re.sub(r'\x1b\[[0-9;?]*[a-zA-Z]', '', after_bars).replace('\r\n', '\n')
    lines = [line.rpartition('\r')[2].rstrip() for line in text.splitlines()]
    return [line for line in lines if line]


@pytest.mark.parametrize('command', [
    ('validate', 'bags/short'), ('validate', 'bags/loaded'), ('compare', 'bags/short',
                                                              'bags/loaded'),
    ('resimulate', 'bags/short'), ('recontrol', 'bags/loaded'), ('arm',), ('experiments',),
    ('urdf', '--arm', 'ur6'), ('validate', 'nowhere'), ('view', 'bags/short', '--port', '-1'),
    ('recover', 'bags/short/sim'), ('validate', '--all', 'bags'),
    ('validate', 'bags/short', '--arm', 'nothing'), ('grade',), ('sweep', 'absent.yaml')])
def test_no_line_is_wider_than_the_terminal_and_no_word_is_cut(folder, command):
    lines = shown(folder, *command)
    assert lines
    assert max(map(len, lines)) <= 80, [line for line in lines if len(line) > 80]
    assert not [line for line in lines if '…' in line]
    assert not re.search(r'\d\.\d{7,}', ' '.join(lines)), 'three or four digits'


def test_identify_shows_values_with_errors_and_units_and_the_next_command(folder):
    lines = shown(folder, 'identify', 'bags/exciting')
    assert max(map(len, lines)) <= 80 and not [line for line in lines if '…' in line]
    head = ' '.join(line for line in lines if '[' in line)
    for unit in ('s/rad]', '[N m]', 'm]'):
        assert unit in head
    row = next(line for line in lines if line.startswith('wrist 2 '))
    assert len(row.split()) >= 7, 'a value in every column'
    mass = next(line for line in lines if line.startswith('m2 '))
    assert re.fullmatch(r'm2 +\d\.\d+( \+- \S+)? +kg', mass)
    assert lines[-1].startswith('#') or lines[-1].startswith('next: ur5 ')
    assert [line for line in lines if line.startswith('next: ur5 identify bags/exciting -o')]


def test_the_cause_comes_first_and_the_next_command_last(folder):
    lines = shown(folder, 'validate', 'bags/loaded')
    assert lines[0].startswith('cause: 2 ') and 'kg at the tool' in ' '.join(lines[:2])
    assert lines[-1].startswith('next: ur5 validate bags/loaded --html ')


def test_the_next_command_judges_by_what_was_given(folder):
    given = ('--arm', 'ur5_real', '--reference', '0,-1,1,0,1,0')
    lines = shown(folder, 'validate', 'bags/short', *given, columns=200)
    assert lines[-1].startswith(f'next: ur5 validate bags/short {" ".join(given)} --html ')
    lines = shown(folder, 'validate', 'bags/short', *given, '--html', 'report.html', columns=200)
    assert lines[-1].startswith('next: ur5 view bags/short --arm ur5_real ')


def test_a_complaint_is_wrapped_at_blanks_on_a_terminal_and_one_line_in_a_file(folder, ur5):
    lines = shown(folder, 'urdf', '--arm', 'ur6')
    assert len(lines) > 2 and lines[0].startswith("ur5: unknown arm 'ur6'; ")
    assert ' '.join(lines) == ur5('urdf', '--arm', 'ur6').err.rstrip('\n')
