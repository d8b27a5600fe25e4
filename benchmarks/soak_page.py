"""
docs/soak.md from the figures of a soak.

    python benchmarks/soak_page.py FIGURES.json
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

from side_by_side import machine

PAGE = Path(__file__).resolve().parents[1] / 'docs' / 'soak.md'
#: Figures of a mode that are lists over time, not lines of the table.
COURSES = ('sim memory by time [s, MiB]', 'control memory by time [s, MiB]')

HEAD = """# Soak

Made by `make soak`; do not edit. Both nodes run half of the time in lockstep and half paced by
the wall clock, each part of both bags is read as soon as it is closed, and memory is taken at the
same phase of the split cycle. Two figures in brackets are those at the end of the warm-up and at
the end.
"""


def page(results: list[dict[str, Any]]) -> str:
    """Return the document."""
    minutes = sum(result['minutes'] for result in results)
    facts = machine()
    lines = [HEAD, f'{time.strftime("%Y-%m-%d", time.gmtime())}, {minutes:g} minutes, '
             f'{facts["processor"]}, {facts["cores"]} cores, Python {facts["python"]}.', '']
    for result in results:
        lines += [f'## {result["mode"].capitalize()}', '', '| figure | value |', '|---|---|']
        lines += [f'| {name} | {_text(value)} |' for name, value in result.items()
                  if name not in (*COURSES, 'mode', 'failures')]
        lines += ['', f'Failures: {"; ".join(result["failures"]) or "none"}.', '',
                  '| minutes | sim [MiB] | control [MiB] |', '|---|---|---|', *_course(result), '']
    return '\n'.join(lines)


def _text(value: Any) -> str:
    return f'{value:,}' if isinstance(value, int) else json.dumps(value)


def _course(result: dict[str, Any]) -> list[str]:
    """Return the memory of both nodes every five minutes, or as often as a part was closed."""
    sim, control = (result[name] for name in COURSES)
    last, lines = -300.0, []
    for when, resident in sim:
        nearest = min(control, key=lambda each: abs(each[0] - when), default=None)
        if when - last >= min(300.0, 6.0 * result['minutes']) and nearest:
            lines.append(f'| {when / 60:.0f} | {resident:.1f} | {nearest[1]:.1f} |')
            last = when
    return lines


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(json.loads(Path(sys.argv[1]).read_text(encoding='utf-8'))))
    print(PAGE)


if __name__ == '__main__':
    main()
