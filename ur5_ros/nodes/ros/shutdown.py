"""Signals to an orderly end: the loop sees the request, and ends undisturbed."""

import signal
from types import FrameType

#: A closed terminal, Ctrl-C and kill all mean the same.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def hold_signals() -> None:
    """
    Let signals wait until a :class:`StopRequest` listens.

    The ROS packages from PyPI begin with executing Python once more: handlers and what they noted
    are lost with that, the signals that wait are not.

    """
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)


class StopRequest:
    """
    What asks the loop to end: a signal, or the node itself.

    rclpy's own handlers shut the context down first, so that nothing could be published any more;
    they are left out (``SignalHandlerOptions.NO``) in favour of this.

    """

    def __init__(self) -> None:
        self.reason = ''
        """Why; empty as long as nothing asked."""

    def listen(self) -> None:
        """Take the signals over, those that wait first; a second one changes nothing."""
        for number in SIGNALS:
            signal.signal(number, self._on_signal)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)

    def ask(self, reason: str) -> None:
        """Ask for the end; the first reason stands."""
        self.reason = self.reason or reason

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.ask(signal.Signals(number).name)
