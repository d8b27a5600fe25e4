"""Write runtime.txt and all.txt: every package with its version, as pip resolves them here."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
# colcon-core refuses newer setuptools
ALWAYS = ['setuptools<80', 'pip']
EXTRAS = {
    'runtime': 'ros,view,identify',
    'all': 'ros,view,identify,symbolic,sweep,bench,test,docs',
}
HEADER = """\
# Locked by requirements/lock.py (make lock) for Linux x86-64, CPython 3.11.
# Extras: {extras}
"""


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
    return [f'{name}=={named[name]}' for name in sorted(named, key=str.lower)]


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
