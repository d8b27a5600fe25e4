"""A law of the user whose answers take longer than a control period: said once."""

from collections.abc import Callable

#: So many answers in a row have to be late: one may be, on a busy machine.
LATE_ANSWERS = 20


class SlowLaw:
    """Warns of the law of ``law_file``; one of the package is in time."""

    def __init__(self, law_file: str, warn: Callable[[str], object]) -> None:
        self._file, self._warn = law_file, warn
        self._late, self._reported = 0, not law_file

    def answered(self, seconds: float, control_rate: int) -> None:
        """Take the wall-clock time of an answer [s]."""
        self._late = self._late + 1 if seconds > 1.0 / control_rate else 0
        if self._late < LATE_ANSWERS or self._reported:
            return
        self._reported = True
        self._warn(f'{self._file}: too late: an answer takes {1e3 * seconds:.3g} ms, a control '
                   f'period {1e3 / control_rate:.3g} ms; a simulator in lockstep waits, a robot '
                   'does not')
