"""What the package declares to pip and colcon alike."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'ur5_ros'
# colcon build --symlink-install runs a link to this file in a folder that has not everything
HERE = Path(__file__).resolve().parent


def shared(folder: str, pattern: str) -> tuple[str, list[str]]:
    """Return a data_files entry that installs ``folder`` below the share folder."""
    files = sorted(path for path in (HERE / folder).glob(pattern) if path.is_file())
    return (f'share/{PACKAGE}/{folder}', [str(path.relative_to(HERE)) for path in files])


setup(
    name=PACKAGE,
    version='0.2.0',
    description='Simulated torque control of Universal Robots arms in ROS 2, with evidence',
    long_description=(HERE / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    author='ur5_ros maintainers',
    author_email='maintainers@users.noreply.h-seed-7fe2c4e5.example',
    maintainer='ur5_ros maintainers',
    maintainer_email='maintainers@users.noreply.h-seed-7fe2c4e5.example',
    license='Apache-2.0',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={PACKAGE: ['py.typed', '**/*.html', '**/*.js', '**/*.css', '**/*.msg']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        shared('config', '*.*'),
        shared('config/arms', '*.yaml'),
        shared('config/experiments', '*.yaml'),
        shared('config/worlds', '*.yaml'),
        shared('config/presets', '*.yaml'),
        shared('config/sweeps', '*.yaml'),
        shared('config/layouts', '*.*'),
        shared('launch', '*.launch.py'),
        # ros2 run and launch look for executables here; pip puts console scripts into bin/ alone.
        (f'lib/{PACKAGE}', ['scripts/sim_node', 'scripts/control_node',
                            'scripts/closed_loop', 'scripts/ur5']),
    ],
    entry_points={'console_scripts': [
        'sim_node = ur5_ros.nodes.sim_node:main',
        'control_node = ur5_ros.nodes.control_node:main',
        'closed_loop = ur5_ros.nodes.closed_loop:main',
        'ur5 = ur5_ros.cli:main',
    ]},
    python_requires='>=3.11',
    install_requires=[
        'lz4>=4.3',
        'mcap>=1.6',
        'msgspec>=0.19',
        'numba>=0.60',
        'numpy>=1.26',
        'plotly>=6',
        # the second is a fork of the first with wheels: docs/decisions/pybullet_wheel.md
        "pybullet>=3.2.6; python_version < '3.12'",
        "pybullet-arm64>=3.2.8; python_version >= '3.12'",
        'pyyaml>=6',
        'rich>=13',
        'ruckig>=0.14',
        'typer>=0.29',
        'zstandard>=0.22',
    ],
    extras_require={
        # rclpy and the messages from PyPI, for a machine without a ROS 2 installation
        'ros': ['ros-jazzy-rclpy[fastrtps]', 'ros-jazzy-common-interfaces'],
        'identify': ['clarabel>=0.10', 'cvxpy-base>=1.6'],
        'symbolic': ['sympy>=1.12'],
        'sweep': ['dask[distributed]>=2024.8', 'polars>=1'],
        # what runs docs/course/*.ipynb; docs/decisions/notebooks.md
        'notebooks': ['ipykernel', 'matplotlib>=3.8', 'nbclient', 'nbformat'],
        'export': ['polars>=1', 'rerun-sdk>=0.24'],
        'view': ['viser>=1.1', 'imageio-ffmpeg>=0.5', 'pillow>=10', 'trimesh>=4'],
        'bench': ['eaik>=1.2', 'mujoco[sysid]>=3', 'pin>=3', 'rosbags>=0.10',
                  'mcap-ros2-support>=0.5', 'mcap-ros2-support-fast>=0.8', 'ssik>=8', 'urchin'],
        'test': ['colcon-common-extensions', 'hypothesis', 'import-linter', 'mypy', 'psutil',
                 'pre-commit', 'pytest', 'pytest-cov', 'pytest-timeout', 'pytest-xdist', 'ruff',
                 'types-pyyaml', 'build'],
        'docs': ['mkdocs-material'],
    },
    zip_safe=False,
)
