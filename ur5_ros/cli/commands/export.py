"""The command ``ur5 export``: a run as a file of another tool."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ur5_ros.analysis.data.load import load_run
from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import SUCCESS
from ur5_ros.export.export import check_name
from ur5_ros.export.export import export as write


def export(run: Path, out: Path, given: Mapping[str, Any]) -> int:
    """Write a run to a file; see ``ur5 export --help``."""
    check_name(out)
    read = load_run(run, **given)
    write(read, out)
    terminal.show_notes(terminal.console(), read)
    print(f'written: {out}')
    return SUCCESS
