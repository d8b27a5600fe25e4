"""One HTML file that opens from disk: style, figures as data, and the program that draws them."""

import base64
import gzip
import hashlib
import json
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs

from ur5_ros.analysis.report.page import SCRIPT, STYLE
from ur5_ros.analysis.report.palette import JOINT_COLOURS, SHORT_NAMES
from ur5_ros.errors import InputError


def html_document(
    title: str, body: str, figures: Sequence[dict[str, Any]],
    marks: Sequence[dict[str, Any]] = (),
) -> str:
    """
    Return a page.

    Its policy lets its own script run, and what that script unpacks; nothing is loaded.

    ``body``: markup; texts in it have gone through :func:`markup`; ``figures``: ``key``, ``x``,
    ``y`` (titles of the axes), ``log``, ``traces`` as Plotly has them; drawn into the element
    ``plot-KEY`` of the body; ``marks``: ``t`` [s] and ``text`` of lines in every figure over time.
    """
    policy = ("default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; script-src "
              f"'sha256-{_digest(SCRIPT)}' blob:")
    return ''.join([
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n',
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n',
        f'<title>{markup(title)}</title>\n',
        f'<style>{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n',
        '<script type="application/json" id="figures">',
        _json({'figures': list(figures), 'marks': list(marks),
               'joints': dict(zip(SHORT_NAMES, JOINT_COLOURS, strict=True))}), '</script>\n',
        f'<script type="text/plain" id="library">{_library()}</script>\n',
        f'<script>{SCRIPT}</script>\n</body>\n</html>\n',
    ])


def write_document(text: str, path: str | Path) -> None:
    """Write a page, over an older one; InputError if it cannot be written."""
    try:
        Path(path).write_text(text, encoding='utf-8')
    except OSError as error:
        raise InputError(f'{path}: the report cannot be written: {error.strerror}') from None


def markup(value: Any) -> str:
    """Return text as markup that shows it; characters that no file can hold become marks."""
    shown = str(value).encode('utf-8', 'replace').decode()
    return escape(''.join(c if c >= ' ' or c in '\n\t' else '?' for c in shown), quote=True)


@cache
def _library() -> str:
    """Return Plotly's program, compressed, as base64; the page's script unpacks it."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _json(value: Any) -> str:
    """Return JSON that cannot end the script block that it stands in."""
    return (json.dumps(value, separators=(',', ':')).replace('<', '\\u003c')
            .replace('>', '\\u003e').replace('&', '\\u0026'))
