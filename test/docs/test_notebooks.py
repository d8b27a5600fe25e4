"""The notebooks of the course run from first to last cell and say what they are kept with."""

import sys
from pathlib import Path

import nbformat
import pytest
from nbclient.exceptions import CellExecutionError
from notebooks import NOTEBOOKS, differences, executed, main, outputs

ROOT = Path(__file__).resolve().parents[2]


def written(tmp_path, *cells):
    """Return a notebook of some code cells."""
    path = tmp_path / 'book.ipynb'
    nbformat.write(nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell(each) for each in cells]), path)
    return path


def test_two_exercises_have_a_notebook_and_their_pages_lead_there():
    assert len(NOTEBOOKS) >= 2
    for path in NOTEBOOKS:
        page = path.with_suffix('.md').read_text(encoding='utf-8')
        assert f']({path.name})' in page


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_without_an_error_and_gives_the_outputs_that_are_kept(path):
    kept = nbformat.read(path, as_version=4)
    assert differences(kept, executed(path)) == []
    pictures = [each for cell in outputs(kept) for each in cell if not isinstance(each, str)]
    assert len(pictures) >= 3
    assert all(picture.std() > 0.01 for picture in pictures)  # something is drawn
    assert path.stat().st_size < 300_000


def test_a_cell_that_raises_is_an_error(tmp_path):
    with pytest.raises(CellExecutionError, match='ZeroDivisionError'):
        executed(written(tmp_path, 'x = 1', 'x / 0'))


def test_another_text_another_picture_and_a_missing_output_are_differences(tmp_path):
    plot = 'import matplotlib.pyplot as plt\nplt.plot([0, {}]);'
    one = executed(written(tmp_path, 'print(1)', plot.format(1), '2'))
    assert differences(one, one) == []
    other = executed(written(tmp_path, 'print(3)', plot.format(-1), ''))
    assert [line.partition(':')[0] for line in differences(one, other)] == [
        'cell 0', 'cell 1', 'cell 2']


def test_what_is_written_runs_in_the_python_that_writes_it(tmp_path, monkeypatch):
    path = written(tmp_path, 'import sys\nprint(sys.executable)')
    monkeypatch.setattr('notebooks.NOTEBOOKS', [path])
    main()
    assert outputs(nbformat.read(path, as_version=4)) == [[f'{sys.executable}\n']]
