"""``ur5 export``: the ending of the file decides what is written."""

from pathlib import Path

from ur5_ros.analysis.data.run import Run
from ur5_ros.export.scene import write_scene
from ur5_ros.export.table import columns_of, write_csv, write_parquet
from ur5_ros.viewer.render import check_new_file

KINDS = ('.csv', '.parquet', '.rrd')


def export(run: Run, out: Path) -> None:
    """
    Write a run as a file of another tool.

    ``out``: ``.csv``, ``.parquet``, or ``.rrd`` for Rerun: curves and the arm, moving.
    """
    if out.suffix == '.csv':
        write_csv(columns_of(run), out)
    elif out.suffix == '.parquet':
        write_parquet(columns_of(run), out)
    else:
        write_scene(run, out)


def check_name(out: Path) -> None:
    """Refuse a file that exists, an unknown ending, and a folder that is not there."""
    check_new_file(out, KINDS)
