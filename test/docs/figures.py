"""
The figures of the documents, and where each comes from (figures.yaml).

A figure is a number with a unit in the prose of README.md and docs/, outside of code, inline code
and links.  Pages that a program writes whole are left to the tests of those programs.  Beside each
figure figures.yaml names one of

    test/sim/test_x.py::test_that, config/a.yaml, ur5_ros/x.py::NAME
                                              the number stands in that file, in what has that name
    benchmarks/results/x.json#rows.0.ratio    the number is this one, rounded
    code                                      the number stands in the code of the page, which runs
    source: TEXT                              others measured it: the page names TEXT
"""

import ast
import itertools
import json
import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

import polars

ROOT = Path(__file__).resolve().parents[2]
#: Written by benchmarks/table.py, benchmarks/soak.py, make faults and docs/generate.py.
WRITTEN = ('performance.md', 'soak.md', 'faults.md', 'reference')
PAGES = [ROOT / 'README.md', *(page for page in sorted((ROOT / 'docs').rglob('*.md'))
                               if not set(WRITTEN) & {page.name, page.parent.name})]
#: Units and what a number with it is in the units of the code.
UNITS = {
    '%': 1e-2, 'microseconds': 1e-6, 'µs': 1e-6, 'us': 1e-6, 'ms': 1e-3, 's': 1.0, 'seconds': 1.0,
    'minutes': 60.0, 'minute': 60.0, 'hours': 3600.0, 'hour': 3600.0,
    'MiB': 2.0**20, 'KiB': 2.0**10, 'MB': 1e6, 'GB': 1e9,
    'N m': 1.0, 'kN/m': 1e3, 'N/m': 1.0, 'mN m': 1e-3, 'N': 1.0, 'kg m': 1.0, 'kg': 1.0, 'J': 1.0,
    'mrad/s': 1e-3, 'rad/s': 1.0, 'mrad': 1e-3, 'rad': 1.0, 'm/s': 1.0, 'mm/s': 1e-3,
    'µm': 1e-6, 'mm': 1e-3, 'cm': 1e-2, 'm': 1.0, 'kHz': 1e3, 'Hz': 1.0, 'A': 1.0,
    'times': 1.0, 'periods': 1.0, 'runs': 1.0, 'rows': 1.0, 'restarts': 1.0, 'kills': 1.0,
    'messages': 1.0, 'seeds': 1.0, 'seeded runs': 1.0, 'states': 1.0, 'tests': 1.0,
}
_NUMBER = r'\d[\d,_]*(?:\.\d+)?(?:e-?\d+)?'
NUMBERS = re.compile(_NUMBER)
PATTERN = re.compile(
    rf'(?<![\w.^/])-?({_NUMBER}(?:(?:, | to | and |, and | or | against ){_NUMBER})*)'
    rf'[ \n]?({"|".join(sorted(map(re.escape, UNITS), key=len, reverse=True))})(?![\w])')
_LITERAL = re.compile(r'(?<![\w.])(?:\d[\d_]*\.?\d*|\.\d+)(?:e[+-]?\d+)?(?!\w)', re.IGNORECASE)


class Figure(NamedTuple):
    """A number of a page with its unit."""

    page: str
    line: int
    text: str
    value: float
    unit: str

    @property
    def name(self) -> str:
        """How figures.yaml names it."""
        return f'{self.text} {self.unit}'


def prose(text: str) -> str:
    """Return a page's text with code, inline code and the targets of links blanked."""
    def blank(found: re.Match) -> str:
        return '\n' * found[0].count('\n')
    text = re.sub(r'^```.*?^```|<!--.*?-->', blank, text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r'`[^`\n]*`', '``', text)
    return re.sub(r'\]\([^)\n]*\)', ']', text)


def figures() -> list[Figure]:
    """Return every figure of every page."""
    found = []
    for page in PAGES:
        text = prose(page.read_text(encoding='utf-8'))
        for match in PATTERN.finditer(text):
            line = text[:match.start()].count('\n') + 1
            for number in NUMBERS.findall(match[1]):
                number = number.rstrip(',')
                found.append(Figure(str(page.relative_to(ROOT)), line, number,
                                    float(number.replace(',', '').replace('_', '')), match[2]))
    return found


