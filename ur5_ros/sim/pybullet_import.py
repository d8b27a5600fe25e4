"""PyBullet, imported without the line that its C code writes to stderr in every process."""

import os
import sys

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
