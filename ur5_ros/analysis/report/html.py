"""The report: one HTML file that opens from disk, the verdict first, every figure zoomable."""

import json
import math
import re
from pathlib import Path
from typing import Any

from ur5_ros.analysis.report.document import html_document, write_document
from ur5_ros.analysis.report.document import markup as _text
from ur5_ros.analysis.report.figure import Figure
from ur5_ros.analysis.report.figures import figures
from ur5_ros.analysis.result import FAIL, NOT_APPLICABLE, PASS, Check, Result
from ur5_ros.wording import agree, number_of, run_title

#: Lines of events that a figure can carry; letters of a fact that takes a line of its own.
MARKS, LONG = 40, 60


def write_html(result: Result, path: str | Path) -> None:
    """Write the report of a result, over an older one; InputError if it cannot be written."""
    write_document(html_text(result), path)


def html_text(result: Result) -> str:
    """
    Return the report as text.

    Nothing from the bag becomes markup: every text is escaped, the data stand in a block of JSON,
    and the page's policy lets its own two scripts run and nothing else.

    """
    plots = figures(result)
    first = [plot for plot in plots if plot.first]
    rest = [plot for plot in plots if not plot.first]
    body = ''.join([_verdict(result), _causes(result), figure_section('The run', first),
                    _checks(result), figure_section('Figures', rest), _details(result)])
    return html_document(f'{result.headline}: {_title(result)}', body,
                         [figure_data(figure) for figure in plots if figure.traces],
                         _marks(result))


def _title(result: Result) -> str:
    return run_title(result.about['folder'] or '', result.run)


def _marks(result: Result) -> list[dict[str, Any]]:
    """Return what was added to the plant on the way, for a line in every figure over time."""
    return [{'t': each.t, 'text': each.text[:60]}
            for each in result.series.get('injected', ()) if each.t > 0.0][:MARKS]


def figure_data(figure: Figure) -> dict[str, Any]:
    """Return a figure as the page's script takes it."""
    return {'key': figure.key, 'x': figure.x, 'y': figure.y, 'log': figure.log,
            'equal': figure.equal, 'traces': figure.traces}


def _verdict(result: Result) -> str:
    count = [check.verdict for check in result.checks]
    failed = [check for check in result.checks if check.verdict == FAIL]
    if failed:
        why = (f'Cause: {result.causes[0]["sentence"]}' if result.causes
               else f'First: {failed[0].sentence}')
        words = f'{len(failed)} of {len(count)} checks {agree(len(failed), "fail")}. {why}.'
    else:
        passed = count.count(PASS)
        words = f'{number_of(passed, "check")} {agree(passed, "pass")}'
        skipped = count.count(NOT_APPLICABLE)
        words += f', {skipped} {agree(skipped, "do")} not apply.' if skipped else '.'
    judged = '' if result.headline == result.verdict else ' unjudged'
    return (f'<div class="verdict {_text(result.verdict)}{judged}"><div class="stamp">'
            f'{_text(result.headline)}</div><div><h1>{_text(_title(result))}</h1>'
            f'<p>{_text(words)}</p></div></div>\n{_about(result.about, result.run)}')


def _about(about: dict[str, Any], name: str) -> str:
    sim, control = about.get('simulator') or {}, about.get('controller') or {}
    parameters = control.get('parameters', {})
    summary = sim.get('summary') or {}
    gains = () if parameters.get('mode') == 'cartesian_impedance' else ('kp', 'kd')
    rows = {
        'simulator arm': sim.get('arm'), 'controller arm': control.get('arm'),
        'experiment': parameters.get('experiment'),
        'law': parameters.get('law_file') or parameters.get('mode'),
        'Kp, Kd': ', '.join(_gain(parameters[key]) for key in gains if key in parameters),
        'changed while it ran': '; '.join(map(_change, control.get('changes', [])[:3])),
        'added to the plant': '; '.join(_injected(each) for each in about.get('injected', ())[:6]),
        'rates': _rates(about), 'length': f'{about["duration_s"]:.4g} s, {about["states"]} states',
        'ur5_ros': about['ur5_ros'], 'pass marks': about['marks'], 'folder': about['folder'],
        'run': name if name != run_title(about['folder'] or '', name) else '',
    }
    for topic, value in (summary.get('hashes') or {}).items():
        rows[f'hash of {topic}'] = str(value)[:16]
    return '<div class="about">' + ''.join(
        f'<div{" class=wide" if len(str(value)) > LONG else ""}><span>{_text(name)}</span>'
        f'{_text(value)}</div>'
        for name, value in rows.items() if value) + '</div>\n'


