"""The last resort: an error that no code foresaw becomes one line, its details a file."""

import os
import platform
import sys
import tempfile
import traceback
from collections.abc import Sequence

from ur5_ros import __version__


def write_details(error: BaseException, arguments: Sequence[str]) -> str:
    """Return what to print about an unforeseen error; its details are written to a file."""
    text = '\n'.join([
        f'ur5_ros {__version__}, Python {platform.python_version()}, {platform.platform()}',
        f'arguments: {list(arguments)!r}', '',
        ''.join(traceback.format_exception(error))])
    what = ' '.join(f'{type(error).__name__}: {error}'.split())[:200]
    try:
        handle, path = tempfile.mkstemp(prefix='ur5-internal-error-', suffix='.txt', text=True)
        with os.fdopen(handle, 'w', encoding='utf-8', errors='replace') as file:
            file.write(text)
    except OSError:
        print(text, file=sys.stderr)
        return f'internal error ({what}); report it with the lines above'
    return (f'internal error ({what}); the details were written to {path}: report it with that '
            'file to the maintainer named in package.xml')
