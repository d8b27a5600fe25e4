"""Judging long runs: seconds of processor time, and whether they grow with the length alone."""

import tempfile
import time
from pathlib import Path

from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.report.html import html_text
from ur5_ros.analysis.validate import validate
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.run_config import run_config

#: What is promised for ten minutes at 1 kHz [s], and how far from linear the cost may be.
PROMISED, LINEAR = 20.0, 1.3


def judge(folder: Path) -> float:
    """Return the processor seconds from bags to report."""
    start = time.process_time()
    result = validate(load_run(folder))
    html_text(result)
    assert result.verdict == 'pass', [c.sentence for c in result.checks if c.verdict == 'fail']
    return time.process_time() - start


def main() -> None:
    options = arguments(__doc__, 3)
    options.add_argument('--seconds', type=float, default=120.0, help='length of the longer run')
    given = options.parse_args()
    if given.quick:
        given.seconds, given.repeats = 20.0, 1
    with tempfile.TemporaryDirectory() as folder:
        runs = {'half': Path(folder) / 'half', 'whole': Path(folder) / 'whole'}
        for name, part in (('half', 0.5), ('whole', 1.0)):
            run_closed_loop(run_config(duration=given.seconds * part), runs[name])
        judge(runs['half'])  # compiles
        taken = interleave({name: lambda run=run: judge(run) for name, run in runs.items()},
                           given.repeats)
    growth = ratio(taken, 'whole', 'half') / 2.0
    ten_minutes = min(taken['whole']) * 600.0 / given.seconds
    publish('analysis', 'Judging a run, processor time', [
        Row('cost of twice the length', 'twice the cost', growth, LINEAR, False),
        Row('ten minutes at 1 kHz', '20 s', ten_minutes / PROMISED, 1.0, False,
            f'{ten_minutes:.1f} s of processor time')], {'seconds': taken},
            keep=not given.quick)


if __name__ == '__main__':
    main()
