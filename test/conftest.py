"""The fault scorecard: which row of the catalogue has which test, and how it went."""

import gc
import json
import os
from collections import defaultdict
from inspect import signature
from pathlib import Path

import pytest
import thorough
import yaml

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')  # before NumPy: as the command and the nodes
gc.disable()  # what is imported and collected stays: no time to look through it, now or later

CATALOGUE = Path(__file__).parent / 'faults' / 'catalogue.yaml'
REPO = Path(__file__).parents[1]


def pytest_addoption(parser):
    parser.addoption('--scorecard', metavar='FILE',
                     help='write the fault scorecard as Markdown')
    parser.addoption('--outcomes', metavar='FILE', action='append', default=[],
                     help='keep the outcomes of fault tests as JSON, beside those that are there; '
                          'once more for each part of a run in parts')
    parser.addoption('--evidence', metavar='FILE', type=Path,
                     help='keep what thorough tests found as JSON')


#: Rooms whose files take longest: they come first, so that no core is left with one at the end.
FIRST = ('docs', 'cli', 'sweep', 'benchmarks', 'faults', 'nodes', 'packaging', 'bench', 'viewer')


def pytest_collection_modifyitems(items):
    """Put long files first, and mark what a thorough run does longer."""
    def place(item):
        room = item.path.relative_to(REPO / 'test').parts[0]
        return FIRST.index(room) if room in FIRST else len(FIRST)
    items.sort(key=place)
    for item in items:
        if 'times' in signature(getattr(item, 'function', print)).parameters:
            item.add_marker('thorough')


@pytest.hookimpl(tryfirst=True)  # before the loop itself, of pytest or of a worker
def pytest_runtestloop():
    """Let the garbage collector look at what tests make, and at nothing older."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000)
    gc.enable()


def pytest_configure(config):
    config.addinivalue_line('markers', 'fault(*rows): breaks what these rows of the catalogue '
                            'of faults name')
    config.pluginmanager.register(Scorecard(
        config.getoption('--scorecard'), config.getoption('--outcomes')), 'scorecard')
    evidence = config.getoption('--evidence')
    if evidence and not hasattr(config, 'workerinput'):
        if not thorough.THOROUGH:
            raise pytest.UsageError('--evidence keeps tests at full length: set UR5_ROS_THOROUGH')
        config.pluginmanager.register(thorough.Evidence(evidence), 'evidence')


def catalogue() -> dict[int, dict[str, str]]:
    """Return the rows of the catalogue by number, each with its group."""
    groups = yaml.safe_load(CATALOGUE.read_text())
    return {number: row | {'group': group}
            for group, rows in groups.items() for number, row in rows.items()}


class Scorecard:
    """Collects what tests claim and say; figures come by ``record_property``."""

    def __init__(self, path: str | None, kept: list[str]):
        self.path, self.kept = path, [Path(each) for each in kept]
        self.claims: dict[str, tuple[int, ...]] = {}
        self.outcomes: dict[str, str] = {}
        self.figures: dict[str, list[tuple[str, object]]] = defaultdict(list)

    def pytest_itemcollected(self, item):
        rows = [row for mark in item.iter_markers('fault') for row in mark.args]
        if rows:
            self.claims[item.nodeid] = tuple(rows)

    def pytest_runtest_logreport(self, report):
        if report.nodeid not in self.claims:
            return
        if report.when == 'call' or report.outcome != 'passed':
            self.outcomes[report.nodeid] = report.outcome
        if report.when == 'call':
            self.figures[report.nodeid] += report.user_properties

    def pytest_sessionfinish(self):
        """Take what other parts of a run came to, and leave what this one did."""
        for path in filter(Path.is_file, self.kept):
            outcomes, figures = json.loads(path.read_text())
            self.outcomes = outcomes | self.outcomes
            self.figures = defaultdict(list, figures | self.figures)
        if self.kept:
            self.kept[0].write_text(json.dumps([self.outcomes, self.figures]))

    def pytest_terminal_summary(self, terminalreporter):
        if not self.path:
            return
        text = self.markdown()
        Path(self.path).write_text(text)
        terminalreporter.write_line(text)

    def markdown(self) -> str:
        """Return the scorecard: totals, then one line a row."""
        rows = catalogue()
        tests = defaultdict(list)
        for nodeid, claimed in self.claims.items():
            for row in claimed:
                tests[row].append(nodeid)
        tried = [nodeid for nodeid in self.claims if nodeid in self.outcomes]
        survived = [nodeid for nodeid in tried if self.outcomes[nodeid] == 'passed']
        absent = [number for number, row in rows.items() if 'not_applicable' in row]
        lines = [
            '# Fault scorecard', '',
            'Made by `make faults` from the tests themselves.', '',
            f'- rows of the catalogue: {len(rows)}; with a test: {len(tests)}; '
            f'not applicable: {len(absent)}',
            f'- fault tests run: {len(tried)}; survived: {len(survived)}; '
            f'failed: {len(tried) - len(survived)}',
            *self._worst(), '',
        ]
        for group in dict.fromkeys(row['group'] for row in rows.values()):
            lines += [f'## {group.capitalize()}', '', '| row | fault | tests | survived |',
                      '|---|---|---|---|']
            for number, row in rows.items():
                if row['group'] == group:
                    lines.append(self._line(number, row, tests[number]))
            lines.append('')
        return '\n'.join(lines)

    def _worst(self) -> list[str]:
        """Return the greatest of each figure, the sum of those that are named ``, in all``."""
        worst: dict[str, float] = {}
        for figures in self.figures.values():
            for name, value in figures:
                if isinstance(value, int | float):
                    worst[name] = (worst.get(name, 0) + value if name.endswith(', in all')
                                   else max(value, worst.get(name, value)))
        return [f'- {name}: ' + format(value, ',' if value == int(value) else '.4g')
                for name, value in sorted(worst.items())]

    def _line(self, number: int, row: dict[str, str], tests: list[str]) -> str:
        if 'not_applicable' in row:
            return f'| {number} | {row["fault"]} | not applicable: {row["not_applicable"]} | - |'
        names = ', '.join(sorted({f'`{nodeid.partition("[")[0].rpartition("/")[2]}`'
                                  for nodeid in tests}))
        passed = sum(self.outcomes.get(nodeid) == 'passed' for nodeid in tests)
        return f'| {number} | {row["fault"]} | {names} | {passed} of {len(tests)} |'


def pytest_report_teststatus(report):
    """Count tests without their recordings under a name of their own, in the run's last line."""
    if report.skipped and 'recordings of a real UR5' in str(report.longrepr):
        return 'left out without the recordings of a real UR5', 's', 'LEFT OUT'
    return None


@pytest.fixture(scope='session')
def times():
    """Return how many times: ``times(quick, thorough)``; see test/thorough.py."""
    return thorough.times


@pytest.fixture(scope='session')
def repo() -> Path:
    """Return the root of the checkout."""
    return REPO
