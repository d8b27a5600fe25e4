"""The command ``ur5``: one module per group of commands, each imported when it is used."""

import os
import sys


def main() -> None:
    """
    Run the command ``ur5``; the process ends with the exit codes of docs/reference.

    BLAS is kept to one thread, as in the nodes: its threads wait by spinning, and a verdict with a
    cause takes three times as long with two of them.  A user's own choice counts.

    """
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')  # before NumPy is imported
    from ur5_ros.cli.run import run

    sys.exit(run(sys.argv[1:]))
