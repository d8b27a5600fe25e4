"""One command line from its arguments to its exit code."""

import os
import sys
from typing import Any

import typer
from typer.main import get_command

from ur5_ros.cli.app import app
from ur5_ros.cli.exit_codes import BAD_INPUT, INTERRUPTED, YES
from ur5_ros.errors import InputError

# ClickException, wherever this typer keeps it
_USAGE_ERROR: Any = typer.BadParameter.__mro__[2]


def run(arguments: list[str]) -> int:
    """
    Run one command line.

    Parameters
    ----------
    arguments : list of str
        What follows the name of the command.

    Returns
    -------
    int
        The exit code; a user's mistake is one line on stderr and code 2, never a traceback.

    """
    try:
        code = _command()(args=arguments, prog_name='ur5', standalone_mode=False)
        sys.stdout.flush()
        if code == INTERRUPTED:  # typer makes this of a KeyboardInterrupt
            return _complain('interrupted', INTERRUPTED)
        return code if isinstance(code, int) else YES
    except InputError as refusal:
        return _complain(str(refusal), BAD_INPUT)
    except _USAGE_ERROR as error:
        context = getattr(error, 'ctx', None)
        command = context.command_path if context else 'ur5'
        text = error.format_message()
        if not arguments or type(error).__name__ == 'NoArgsIsHelpError':
            print(text)
            return BAD_INPUT
        return _complain(f'{text.rstrip(".")}; see {command} --help', BAD_INPUT)
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


def _command() -> Any:
    """Return the whole command; what prints the completion is there, and takes no line of help."""
    command = get_command(app)
    for option in command.params:
        if option.name == 'show_completion':
            option.hidden = True  # type: ignore[attr-defined]
        elif option.name == 'install_completion':
            option.help = 'Install completion for this shell.'  # type: ignore[attr-defined]
    return command


def _complain(text: str, code: int) -> int:
    line = ' '.join(text.split())
    if sys.stderr.isatty() and not os.environ.get('NO_COLOR'):
        line = f'\x1b[31mur5:\x1b[0m {line}'
    else:
        line = f'ur5: {line}'
    print(line, file=sys.stderr)
    return code


def _extra(module: str | None) -> str:
    extras = {'rclpy': 'ros', 'dask': 'sweep', 'distributed': 'sweep', 'polars': 'sweep',
              'viser': 'view', 'imageio_ffmpeg': 'view', 'PIL': 'view'}
    extra = extras.get((module or '').partition('.')[0])
    return (f"in the checkout: make setup-all, or pip install '.[{extra}]'" if extra else
            'install the package again')
