"""One command line from its arguments to its exit code."""

import os
import re
import shutil
import sys
import textwrap
from collections.abc import Callable

import typer

from ur5_ros.cli.app import app
from ur5_ros.cli.exit_codes import BAD_INPUT, INTERNAL_ERROR, INTERRUPTED, SUCCESS
from ur5_ros.errors import InputError
from ur5_ros.model.kernels.compile_notice import on_compile


def run(arguments: list[str]) -> int:
    """
    Run one command line.

    Returned: the exit code; a user's mistake is one line on stderr and code 2, never a traceback.
    A defect of this package shows its traceback and is code 4.
    """
    on_compile(_compile_notice())
    try:
        code = app(args=arguments or ['--help'], prog_name='ur5', standalone_mode=False)
        sys.stdout.flush()
        if code == INTERRUPTED:  # typer makes this of a KeyboardInterrupt
            return _complain('interrupted', INTERRUPTED)
        if not arguments:
            return BAD_INPUT
        return code if isinstance(code, int) else SUCCESS
    except InputError as refusal:
        return _complain(str(refusal), BAD_INPUT)
    except typer.TyperException as error:
        text = _plain(error.format_message().rstrip('.'), arguments)
        return _complain(f'{text}; see {_command(arguments)} --help', BAD_INPUT)
    except (KeyboardInterrupt, typer.Abort):
        return _complain('interrupted', INTERRUPTED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BAD_INPUT
    except ImportError as error:
        return _complain(f'{error.name or error} cannot be imported; {_extra(error.name)}',
                         BAD_INPUT)
    except OSError as error:
        where = f'{error.filename}: ' if error.filename else ''
        return _complain(f'{where}{error.strerror or error}', BAD_INPUT)
    except Exception as error:  # the last resort: a traceback must not look like a verdict
        from ur5_ros.cli.internal_error import write_details
        return _complain(write_details(error, arguments), INTERNAL_ERROR)


def _command(arguments: list[str]) -> str:
    """Return the command that a command line asks for, as far as it is one."""
    names = {each.name or getattr(each.callback, '__name__', '')
             for each in app.registered_commands}
    return f'ur5 {arguments[0]}' if arguments[0] in names else 'ur5'


def _plain(text: str, arguments: list[str]) -> str:
    """Return Typer's message about a number with the value and what to give instead."""
    found = re.match(r"Invalid value for '(-\S+)'.*: Input should be a valid (integer|number)",
                     text)
    words = [part for each in arguments for part in each.split('=', 1)]
    if not found or found[1] not in words[:-1]:
        return text
    value = words[words.index(found[1]) + 1]
    return f'{found[1]} {value!r}; give a {"whole " * (found[2] == "integer")}number'


def _compile_notice() -> Callable[[str], None]:
    """Return what prints one line at the first kernel that is compiled."""
    compiled: list[str] = []

    def notice(name: str) -> None:
        if not compiled:
            print('ur5: compiling for this processor, once, for up to half a minute\n'
                  'ur5: (ur5 warm-up --all does it in advance)', file=sys.stderr)
        compiled.append(name)

    return notice


def _complain(text: str, code: int) -> int:
    """Print one line; a terminal gets it wrapped at blanks."""
    line = f'ur5: {" ".join(text.split())}'
    if sys.stderr.isatty():
        line = '\n'.join(textwrap.wrap(line, shutil.get_terminal_size().columns,
                                       break_long_words=False, break_on_hyphens=False))
        if not os.environ.get('NO_COLOR'):
            line = line.replace('ur5:', '\x1b[31mur5:\x1b[0m', 1)
    print(line, file=sys.stderr)
    return code


def _extra(module: str | None) -> str:
    extras = {'rclpy': 'ros', 'dask': 'sweep', 'distributed': 'sweep', 'polars': 'sweep',
              'viser': 'view', 'imageio_ffmpeg': 'view', 'PIL': 'view'}
    extra = extras.get((module or '').partition('.')[0])
    return (f"in the checkout: make setup-all, or pip install '.[{extra}]'" if extra else
            'install the package again')
