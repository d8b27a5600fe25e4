"""Wheel, colcon build, editable install and archive: each gives what a user expects to find."""

import os
import re
import shlex
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from ur5_ros import __version__

ROOT = Path(__file__).resolve().parents[2]
EXECUTABLES = ('sim_node', 'control_node', 'ur5')
# as fast as it goes, without a controller, without a bag: 20 periods and an orderly end
SHORT_RUN = ('--ros-args', '-p', 'lockstep:=false', '-p', 'realtime_factor:=0.0', '-p',
             'stop_after:=0.02', '-p', "bag:=''")
WHERE = 'from ur5_ros.config import config_folder; print(config_folder())'


def expected_share(source: Path) -> set[str]:
    """Return the names below share/ur5_ros that the source tree says must be there."""
    names = {'package.xml'}
    for pattern in ('config/*.*', 'config/*/*.*', 'launch/*.launch.py'):
        names |= {str(path.relative_to(source)) for path in source.glob(pattern)}
    return {name for name in names if '__pycache__' not in name}


def check_share(prefix: Path, source: Path) -> None:
    index = prefix / 'share/ament_index/resource_index/packages/ur5_ros'
    assert index.is_file()
    share = prefix / 'share/ur5_ros'
    missing = [name for name in sorted(expected_share(source)) if not (share / name).is_file()]
    assert not missing
    for name in EXECUTABLES:
        assert os.access(prefix / 'lib/ur5_ros' / name, os.X_OK), name


def test_a_wheel_installs_marker_package_xml_config_launch_and_executables(installed, source):
    check_share(installed, source)


def test_every_installed_command_of_a_wheel_runs_from_an_empty_folder(installed, tmp_path, call):
    for folder in ('bin', 'lib/ur5_ros'):
        printed = call([installed / folder / 'ur5', '--version'], tmp_path, installed / 'bin')
        assert printed.split() == ['ur5', __version__]
        call([installed / folder / 'sim_node', *SHORT_RUN], tmp_path, installed / 'bin',
             ROS_DOMAIN_ID='171')
    assert not list(tmp_path.iterdir())


def test_a_wheel_reads_its_own_config(installed, tmp_path, call):
    printed = call([installed / 'bin/python', '-c', WHERE], tmp_path)
    assert Path(printed.strip()) == (installed / 'share/ur5_ros/config').resolve()


def test_a_wheel_holds_the_package_and_no_tests(wheel, source):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    modules = {str(path.relative_to(source)) for path in (source / 'ur5_ros').rglob('*.py')}
    assert modules <= set(names)
    assert 'ur5_ros/py.typed' in names
    tops = {name.split('/')[0] for name in names}
    assert {top for top in tops if not top.startswith('ur5_ros-')} == {'ur5_ros'}


def test_colcon_builds_what_ros2_run_and_launch_look_for(colcon, source, tmp_path, call):
    check_share(colcon, source)
    setup = shlex.quote(str(colcon.parent / 'setup.bash'))
    for name, arguments in (('ur5', ('--version',)), ('sim_node', SHORT_RUN)):
        command = shlex.join([str(colcon / 'lib/ur5_ros' / name), *arguments])
        call(['bash', '-c', f'source {setup} && {command}'], tmp_path,
             Path(sys.executable).parent, ROS_DOMAIN_ID='172')
    where = call(['bash', '-c', f'source {setup} && cd / && python3 -c {shlex.quote(WHERE)}'],
                 tmp_path, Path(sys.executable).parent)
    assert Path(where.strip()).is_relative_to(colcon.parent.parent)


def test_an_editable_install_reads_the_config_of_the_checkout(source, tmp_path, call, empty_env):
    call([sys.executable, '-m', 'pip', '--python', empty_env / 'bin/python', 'install',
          '--no-deps', '--no-build-isolation', '--no-index', '--ignore-installed', '-e', source],
         tmp_path)
    printed = call([empty_env / 'bin/python', '-c', WHERE], tmp_path)
    assert Path(printed.strip()) == source / 'config'
    printed = call([empty_env / 'bin/ur5', '--version'], tmp_path)
    assert printed.split() == ['ur5', __version__]


def test_the_source_archive_holds_every_file_of_the_repository(distributions, tracked):
    with tarfile.open(next(distributions.glob('*.tar.gz'))) as archive:
        names = {name.partition('/')[2] for name in archive.getnames()}
    left_out = {name for name in tracked
                if not name.startswith(('.github/', '.gitignore')) and name not in names}
    assert not left_out


def test_package_xml_setup_py_changelog_and_citation_agree_on_the_version():
    texts = {
        'package.xml': r'<version>([^<]+)</version>',
        'setup.py': r"version='([^']+)'",
        'CITATION.cff': r'(?m)^version: (\S+)$',
        'CHANGELOG.rst': r'(?m)^(\d+\.\d+\.\d+)',
    }
    for name, pattern in texts.items():
        found = re.search(pattern, (ROOT / name).read_text(encoding='utf-8'))
        assert found and found[1] == __version__, name


@pytest.mark.parametrize('name', ['runtime.txt', 'all.txt'])
def test_a_lock_names_plain_versions_and_nothing_of_where_they_come_from(name):
    lines = (ROOT / 'requirements' / name).read_text(encoding='utf-8').splitlines()
    pins = [line for line in lines if not line.startswith('#')]
    assert pins and all(re.fullmatch(r'[A-Za-z0-9._-]+==[A-Za-z0-9.+!]+'
                                 r"(; python_version [<>]=? '3\.\d+')?", pin) for pin in pins)
    names = [pin.partition('==')[0] for pin in pins]
    assert len(names) == len(set(names)), 'a package is named once'


def test_the_runtime_lock_is_part_of_the_whole_lock():
    runtime, everything = (
        set((ROOT / 'requirements' / name).read_text(encoding='utf-8').splitlines()[2:])
        for name in ('runtime.txt', 'all.txt'))
    assert runtime < everything
