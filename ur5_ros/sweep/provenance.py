"""Which code computed the rows of a sweep: rows of two versions do not belong in one table."""

import hashlib
import json
from functools import cache
from pathlib import Path

import ur5_ros
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.config import config_folder
from ur5_ros.errors import InputError

FILE = 'software.json'


@cache
def sources() -> str:
    """
    Return a digest of the package's code and of its arms, experiments and worlds.

    It is that of the first call: a process goes on with the code that it has loaded.

    """
    found = hashlib.sha256()
    for root, pattern in ((Path(ur5_ros.__file__).parent, '*.py'), (config_folder(), '*.yaml')):
        for path in sorted(root.rglob(pattern)):
            found.update(str(path.relative_to(root)).encode() + b'\0' + path.read_bytes() + b'\0')
    return found.hexdigest()[:16]


def write_provenance(folder: Path) -> None:
    """Write what computes the rows of a sweep folder."""
    text = json.dumps({'sources': sources(), **fingerprint()}, indent=1) + '\n'
    (folder / FILE).write_text(text, encoding='utf-8')


def check_provenance(folder: Path, rows: int) -> None:
    """Compare what computes the rows of a sweep folder with what did."""
    if not rows:
        write_provenance(folder)
        return
    file = folder / FILE
    there = json.loads(file.read_text(encoding='utf-8'))['sources'] if file.exists() else 'older'
    if there != sources():
        raise InputError(f'{folder} has {rows} rows computed by other code (sources {there}; '
                         f'here {sources()}); give another folder with --out')


def check_worker(expected: str) -> None:
    """Refuse to compute with other code than the process that asks."""
    if sources() != expected:
        raise InputError(f'a worker has other code (sources {sources()}) than this sweep '
                         f'({expected}); start it again with the same version of ur5_ros')
