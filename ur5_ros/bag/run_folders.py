"""Folders of runs: ``bags/<run>/sim`` and ``bags/<run>/control``."""

import secrets
import time
from pathlib import Path

from ur5_ros.errors import InputError

#: Folder of all runs, below the working directory.
BAGS = Path('bags')

#: Suffix of what a recovery writes beside a run, and of its unfinished work.
RECOVERED_SUFFIX = '.recovered'
UNFINISHED = '.unfinished'

#: Ending of a compressed file -> what decompresses it.
DECOMPRESSORS = {'.zstd': 'zstd -d', '.zst': 'zstd -d', '.gz': 'gunzip', '.bz2': 'bunzip2',
                 '.xz': 'unxz', '.lz4': 'lz4 -d', '.zip': 'unzip'}

_LETTERS = 'abcdefghijklmnopqrstuvwxyz0123456789'


def new_run_name() -> str:
    """Return a name for a run: UTC time and four random characters, ``20250131T235959Z-x7b2``."""
    random = ''.join(secrets.choice(_LETTERS) for _ in range(4))
    return time.strftime('%Y%m%dT%H%M%SZ', time.gmtime()) + '-' + random


def is_bag(folder: Path) -> bool:
    """Return whether a folder holds one bag: its metadata.yaml, or at least a storage file."""
    return folder.is_dir() and ((folder / 'metadata.yaml').is_file()
                                or any(folder.glob('[!.]*.mcap'))
                                or any(folder.glob('[!.]*.db3')))


def bags_of_run(run: Path) -> list[Path]:
    """
    Return the bags of a run: the folder itself if it is one, else those directly below.

    Raises
    ------
    InputError
        If there is no such folder, or no bag in it.

    """
    run = Path(run)
    if not run.exists():
        raise InputError(f'{run}: no such folder; give one that holds sim/ and control/, or a bag')
    if run.is_file() or is_bag(run):
        return [run]
    if not run.is_dir():
        raise InputError(f'{run}: neither a file nor a folder; give the bag that was recorded')
    found = sorted(each for each in run.iterdir()
                   if is_bag(each) and not each.name.endswith((RECOVERED_SUFFIX, UNFINISHED)))
    if not found:
        _refuse_other_forms(run)
        raise InputError(f'{run}: no bag in it; give a folder that holds sim/ and control/, or '
                         'a bag')
    return found


def _refuse_other_forms(folder: Path) -> None:
    """Raise InputError for a folder with compressed storage files or bags of ROS 1."""
    for file in sorted(folder.iterdir()):
        if file.suffix in DECOMPRESSORS and file.stem.endswith(('.mcap', '.db3')):
            raise InputError(f'{file}: a compressed file; decompress it with: '
                             f'{DECOMPRESSORS[file.suffix]} {file.name}')
        if file.suffix == '.bag':
            raise InputError(f'{file}: a bag of ROS 1; convert it with: rosbags-convert')


def newest_run(bags: Path = BAGS) -> Path:
    """
    Return the run that was written to last.

    Raises
    ------
    InputError
        If there is none.

    """
    bags = Path(bags)
    runs = [(_last_written(run), run.name, run) for run in _folders(bags)]
    runs = [each for each in runs if each[0]]
    if not runs:
        raise InputError(f'no run in {bags.resolve()}; name one, or record one with: ur5 demo')
    return max(runs)[2]


def _folders(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return [each for each in folder.iterdir()
            if each.is_dir() and not each.name.endswith(UNFINISHED)]


def _last_written(run: Path) -> int:
    """Return when a storage file of the run was last written [ns since 1970], 0 if it has none."""
    times = [file.stat().st_mtime_ns
             for folder in (run, *_folders(run)) for kind in ('*.mcap', '*.db3')
             for file in folder.glob(kind)]
    return max(times, default=0)
