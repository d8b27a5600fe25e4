"""The control rate of a source of states: reported, configured, or agreed upon by many stamps."""

from collections import deque

from ur5_ros.errors import InputError

#: Control rates that a simulator can have [Hz].
LOWEST_RATE, HIGHEST_RATE = 1, 10_000
#: States whose stamps must agree where nothing reports or configures the rate.
AGREEING_STATES = 20
#: Stamps are rounded to whole nanoseconds, so that a difference of two is off by at most [ns].
_ROUNDING = 1.0


class ControlRate:
    """
    Control periods a second, from the most reliable source that there is.

    What the simulator reports counts first, then the parameter, then the stamps. One stamp says
    nothing: state k of a run at any rate has a stamp that state 1 of another one has.

    ``configured``: parameter ``control_rate`` of the controller [Hz]; 0 = not given.

    """

    def __init__(self, configured: int = 0) -> None:
        self._configured = configured or None
        self._reported: int | None = None
        self._agreed: int | None = None
        self._stamps: deque[int] = deque(maxlen=AGREEING_STATES)

    @property
    def value(self) -> int | None:
        """Control periods a second [Hz]; None while nothing is known."""
        return self._reported or self._configured or self._agreed

    @property
    def source(self) -> str:
        """Where the rate is from: ``simulator``, ``parameter``, ``stamps`` or empty."""
        found = (('simulator', self._reported), ('parameter', self._configured),
                 ('stamps', self._agreed))
        return next((name for name, rate in found if rate), '')

    def report(self, rate: float) -> None:
        """
        Take what the simulator reports.

        ``rate``: control periods a second [Hz].
        """
        if not (LOWEST_RATE <= rate <= HIGHEST_RATE and rate == int(rate)):
            raise InputError(f'control rate {rate} Hz; give a whole number from {LOWEST_RATE} to '
                             f'{HIGHEST_RATE}')
        self._reported = int(rate)

    def observe(self, stamp: int) -> None:
        """
        Take the stamp of a new state, where nothing more reliable gives the rate.

        ``stamp``: stamp of a state [ns], later than the one before it.
        """
        if self._reported or self._configured:
            return
        self._stamps.append(stamp)
        if len(self._stamps) == AGREEING_STATES:
            self._agreed = _common_rate(list(self._stamps))

    def begin_run(self, keep_report: bool = False) -> None:
        """Forget what was known of the simulator before: another one has taken its place."""
        if not keep_report:
            self._reported = None
        self._agreed = None
        self._stamps.clear()


def _common_rate(stamps: list[int]) -> int | None:
    """Return the rate of which all differences are whole periods; None if there is none."""
    differences = [after - before for before, after in zip(stamps, stamps[1:], strict=False)]
    shortest = min(differences)
    if shortest <= 0:
        return None
    # the sum of all has the smallest error for one period
    periods = sum(round(difference / shortest) for difference in differences)
    rate = round(1e9 * periods / (stamps[-1] - stamps[0]))
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        return None
    period = 1e9 / rate
    off = max(abs(difference - round(difference / period) * period) for difference in differences)
    return rate if off <= _ROUNDING else None
