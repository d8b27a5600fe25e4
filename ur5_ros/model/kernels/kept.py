"""Whether kernels lie compiled on disk, asked without Numba, which takes longer to load."""

import os
from itertools import chain
from pathlib import Path

_HERE = Path(__file__).parent
#: Folders whose kernels call one another.
_SOURCES = (_HERE, _HERE.parents[1] / 'sim')


def seem_kept(module: Path) -> bool:
    """
    Return whether kernels of a module seem to be on disk, newer than every file they come from.

    Those of another processor, or of another Numba, are taken for kept as well; they are compiled
    when they are used.
    """
    newest = max(path.stat().st_mtime for folder in _SOURCES for path in folder.rglob('*.py'))
    kept = chain.from_iterable(folder.glob(f'{module.stem}.*.nbi') for folder in _folders(module))
    return any(path.stat().st_mtime > newest for path in kept)


def _folders(module: Path) -> list[Path]:
    """Return where Numba keeps what it compiles of a module."""
    chosen = os.environ.get('NUMBA_CACHE_DIR')
    if chosen:
        return list(Path(chosen).glob(f'{module.parent.name}_*'))
    cache = Path(os.environ.get('XDG_CACHE_HOME') or '~/.cache').expanduser()
    return [module.parent / '__pycache__', *(cache / 'numba').glob(f'{module.parent.name}_*')]
