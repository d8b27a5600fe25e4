"""
The notebooks of the course: run from the first cell to the last, and kept with what they print.

``python docs/notebooks.py`` runs them and writes their outputs anew; test/docs/test_notebooks.py
runs them and compares.
"""

import base64
import io
from pathlib import Path
from typing import Any

import matplotlib.image
import nbformat
import numpy as np
from nbclient import NotebookClient

COURSE = Path(__file__).resolve().parent / 'course'
NOTEBOOKS = sorted(COURSE.glob('*.ipynb'))
#: Wall-clock time that a cell gets [s].
TIMEOUT = 300
#: Two pictures are the same if their grey values differ by less than this on average, of 1.
SAME = 0.01
_METADATA = {'kernelspec': {'display_name': 'Python 3', 'language': 'python', 'name': 'python3'},
             'language_info': {'name': 'python'}}


def executed(path: Path) -> nbformat.NotebookNode:
    """
    Return a notebook after it has run in a fresh kernel of this Python.

    Parameters
    ----------
    path : Path
        The notebook.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell raises.

    """
    book = nbformat.read(path, as_version=4)
    NotebookClient(book, timeout=TIMEOUT, kernel_name='python3', record_timing=False,
                   coalesce_streams=True,
                   resources={'metadata': {'path': str(path.parent)}}).execute()
    book.metadata = nbformat.from_dict(_METADATA)
    for cell in book.cells:
        cell.metadata = nbformat.from_dict({})
    return book


def outputs(book: nbformat.NotebookNode) -> list[list[Any]]:
    """Return what each cell gives: texts as str, pictures as arrays of grey values, 0 to 1."""
    return [[_content(each) for each in cell.get('outputs', ())] for cell in book.cells]


def differences(kept: nbformat.NotebookNode, new: nbformat.NotebookNode) -> list[str]:
    """Return in a line each where the outputs of two runs of a notebook differ."""
    found = []
    for number, (a, b) in enumerate(zip(outputs(kept), outputs(new), strict=True)):
        if len(a) != len(b) or not all(map(_same, a, b)):
            found.append(f'cell {number}: {_shown(a)} is kept, {_shown(b)} came out')
    return found


def _content(output: nbformat.NotebookNode) -> Any:
    if output.output_type == 'stream':
        return output.text
    data = output.get('data', {})
    if 'image/png' in data:
        picture = matplotlib.image.imread(io.BytesIO(base64.b64decode(data['image/png'])))
        return np.asarray(picture, dtype=float)[..., :3].mean(axis=-1)
    return data.get('text/plain', output.output_type)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, str) or isinstance(b, str):
        return isinstance(a, str) and isinstance(b, str) and a == b
    return a.shape == b.shape and float(np.abs(a - b).mean()) < SAME


def _shown(contents: list[Any]) -> str:
    return repr([each if isinstance(each, str) else f'picture {each.shape}'
                 for each in contents])[:300]


def main() -> None:
    """Run every notebook and write it with its outputs."""
    for path in NOTEBOOKS:
        nbformat.write(executed(path), path)
        print(path)


if __name__ == '__main__':
    main()
