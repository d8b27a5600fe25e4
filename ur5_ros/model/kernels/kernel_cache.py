"""Which files are compiled, and whether that is done; without Numba, which takes long to load."""

import os
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

_HERE = Path(__file__).parent
#: Folders whose kernels call one another.
_SOURCES = (_HERE, _HERE.parents[1] / 'sim')


def seems_cached(module: Path) -> bool:
    """
    Return whether kernels of a module seem to be on disk, newer than every file they come from.

    Those of another processor, or of another Numba, are taken for kept as well; they are compiled
    when they are used.
    """
    newest = max(path.stat().st_mtime for path, _ in compiled_sources())
    kept = chain.from_iterable(folder.glob(f'{module.stem}.*.nbi') for folder in _folders(module))
    return any(path.stat().st_mtime > newest for path in kept)


def compiled_sources() -> Iterator[tuple[Path, bytes]]:
    """Yield every file with compiled functions or compiler settings, and its content."""
    for path in sorted(chain.from_iterable(folder.rglob('*.py') for folder in _SOURCES)):
        text = path.read_bytes()
        if path.name in ('compiled.py', 'base_parameters.py') or b'\n@inlined' in text or (
                b'\n@kernel' in text):
            yield path, text


def _folders(module: Path) -> list[Path]:
    """Return where Numba keeps what it compiles of a module."""
    chosen = os.environ.get('NUMBA_CACHE_DIR')
    if chosen:
        return list(Path(chosen).glob(f'{module.parent.name}_*'))
    cache = Path(os.environ.get('XDG_CACHE_HOME') or '~/.cache').expanduser()
    return [module.parent / '__pycache__', *(cache / 'numba').glob(f'{module.parent.name}_*')]
