"""README and docs: every snippet runs, every link leads somewhere, generated pages are current."""

import contextlib
import gzip
import importlib.util
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import inverse_dynamics

ROOT = Path(__file__).resolve().parents[2]


def load(name: str, path: Path):
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


documents = load('snippets', Path(__file__).parent / 'snippets.py')
GROUPS = documents.groups()
REASONS = ('needs ', 'test/')


def test_every_snippet_is_run_or_says_why_not():
    unmarked = [f'{each.page.name}:{each.line}' for each in documents.snippets()
                if not each.group or (each.group == 'none' and not each.how.startswith(REASONS))]
    assert not unmarked


def robot_log(path: Path) -> None:
    """Write two seconds of a log as a UR's real-time interface gives it."""
    t = np.arange(250) / 125.0
    w, middle = 1.1 * np.arange(1, 7), np.array([0.0, -1.5, 1.5, -1.5, -1.5, 0.0])
    q = middle + 0.3 * np.sin(np.outer(t, w))
    qd, qdd = 0.3 * w * np.cos(np.outer(t, w)), -0.3 * w**2 * np.sin(np.outer(t, w))
    torque = inverse_dynamics(q, qd, qdd, load_arm('ur5_controller'))
    names = ('actual_q', 'actual_qd', 'target_q', 'target_qd', 'target_qdd', 'target_moment')
    header = ['timestamp', *(f'{name}_{joint}' for name in names for joint in range(6))]
    with gzip.open(path, 'wt') as file:
        np.savetxt(file, np.column_stack([t, q, qd, q, qd, qdd, torque]), delimiter=',',
                   header=','.join(header), comments='')


@pytest.mark.parametrize('name', sorted(GROUPS))
def test_the_snippets_of_a_group_run_as_printed(name, tmp_path):
    (tmp_path / '.venv').symlink_to(Path(sys.prefix))
    (tmp_path / 'bags').mkdir()
    (tmp_path / 'bags/golden').symlink_to(ROOT / 'bags/golden')
    (tmp_path / 'config').symlink_to(ROOT / 'config')
    (tmp_path / 'docs').symlink_to(ROOT / 'docs')
    robot_log(tmp_path / 'log.csv.gz')
    script = documents.script(GROUPS[name], tmp_path)
    environment = {key: value for key, value in os.environ.items()
                   if not key.startswith(('PYTEST', 'MAKE', '_ROS_WHEELS'))}
    environment |= {
        'ROS_DOMAIN_ID': str(180 + sorted(GROUPS).index(name)),
        'FASTRTPS_DEFAULT_PROFILES_FILE': str(ROOT / 'config/fastdds_loopback.xml'),
        'PATH': os.pathsep.join([str(Path(sys.executable).parent), str(ROOT / 'test/docs/bin'),
                                 environment['PATH']]),
        'DASK_TEMPORARY_DIRECTORY': str(tmp_path),
    }
    environment.pop('ROS_AUTOMATIC_DISCOVERY_RANGE', None)
    output = tmp_path / 'output.txt'
    with output.open('w') as file:
        process = subprocess.Popen(['bash', '-c', script], cwd=tmp_path, env=environment,
                                   stdin=subprocess.DEVNULL, stdout=file,
                                   stderr=subprocess.STDOUT, start_new_session=True)
        try:
            code = process.wait(timeout=400)
        finally:  # the session of the script, and nothing else
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    assert code == 0, output.read_text(encoding='utf-8')[-4000:]


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page."""
    text = re.sub(r'```.*?```', '', page.read_text(encoding='utf-8'), flags=re.DOTALL)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).strip().replace(' ', '-')
            for heading in re.findall(r'^#+ (.*)$', text, re.MULTILINE)}


@pytest.mark.parametrize('page', documents.PAGES, ids=lambda page: page.name)
def test_every_link_of_a_page_leads_somewhere(page):
    text = re.sub(r'```.*?```', '', page.read_text(encoding='utf-8'), flags=re.DOTALL)
    broken = []
    for target in re.findall(r'\]\(([^)\s]+)\)', text):
        if re.match(r'[a-z]+:', target):
            continue
        name, _, anchor = target.partition('#')
        path = (page.parent / name).resolve() if name else page
        if not path.exists() or (anchor and anchor not in anchors(path)):
            broken.append(target)
    assert not broken


def test_every_page_is_reached_from_the_first():
    reached, todo = set(), [ROOT / 'docs/index.md']
    while todo:
        page = todo.pop()
        if page in reached:
            continue
        reached.add(page)
        for target in re.findall(r'\]\(([^)\s#]+\.md)', page.read_text(encoding='utf-8')):
            todo.append((page.parent / target).resolve())
    assert set((ROOT / 'docs').rglob('*.md')) <= reached


def test_a_test_that_a_page_names_exists():
    sources = {path.relative_to(ROOT): path.read_text(encoding='utf-8')
               for path in (ROOT / 'test').rglob('*.py')}
    known = set(re.findall(r'def (test_\w+)', '\n'.join(sources.values())))
    known |= {str(path) for path in sources}
    missing = []
    for page in documents.PAGES:
        if page.name == 'python.md':  # fields of results, such as test_rms
            continue
        for name in re.findall(r'`(test_\w+|test/[\w/]+\.py)`', page.read_text('utf-8')):
            if name not in known:
                missing.append(f'{page.name}: {name}')
    assert not missing


@pytest.mark.parametrize('name', ['parameters.md', 'cli.md', 'python.md'])
def test_the_generated_reference_is_current(name):
    generate = load('generate', ROOT / 'docs/generate.py')
    page = ROOT / 'docs/reference' / name
    assert page.read_text(encoding='utf-8') == generate.PAGES[name](), 'run docs/generate.py'


def test_the_site_builds_without_a_warning(tmp_path):
    done = subprocess.run([sys.executable, '-m', 'mkdocs', 'build', '--strict', '--quiet',
                           '--site-dir', tmp_path / 'site'], cwd=ROOT, text=True,
                          capture_output=True, stdin=subprocess.DEVNULL, timeout=300)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / 'site/index.html').is_file()
