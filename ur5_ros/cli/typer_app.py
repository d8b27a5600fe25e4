"""The application ``ur5`` before it has commands."""

from typing import Annotated

import typer

app = typer.Typer(
    name='ur5', rich_markup_mode=None, pretty_exceptions_enable=False,
    context_settings={'help_option_names': ['-h', '--help'], 'max_content_width': 99},
    help='Torque control of simulated UR arms. Exit codes: 0 passed or done, 1 failed, '
    '2 bad input, 3 done with loss, 4 internal error.')


def _show_version(given: bool) -> None:
    if given:
        from ur5_ros import __version__
        print(f'ur5 {__version__}')
        raise typer.Exit()


@app.callback()
def _options(
    version: Annotated[bool, typer.Option(
        '--version', callback=_show_version, is_eager=True, help='Show the version and exit.',
    )] = False,
) -> None:
    pass
