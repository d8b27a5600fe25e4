"""Pass marks come from a file; each has a unit and a reason, and another file may change some."""

import pytest

from ur5_ros.analysis.validate import validate
from ur5_ros.config.validation import load_marks
from ur5_ros.errors import InputError


def test_every_mark_has_a_unit_and_a_reason():
    marks = load_marks()
    assert marks['residual'] == 1e-9
    for mark in marks.marks.values():
        assert mark.limit >= 0.0 and mark.unit and len(mark.reason) > 20


def write(path, mark, limit):
    path.write_text(f'name: strict\nmarks:\n  {mark}:\n    limit: {limit}\n    unit: N m\n'
                    '    reason: "tried in a test"\n')
    return path


def test_a_stricter_mark_fails_what_the_default_passes(simulated, tmp_path):
    run = simulated(seconds=0.2)
    strict = load_marks(write(tmp_path / 'strict.yaml', 'residual', 1e-16))
    assert strict['command'] == load_marks()['command']
    assert validate(run).verdict == 'pass'
    result = validate(run, strict)
    assert result.check('residual, simulator arm').verdict == 'fail'
    assert result.about['marks'] == 'strict'


@pytest.mark.parametrize('mark, limit', [('residul', 1), ('residual', -1), ('residual', '.nan')])
def test_unknown_and_impossible_marks_are_refused(tmp_path, mark, limit):
    with pytest.raises(InputError):
        load_marks(write(tmp_path / 'bad.yaml', mark, limit))
