"""Every figure of the documents is that of a result file, a test, the code or a source."""

import importlib.util
import sys
from pathlib import Path

import pytest
import yaml

HERE = Path(__file__).resolve().parent


def load(name: str):
    spec = importlib.util.spec_from_file_location(name, HERE / f'{name}.py')
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


figures = load('figures')
FOUND = figures.figures()
BACKED = yaml.safe_load((HERE / 'figures.yaml').read_text(encoding='utf-8'))
EVIDENCE = [(page, evidence, name) for page, backed in BACKED.items()
            for evidence, names in backed.items() for name in names]


def agrees(figure, evidence) -> bool:
    """Tell whether a figure is what its evidence says; evidence that is not there says nothing."""
    try:
        return figures.agrees(figure, evidence)
    except (KeyError, IndexError, StopIteration, FileNotFoundError):
        return False


def test_every_figure_of_a_page_has_something_behind_it():
    known = {(page, name) for page, _, name in EVIDENCE}
    bare = [f'{each.page}:{each.line}: {each.name}' for each in FOUND
            if (each.page, each.name) not in known]
    assert not bare, 'name what backs them in test/docs/figures.yaml, or take them out'


def test_nothing_is_backed_that_no_page_says():
    printed = {(each.page, each.name) for each in FOUND}
    assert not [entry for entry in EVIDENCE if (entry[0], entry[2]) not in printed]


@pytest.mark.parametrize('page', BACKED)
def test_the_figures_of_a_page_are_those_of_their_evidence(page):
    printed = {each.name: each for each in FOUND if each.page == page}
    parted = [f'{name}: not what {evidence} says' for entry, evidence, name in EVIDENCE
              if entry == page and name in printed and not agrees(printed[name], evidence)]
    assert not parted


@pytest.mark.parametrize(('evidence', 'text', 'unit', 'agree'), [
    ('benchmarks/results/real_ur5.json#gravity.g', '9.8201', 'm/s', True),
    ('benchmarks/results/real_ur5.json#gravity.g', '9.8202', 'm/s', False),
    ('benchmarks/results/real_ur5.json#kinematics.motion3_fast.position', '1.2', 'µm', True),
    ('benchmarks/results/real_ur5.json#kinematics.motion3_fast.position', '1.3', 'µm', False),
    ('ur5_ros/bench/perturbations.py::START_ERROR', '20', 'mrad', True),
    ('ur5_ros/bench/perturbations.py::START_ERROR', '21', 'mrad', False),
    ('config/validation.yaml::kinematics', '25', '%', True),
    ('config/validation.yaml::kinematics', '26', '%', False),
    ('source: no such words', '1', 'm', False),
])
def test_a_figure_that_parts_from_its_evidence_is_found(evidence, text, unit, agree):
    figure = figures.Figure('README.md', 1, text, float(text), unit)
    assert figures.agrees(figure, evidence) is agree


@pytest.mark.parametrize(('text', 'names'), [
    ('It takes 1.5 to 2 ms, at 10,000 rows.', ['1.5 ms', '2 ms', '10,000 rows']),
    ('A residual of 1e-13 N m after `sleep 5 s`, see [x](y 3 m).', ['1e-13 N m']),
    ('Version 0.2 of 12 pages', []),
])
def test_figures_are_numbers_with_a_unit_in_prose(text, names):
    found = [f'{number.rstrip(",")} {match[2]}' for match in figures.PATTERN.finditer(
        figures.prose(text)) for number in figures.NUMBERS.findall(match[1])]
    assert found == names
