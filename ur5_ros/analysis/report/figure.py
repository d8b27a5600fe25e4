"""One plot as plain data, and numbers as a page takes them."""

import base64
from typing import Any, NamedTuple

import numpy as np


class Figure(NamedTuple):
    """One plot."""

    key: str
    """Identifier in the page."""
    title: str
    caption: str
    """What the figure shows, in a sentence or two."""
    traces: list[dict[str, Any]]
    """Curves or bars as Plotly has them; empty where a note replaces them."""
    y: str
    """Title of the vertical axis."""
    x: str = 'time [s]'
    log: bool = False
    """Logarithmic vertical axis."""
    wide: bool = False
    """Takes the whole width."""
    first: bool = False
    """Stands before the checks: the run at a glance."""
    equal: bool = False
    """Both axes have one scale."""
    note: str = ''
    """What stands in place of a plot."""


def packed(values: np.ndarray) -> dict[str, str]:
    """Return numbers as Plotly's base64 of float32: seven digits, a third of the size of text."""
    data = np.ascontiguousarray(values, dtype='<f4').tobytes()
    return {'dtype': 'f4', 'bdata': base64.b64encode(data).decode('ascii')}
