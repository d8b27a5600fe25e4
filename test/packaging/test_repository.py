"""What a contributor relies on: the same checks everywhere, a licence, a citation, templates."""

import re
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]


def make_commands(*targets: str) -> set[str]:
    """Return the commands that make would run for these targets, the environment apart."""
    done = subprocess.run(['make', '--no-print-directory', '-n', '-o', 'setup-all', *targets],
                          cwd=ROOT, capture_output=True, text=True, check=True)
    return {line.strip() for line in done.stdout.splitlines() if line.startswith('.venv/bin/')}


def test_a_commit_is_checked_as_continuous_integration_checks():
    config = yaml.safe_load((ROOT / '.pre-commit-config.yaml').read_text(encoding='utf-8'))
    hooks = {hook['entry'].replace(' --force-exclude', '')
             for repository in config['repos'] for hook in repository['hooks']}
    checks = {command.removesuffix(' .') for command in make_commands('lint', 'types')}
    assert hooks == checks
    assert {command.removesuffix(' .') for command in make_commands('test')} > checks
    steps = (ROOT / '.ci/run').read_text(encoding='utf-8').splitlines()
    assert {'make test', 'make test-pythons PYTHONS=3.12'} <= set(steps), "Ubuntu 24.04's Python"


def test_the_workflow_tests_every_python_and_runs_real_ros():
    """Its form was checked with check-jsonschema; GitHub alone can run it."""
    text = (ROOT / '.github/workflows/ci.yml').read_text(encoding='utf-8')
    assert 'not run by this project' in text.splitlines()[0]
    jobs = yaml.safe_load(text)['jobs']
    pythons = jobs['quick']['strategy']['matrix']['python'] + [
        step['with']['python-version'] for step in jobs['whole']['steps'] if 'with' in step]
    assert sorted(pythons) == re.search(
        r'^PYTHONS := (.*)$', (ROOT / 'Makefile').read_text(encoding='utf-8'), re.MULTILINE
    )[1].split()
    commands = ' '.join(step.get('run', '') for step in jobs['jazzy']['steps'])
    for part in ('colcon build', 'ros2 launch ur5_ros closed_loop.launch.py', 'validate'):
        assert part in commands
    for path in re.findall(r'test/[\w/.]+', commands):
        assert (ROOT / path).exists(), path


def test_the_configuration_of_pre_commit_is_valid():
    done = subprocess.run([sys.executable, '-m', 'pre_commit', 'validate-config'], cwd=ROOT,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_licence_and_citation_say_the_same_everywhere():
    assert 'Apache License' in (ROOT / 'LICENSE').read_text(encoding='utf-8')
    citation = yaml.safe_load((ROOT / 'CITATION.cff').read_text(encoding='utf-8'))
    assert {'cff-version', 'message', 'title', 'authors'} <= set(citation)
    assert citation['license'] == 'Apache-2.0'
    assert '<license>Apache-2.0</license>' in (ROOT / 'package.xml').read_text(encoding='utf-8')
    assert "license='Apache-2.0'" in (ROOT / 'setup.py').read_text(encoding='utf-8')


def test_an_issue_template_names_itself_and_asks():
    for path in (ROOT / '.github/ISSUE_TEMPLATE').glob('*.md'):
        head, text = path.read_text(encoding='utf-8').removeprefix('---\n').split('\n---\n')
        assert {'name', 'about'} <= set(yaml.safe_load(head))
        assert re.search(r'\*\*.*\?\*\*', text), path.name
