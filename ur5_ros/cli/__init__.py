"""The command ``ur5``: one module per group of commands, each imported when it is used."""

import sys


def main() -> None:
    """Run the command ``ur5``; the process ends with the exit codes of docs/reference."""
    from ur5_ros.cli.run import run

    sys.exit(run(sys.argv[1:]))
