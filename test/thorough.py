"""
What is heavy by nature: a part of it in every run, the whole where UR5_ROS_THOROUGH is set.

Use the fixture ``times``, or :func:`times` with the marker ``thorough`` where a number is needed
before a test runs.  `make evidence` runs the tests that do either, and keeps what they found.
"""

import json
import os
import sys
import time
from pathlib import Path
from typing import Any, TypeVar

import pytest

BENCHMARKS = Path(__file__).resolve().parents[1] / 'benchmarks'
THOROUGH = bool(os.environ.get('UR5_ROS_THOROUGH'))

Value = TypeVar('Value')


def times(quick: Value, thorough: Value) -> Value:
    """Return the one or the other."""
    return thorough if THOROUGH else quick


class Evidence:
    """
    Keeps outcome, duration and figures (``record_property``) of thorough tests as JSON.

    Tests that a run leaves out keep what an earlier run found, with its date, as long as they
    exist under their name.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.found: dict[str, dict[str, Any]] = {}
        self.collected: set[str] = set()

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items):
        """Take note of the tests there are, before some are left out."""
        self.collected = {item.nodeid for item in items}

    def pytest_runtest_logreport(self, report):
        if 'thorough' not in report.keywords or report.when != 'call' and report.passed:
            return
        self.found[report.nodeid] = {
            'date': time.strftime('%Y-%m-%d', time.gmtime()), 'outcome': report.outcome,
            'seconds': round(report.duration, 1), 'figures': dict(report.user_properties)}

    def pytest_sessionfinish(self):
        """Write the file: what is new beside what is kept."""
        if not self.found:
            return
        sys.path.append(str(BENCHMARKS))
        from side_by_side import Row, publish
        kept = json.loads(self.path.read_text())['tests'] if self.path.exists() else {}
        files = {each.partition('::')[0] for each in self.collected}
        tests = dict(sorted((name, result) for name, result in (kept | self.found).items()
                            if name in self.collected or name.partition('::')[0] not in files))
        passed = sum(each['outcome'] == 'passed' for each in tests.values())
        publish(self.path.stem, 'What takes long: tests at their full length', [
            Row('tests that passed', 'tests run', passed / len(tests), 1.0, True,
                f'{passed} of {len(tests)}, in {sum(t["seconds"] for t in tests.values()):.0f} s'),
        ], {'tests': tests}, folder=self.path.parent)
