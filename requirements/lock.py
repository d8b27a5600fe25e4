"""Write runtime.txt and all.txt: every package with its version, as pip resolves them here."""

import argparse
import json
import subprocess
import sys
import tempfile
from importlib.metadata import requires
from pathlib import Path

from packaging.requirements import Requirement

HERE = Path(__file__).resolve().parent
# colcon-core refuses newer setuptools
ALWAYS = ['setuptools<80', 'pip']
#: Newest interpreter that the locks are for.
NEWEST = '3.13'
EXTRAS = {
    'runtime': 'ros,view,identify',
    'all': 'ros,view,identify,symbolic,sweep,bench,export,notebooks,test,docs',
}
HEADER = """\
# Locked by requirements/lock.py (make lock) for Linux x86-64, CPython 3.11 to 3.13.
# Extras: {extras}
"""


def marked(named: dict[str, str]) -> dict[str, str]:
    """
    Return the lines of requirements that hold for some interpreters only, by package.

    What this interpreter needs is in ``named``; the version of what others need is asked for.
    """
    lines = {}
    for text in requires('ur5_ros') or ():
        requirement = Requirement(text)
        marker = str(requirement.marker or '')
        if 'python_version' not in marker or 'extra' in marker:
            continue
        version = named.get(requirement.name) or newest(requirement)
        lines[requirement.name] = f'{requirement.name}=={version}; {marker}'.replace('"', "'")
    return lines


def newest(requirement: Requirement) -> str:
    """Return the newest version with a wheel for the newest interpreter."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / 'report.json'
        subprocess.run(
            [sys.executable, '-m', 'pip', 'install', '--quiet', '--dry-run', '--no-deps',
             '--python-version', NEWEST, '--only-binary=:all:', '--target', folder,
             '--report', str(report), f'{requirement.name}{requirement.specifier}'], check=True)
        [package] = json.loads(report.read_text(encoding='utf-8'))['install']
    return str(package['metadata']['version'])


def resolve(extras: str, constraints: Path | None) -> list[str]:
    """Return ``name==version`` of the package's dependencies with the given extras."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / 'report.json'
        subprocess.run(
            [sys.executable, '-m', 'pip', 'install', '--quiet', '--dry-run', '--ignore-installed',
             '--no-build-isolation', '--report', str(report), *ALWAYS,
             *(['--constraint', str(constraints)] if constraints else []),
             f'{HERE.parent}[{extras}]'], check=True)
        packages = json.loads(report.read_text(encoding='utf-8'))['install']
    named = {package['metadata']['name']: package['metadata']['version'] for package in packages}
    named.pop('ur5_ros', None)
    lines = {name: f'{name}=={version}' for name, version in named.items()} | marked(named)
    return [lines[name] for name in sorted(lines, key=str.lower)]


def main() -> None:
    """Write the two files; all.txt first, so that runtime.txt is a part of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--constraint', type=Path, help='versions to keep to')
    arguments = parser.parse_args()
    constraints = arguments.constraint
    for name in ('all', 'runtime'):
        path = HERE / f'{name}.txt'
        lines = resolve(EXTRAS[name], constraints)
        path.write_text(HEADER.format(extras=EXTRAS[name]) + '\n'.join(lines) + '\n',
                        encoding='utf-8')
        constraints = HERE / 'all.txt'
        print(f'{path}: {len(lines)} packages')


if __name__ == '__main__':
    main()
