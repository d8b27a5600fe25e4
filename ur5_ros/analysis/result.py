"""What a validation found: checks with a verdict, a number and a sentence; JSON and JUnit XML."""

import json
import math
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

#: Version of the JSON document; grows when a key changes its meaning or goes away.
JSON_VERSION = 1

PASS, FAIL, NOT_APPLICABLE = 'pass', 'fail', 'not applicable'
#: Units of a screen, and so many of them in one of the document.
_SCREEN_UNITS = {'m': ('mm', 1e3), 'rad': ('mrad', 1e3), '1': ('', 1.0)}


@dataclass(frozen=True)
class Check:
    """One question asked of a run, and the answer."""

    name: str
    """Short name, stable across versions."""
    verdict: str
    """``pass``, ``fail`` or ``not applicable``."""
    sentence: str
    """The answer in words; names the joint where one is at fault."""
    value: float | None = None
    """The number that was judged, if there is one."""
    limit: float | None = None
    """The mark it was judged by."""
    unit: str = ''
    """Unit of value and limit."""
    details: dict[str, Any] = field(default_factory=dict)
    """More numbers: plain dicts, lists, texts and numbers."""

    def on_screen(self) -> tuple[float | None, float | None, str]:
        """Return value, limit and unit as a screen shows them: lengths in mm, angles in mrad."""
        unit, scale = _SCREEN_UNITS.get(self.unit, (self.unit, 1.0))
        value, limit = (None if number is None else scale * number
                        for number in (self.value, self.limit))
        return value, limit, unit


def judge(name: str, value: float, limit: float, unit: str, sentence: str, **details) -> Check:
    """
    Return a check that passes when ``value`` is a number and at most ``limit``.

    ``value``, ``limit``: the number and its mark; a NaN fails.
    """
    value = float(value)
    verdict = PASS if value <= limit else FAIL
    return Check(name, verdict, sentence, value, float(limit), unit, details)


def not_applicable(name: str, why: str, **details) -> Check:
    """Return a check that could not be asked of this run, and why."""
    return Check(name, NOT_APPLICABLE, why, details=details)


@dataclass(frozen=True)
class Result:
    """All checks of one run, and what is needed to know which run that was."""

    run: str
    """Name of the run."""
    about: dict[str, Any]
    """Folder, arms, rates, gains, versions, number of samples, ..."""
    checks: tuple[Check, ...]
    """In the order of the report."""
    causes: tuple[dict[str, Any], ...] = ()
    """What the residual comes from, most important first; empty where it needs no cause."""
    series: dict[str, Any] = field(default_factory=dict, repr=False)
    """Arrays for the figures; not part of the JSON document."""

    @property
    def verdict(self) -> str:
        """``fail`` if any check fails or none passes, else ``pass``."""
        verdicts = {check.verdict for check in self.checks}
        return FAIL if FAIL in verdicts or PASS not in verdicts else PASS

    @property
    def passed(self) -> bool:
        """Whether the verdict is ``pass``."""
        return self.verdict == PASS

    @property
    def controller_judged(self) -> bool:
        """Whether the checks judge the controller."""
        return not any(check.name == 'controller' for check in self.checks)

    @property
    def headline(self) -> str:
        """The verdict in words: a pass without a reference does not judge the controller."""
        if self.passed and not self.controller_judged:
            simulator = self.about.get('simulator') or {}
            passed = 'simulation consistent' if simulator.get('parameters') else PASS
            return f'{passed}; controller not judged'
        return self.verdict

    def check(self, name: str) -> Check:
        """Return the check called ``name``."""
        return next(check for check in self.checks if check.name == name)

    def to_plain(self) -> dict[str, Any]:
        """Return the JSON document as plain values; docs/validation.md describes it."""
        return plain({
            'format': 'ur5_ros validation',
            'version': JSON_VERSION,
            'run': self.run,
            'verdict': self.verdict,
            'headline': self.headline,
            'checks': [
                {'name': check.name, 'verdict': check.verdict, 'value': check.value,
                 'limit': check.limit, 'unit': check.unit, 'sentence': check.sentence,
                 'details': check.details}
                for check in self.checks],
            'causes': list(self.causes),
            'about': self.about,
        })

    def to_json(self) -> str:
        """Return the JSON document as text; numbers that are not finite become null."""
        return json.dumps(self.to_plain(), indent=2, allow_nan=False) + '\n'

    def to_junit(self) -> str:
        """Return the checks as JUnit XML: one test case a check, for CI systems."""
        count = [check.verdict for check in self.checks]
        suite = ElementTree.Element('testsuite', {
            'name': _xml('ur5 validate ' + self.run), 'tests': str(len(count)),
            'failures': str(count.count(FAIL)), 'skipped': str(count.count(NOT_APPLICABLE)),
            'errors': '0'})
        for check in self.checks:
            case = ElementTree.SubElement(suite, 'testcase', {
                'classname': _xml('ur5.' + self.run), 'name': _xml(check.name), 'time': '0'})
            if check.verdict == FAIL:
                ElementTree.SubElement(case, 'failure', {'message': _xml(check.sentence)})
            elif check.verdict == NOT_APPLICABLE:
                ElementTree.SubElement(case, 'skipped', {'message': _xml(check.sentence)})
        return ElementTree.tostring(suite, encoding='unicode', xml_declaration=True) + '\n'


def plain(value: Any) -> Any:
    """Return ``value`` with NumPy types unwrapped and non-finite numbers replaced by None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, 'tolist'):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _xml(text: str) -> str:
    """Return ``text`` without the characters that XML 1.0 cannot hold."""
    return ''.join(c if c in '\t\n\r' or 0x20 <= ord(c) < 0xD800 or 0xE000 <= ord(c) < 0xFFFE
                   or ord(c) > 0xFFFF else '?' for c in text)