@cache
def numbers(place: str) -> frozenset[float]:
    """Return the numbers that stand in ``FILE``, or in ``FILE::NAME``."""
    name, _, part = place.partition('::')
    text = (ROOT / name).read_text(encoding='utf-8')
    if part:
        text = _python(text, part) if name.endswith('.py') else _yaml(text, part)
    return frozenset(float(each.replace('_', '')) for each in _LITERAL.findall(text))


def _python(text: str, name: str) -> str:
    """Return the source of a function, class or constant of a module."""
    for node in ast.parse(text).body:
        targets = [each.id for target in getattr(node, 'targets', ()) for each in ast.walk(target)
                   if isinstance(each, ast.Name)]
        if getattr(node, 'name', None) == name or name in targets:
            return ast.get_source_segment(text, node)
    raise KeyError(name)


def _yaml(text: str, key: str) -> str:
    """Return the lines of a key: it and what is indented further."""
    lines = text.splitlines()
    first = next(i for i, line in enumerate(lines) if line.strip().startswith(f'{key}:'))
    indent = len(lines[first]) - len(lines[first].lstrip())
    deeper = ' ' * (indent + 1)
    rest = itertools.takewhile(lambda line: not line.strip() or line.startswith(deeper),
                               lines[first + 1:])
    return '\n'.join([lines[first], *rest])


def shows(found: frozenset[float], figure: Figure) -> bool:
    """Tell whether a number is among some, in its unit or in that of the code."""
    expected = [figure.value, figure.value * UNITS[figure.unit]]
    if figure.unit == 's':
        expected.append(1000.0 * figure.value)  # periods of 1 ms
    if figure.unit == '%':
        expected.append(1.0 - 0.01 * figure.value)  # less by so much
    return any(abs(number - want) <= 1e-9 * abs(want) for number in found for want in expected)


def measured(place: str) -> list[float]:
    """Return the number at ``FILE#key.key`` of a result file, or those in the text there."""
    name, _, keys = place.partition('#')
    value = json.loads((ROOT / name).read_text(encoding='utf-8'))
    while keys:  # a key may hold a dot
        key = next((each for each in value if keys == each or keys.startswith(f'{each}.')), None) \
            if isinstance(value, dict) else keys.partition('.')[0]
        value = value[key] if isinstance(value, dict) else value[int(key)]
        keys = keys[len(key) + 1:]
    return [float(each) for each in _LITERAL.findall(str(value))]


def agrees(figure: Figure, evidence: str) -> bool:
    """Tell whether a figure is what its evidence says."""
    text = (ROOT / figure.page).read_text(encoding='utf-8')
    if evidence.startswith('source: '):
        return evidence.removeprefix('source: ') in ' '.join(text.split())
    if evidence == 'code':
        blocks = '\n'.join(re.findall(r'^```\w+$.*?^```', text, re.DOTALL | re.MULTILINE))
        return shows(frozenset(map(float, _LITERAL.findall(blocks))), figure)
    if '#' not in evidence and not evidence.endswith('.parquet'):
        return shows(numbers(evidence), figure)
    values = measured(evidence) if '#' in evidence else _table(ROOT / evidence)
    mantissa, _, exponent = figure.text.partition('e')
    whole, _, decimals = mantissa.replace(',', '').partition('.')
    zeros = len(whole) - len(whole.rstrip('0')) if not decimals and len(whole) > 2 else 0
    half = 0.5 * 10.0**(int(exponent or 0) + zeros - len(decimals))
    return any(abs(value / scale - figure.value) <= half * 1.000001
               for value in values for scale in (1.0, UNITS[figure.unit]))


@cache
def _table(path: Path) -> frozenset[float]:
    """Return the numbers of a table and the number of its rows."""
    table = polars.read_parquet(path)
    values = {float(table.height)}
    for column in table.select(polars.selectors.numeric()):
        values |= {float(each) for each in column.drop_nulls().unique()}
    return frozenset(values)
