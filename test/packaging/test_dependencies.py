"""What the package imports is declared: to rosdep where there is a key, to pip in any case."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.config import topics
from ur5_ros.config.distributions import providers

ROOT = Path(__file__).resolve().parents[2]
DECLARED = {each.text for each in
            ElementTree.parse(ROOT / 'package.xml').getroot().iter('exec_depend')}
SETUP = (ROOT / 'setup.py').read_text(encoding='utf-8')
#: Imported name to rosdep key (rosdep/python.yaml of ros/rosdistro), where there is one whose
#: version in Ubuntu 24.04 serves.
ROSDEP = {'numpy': 'python3-numpy', 'yaml': 'python3-yaml', 'rich': 'python3-rich',
          'sympy': 'python3-sympy', 'PIL': 'python3-pil'}
#: Imported name to the distribution of PyPI, where they differ.
PIP = {'yaml': 'pyyaml', 'PIL': 'pillow', 'cvxpy': 'cvxpy-base', 'distributed': 'dask',
       'imageio_ffmpeg': 'imageio-ffmpeg'}
#: Packages of ROS that are no messages.
OF_ROS = {'rclpy', 'launch', 'launch_ros', 'ament_index_python'}


def imported() -> set[str]:
    """Return the packages that the product's files import, or name as message types."""
    found = {each.type.partition('/')[0] for declared in vars(topics).values()
             if isinstance(declared, tuple) for each in declared if isinstance(each, topics.Topic)}
    for folder in ('ur5_ros', 'launch'):
        for path in (ROOT / folder).rglob('*.py'):
            for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
                names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
                if isinstance(node, ast.ImportFrom) and node.level == 0:
                    names = [node.module]
                found |= {name.partition('.')[0] for name in names}
    return found - set(sys.stdlib_module_names) - {'ur5_ros'}


def is_of_ros(name: str) -> bool:
    return name in OF_ROS or name.endswith(('_msgs', '_srvs', '_interfaces'))


def test_every_ros_package_that_is_imported_is_declared():
    missing = {name for name in imported() if is_of_ros(name)} - DECLARED
    assert not missing, f'package.xml does not name {missing}'


def test_every_python_package_that_is_imported_is_declared():
    for name in imported():
        if is_of_ros(name):
            continue
        assert name not in ROSDEP or ROSDEP[name] in DECLARED, f'package.xml lacks {ROSDEP[name]}'
        assert re.search(rf"['\"]{re.escape(PIP.get(name, name))}\b", SETUP, re.IGNORECASE), (
            f'setup.py lacks {name}')


def test_nothing_is_declared_that_has_no_key_or_is_not_needed():
    packages = {name for name in imported() if is_of_ros(name)}
    assert DECLARED - packages - set(ROSDEP.values()) <= {
        'builtin_interfaces', 'robot_state_publisher', 'rviz2'}, 'what no rosdep key is known for'


def test_the_locks_hold_for_every_python_that_is_supported():
    for name in ('runtime', 'all'):
        lines = (ROOT / f'requirements/{name}.txt').read_text(encoding='utf-8').splitlines()
        marked = [line for line in lines if ';' in line]
        assert [line.partition('==')[0] for line in marked] == ['pybullet', 'pybullet-arm64']
        assert marked[0].endswith("; python_version < '3.12'")
        assert marked[1].endswith("; python_version >= '3.12'")
    assert "python_requires='>=3.11'" in SETUP


def test_the_fingerprint_names_the_distribution_that_provides_pybullet():
    found = providers('pybullet')
    assert len(found) == 1
    try:
        assert fingerprint()['pybullet'] == version('pybullet')
    except PackageNotFoundError:
        assert fingerprint()['pybullet'] == f'pybullet-arm64 {version("pybullet-arm64")}'


def test_two_providers_of_pybullet_are_refused_in_one_line(tmp_path, monkeypatch):
    """pip lets both in, and the later one overwrites the files of the other."""
    for name in ('pybullet', 'pybullet_arm64'):
        folder = tmp_path / f'{name}-9.9.dist-info'
        folder.mkdir()
        (folder / 'METADATA').write_text(
            f'Metadata-Version: 2.1\nName: {name.replace("_", "-")}\nVersion: 9.9\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    assert providers('pybullet') == ['pybullet 9.9', 'pybullet-arm64 9.9']
    monkeypatch.delitem(sys.modules, 'ur5_ros.sim.pybullet_import', raising=False)
    import importlib

    from ur5_ros.errors import InputError
    with pytest.raises(InputError, match='pip uninstall pybullet pybullet-arm64') as refused:
        importlib.import_module('ur5_ros.sim.pybullet_import')
    assert '\n' not in str(refused.value)