def _injected(added: dict[str, Any]) -> str:
    since = f' from {added["from_s"]:.4g} s' if added['from_s'] else ''
    return f'{added["what"]}{since}'


def _rates(about: dict[str, Any]) -> str:
    rate = f'{about["control_rate_hz"]:.6g} Hz'
    physics = about.get('physics_rate_hz')
    return f'{rate}, physics {physics:.6g} Hz' if physics else rate


def _gain(values: Any) -> str:
    numbers = values if isinstance(values, list) else [values]
    return ' '.join(f'{number:g}' for number in numbers[:6]) + (
        ' ...' if len(numbers) > 6 else '')


def _change(change: dict[str, Any]) -> str:
    values = ', '.join(f'{name} {value if isinstance(value, str) else _gain(value)}'
                       for name, value in change.items() if name != 'after_s')
    return f'{values} from {change["after_s"]:.4g} s'


def _causes(result: Result) -> str:
    named = not result.passed and len(result.causes) == 1  # by the verdict, above
    if named or not result.causes:
        return ''
    items = ''.join(f'<li>{_sentence(cause["sentence"])}</li>' for cause in result.causes)
    return f'<h2>Why</h2>\n<ul>{items}</ul>\n'


def _checks(result: Result) -> str:
    order = {FAIL: 0, PASS: 1, NOT_APPLICABLE: 2}
    rows = ''.join(_row(check) for check in sorted(
        result.checks, key=lambda check: order[check.verdict]))
    return ('<h2>Checks</h2>\n<table class="checks"><thead><tr><th>check</th><th>verdict</th>'
            '<th>value</th><th>limit</th><th>in words</th></tr></thead>'
            f'<tbody>{rows}</tbody></table>\n')


def _row(check: Check) -> str:
    number, mark, unit = check.on_screen()
    value, limit = _number(number, unit), _number(mark, unit)
    return (f'<tr><td>{_text(check.name)}</td>'
            f'<td class="pill {_text(check.verdict.replace(" ", "-"))}">{_text(check.verdict)}'
            f'</td><td class="number" data-label="value">{value}</td>'
            f'<td class="number" data-label="limit">{limit}</td>'
            f'<td>{_sentence(check.sentence)}</td></tr>\n')


def _sentence(text: str) -> str:
    """Return a sentence as markup; a line does not end within a number."""
    return re.sub(r'\d[\d.]*e-\d+', r'<span class="whole">\g<0></span>', _text(text))


def _number(value: float | None, unit: str) -> str:
    if value is None:
        return '&ndash;'
    if value == math.inf:
        return 'never'
    if value == 1.0 and len(unit) > 2:
        unit = unit.removesuffix('s')  # states, answers, gaps
    return _text(f'{value:.3g} {unit}'.strip())


def figure_section(title: str, plots: list[Figure]) -> str:
    """Return the markup into which figures are drawn."""
    if not plots:
        return ''
    boxes = ''.join(
        f'<figure{" class=wide" if plot.wide else ""}><figcaption><b>{_text(plot.title)}</b>'
        f'{_text(plot.caption)}</figcaption>{_box(plot)}</figure>\n' for plot in plots)
    return f'<h2>{_text(title)}</h2>\n<div class="plots">{boxes}</div>\n'


def _box(plot: Figure) -> str:
    if not plot.traces:
        return f'<p class="note">{_text(plot.note)}</p>'
    return f'<div class="plot" id="plot-{_text(plot.key)}"></div>'


def _details(result: Result) -> str:
    document = json.loads(result.to_json())
    parts = [('Events', document['about'].pop('events')), ('Run and parameters',
             document['about']), ('Numbers of the checks', document['checks']),
             ('Causes', document['causes'])]
    return '<h2>Details</h2>\n' + ''.join(
        f'<details><summary>{_text(title)}</summary><pre>'
        f'{_text(json.dumps(value, indent=2))}</pre></details>\n'
        for title, value in parts if value)
