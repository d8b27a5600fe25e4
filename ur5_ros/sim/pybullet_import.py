"""PyBullet, imported without the line that its C code writes to stderr in every process."""

import os
import sys

from ur5_ros.config.distributions import providers
from ur5_ros.errors import InputError

if len(_found := providers('pybullet')) > 1:
    raise InputError(f'{" and ".join(_found)} are both installed and overwrite each other; '
                     f'pip uninstall {" ".join(each.split()[0] for each in _found)}, then install '
                     'one of them')

with open(os.devnull, 'w') as _nowhere:
    sys.stderr.flush()
    _kept = os.dup(2)
    os.dup2(_nowhere.fileno(), 2)
    try:
        import pybullet
    finally:
        os.dup2(_kept, 2)
        os.close(_kept)

__all__ = ['pybullet']
