"""One built copy of the package per session: source tree, wheel, environments."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def clean_environment() -> dict[str, str]:
    """Return the environment of a user: no trace of the process that runs the tests."""
    dropped = ('PYTHON', 'COV_', 'COVERAGE', 'PYTEST', 'AMENT_', 'COLCON_', '_ROS_WHEELS', 'ROS_',
               'LD_LIBRARY_PATH', 'VIRTUAL_ENV', 'MAKE')
    return {name: value for name, value in os.environ.items() if not name.startswith(dropped)}


def run(command: list, cwd: Path, path: Path | None = None, **more: str):
    """Run a command in ``cwd`` with ``path`` first in PATH; return the completed process."""
    environment = clean_environment() | more
    if path is not None:
        environment['PATH'] = f'{path}{os.pathsep}{environment["PATH"]}'
    return subprocess.run([str(part) for part in command], cwd=cwd, env=environment, text=True,
                          capture_output=True, stdin=subprocess.DEVNULL, timeout=120)


def succeed(command: list, cwd: Path, path: Path | None = None, **more: str) -> str:
    """Run a command that has to end with 0; return what it printed."""
    done = run(command, cwd, path, **more)
    assert done.returncode == 0, f'{command}\n{done.stdout}\n{done.stderr}'
    return done.stdout


def tracked_files() -> list[str]:
    """Return the files of the repository; of the folder where there is no git."""
    listed = run(['git', 'ls-files', '--cached', '--others', '--exclude-standard'], ROOT)
    if listed.returncode == 0:
        return [name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]
    own = ('.venv', 'build', 'dist', 'install', 'log')
    return [str(path.relative_to(ROOT)) for path in ROOT.rglob('*')
            if path.is_file() and path.relative_to(ROOT).parts[0] not in own]


@pytest.fixture(scope='session')
def tracked() -> list[str]:
    """Return the files of the repository."""
    return tracked_files()


@pytest.fixture(scope='session')
def source(tracked, tmp_path_factory) -> Path:
    """Return a copy of the source tree, so that building leaves nothing in the checkout."""
    copy = tmp_path_factory.mktemp('source') / 'ur5_ros'
    for name in tracked:
        target = copy / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target)
    return copy


@pytest.fixture(scope='session')
def distributions(source, tmp_path_factory) -> Path:
    """Return the folder with the wheel and the source archive."""
    out = tmp_path_factory.mktemp('dist')
    succeed([sys.executable, '-m', 'build', '--no-isolation', '--outdir', out, source], out)
    return out


@pytest.fixture(scope='session')
def wheel(distributions) -> Path:
    """Return the built wheel."""
    return next(distributions.glob('*.whl'))


def make_environment(folder: Path) -> Path:
    """
    Return a new environment that sees this one's dependencies and is without ur5_ros.

    The dependencies come in by a link per package, so that nothing is fetched or copied and the
    editable install of this environment does not leak.
    """
    venv.create(folder, with_pip=False, symlinks=True)
    own = shutil.ignore_patterns('ur5_ros*', '__editable__*', '__pycache__', 'a1_coverage*')
    packages = Path(sysconfig.get_path('purelib'))
    for path in packages.iterdir():
        if not own(str(packages), [path.name]):
            (folder / packages.relative_to(sys.prefix) / path.name).symlink_to(path)
    # the ROS wheels put their libraries and index entries beside Python's packages
    for path in (Path(sys.prefix) / 'lib').glob('*.so*'):
        (folder / 'lib' / path.name).symlink_to(path)
    shutil.copytree(Path(sys.prefix) / 'share', folder / 'share', copy_function=os.symlink,
                    ignore=own, dirs_exist_ok=True)
    return folder


@pytest.fixture(scope='session')
def installed(wheel, tmp_path_factory) -> Path:
    """Return the prefix of an environment with the wheel in it."""
    prefix = make_environment(tmp_path_factory.mktemp('wheel') / 'env')
    succeed([sys.executable, '-m', 'pip', '--python', prefix / 'bin' / 'python', 'install',
             '--no-deps', '--no-index', '--ignore-installed', wheel], prefix)
    return prefix


def colcon_workspace(source: Path, folder: Path, *options: str) -> Path:
    """Build a workspace with colcon; return its install prefix of the package."""
    (folder / 'src').mkdir(parents=True)
    shutil.copytree(source, folder / 'src' / 'ur5_ros')
    succeed([sys.executable, '-m', 'colcon', 'build', *options], folder,
            Path(sys.executable).parent)
    return folder / 'install' / 'ur5_ros'


@pytest.fixture(scope='session', params=[(), ('--symlink-install',)],
                ids=['copied', 'symlinked'])
def colcon(request, source, tmp_path_factory) -> Path:
    """Return the colcon install prefix, once copied and once symlinked."""
    return colcon_workspace(source, tmp_path_factory.mktemp('ws') / 'ws', *request.param)


@pytest.fixture(scope='session')
def call():
    """Return :func:`succeed` to tests, which cannot import this file."""
    return succeed


@pytest.fixture
def empty_env(tmp_path) -> Path:
    """Return an environment with the dependencies alone."""
    return make_environment(tmp_path / 'env')
