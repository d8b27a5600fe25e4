"""A job of the bench with a user's law, in a process with limited time and memory."""

import json
import sys
from pathlib import Path
from typing import Any

from ur5_ros.bench.entries import Entry
from ur5_ros.bench.limited_process import OUT_OF_MEMORY, end_with, limit_resources, run_limited
from ur5_ros.bench.probe import load_package
from ur5_ros.bench.runs import Job, lost_row, overflow_ignored, row_of

#: Runs whose time the bisections of one job may take.
RUNS_OF_A_SEARCH = 5


def limited_row(job: Job) -> dict[str, Any]:
    """Return what a job finds, or that it took too long or ended its process."""
    seconds = job.entry.timeout * (RUNS_OF_A_SEARCH if job.survival else 1)
    given = json.dumps([job.entry.name, job.entry.control, *job[1:]])
    found = run_limited(__name__, [given], seconds, Path.cwd())
    if found.result is not None:
        return found.result
    return lost_row(job, f'too late: {found.why}' if found.late else found.why)


def main(result: str, given: str) -> None:
    """Do a job."""
    name, control, *rest = json.loads(given)
    job = Job(Entry(name, control), *rest)
    load_package()
    limit_resources()
    with overflow_ignored():
        try:
            row = row_of(job)
        except MemoryError:
            row = lost_row(job, f'the law takes {OUT_OF_MEMORY}')
    end_with(result, row)


if __name__ == '__main__':
    main(*sys.argv[1:])
