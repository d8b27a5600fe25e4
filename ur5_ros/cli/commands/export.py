"""The command ``ur5 export``: a run as a file of another tool."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ur5_ros.analysis.data.load import load_run
from ur5_ros.cli.exit_codes import YES
from ur5_ros.export.export import check_name
from ur5_ros.export.export import export as write


def export(run: Path, out: Path, given: Mapping[str, Any]) -> int:
    """Write a run to a file; see ``ur5 export --help``."""
    check_name(out)
    write(load_run(run, **given), out)
    print(f'written: {out}')
    return YES
