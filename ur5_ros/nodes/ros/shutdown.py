"""Signals to an orderly end: at once while a node starts, after the present period later."""

import os
import signal
import sys
import threading

#: A closed terminal, Ctrl-C and kill all mean the same.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class StopRequest:
    """
    What asks the loop to end: a signal, or the node itself.

    A thread waits for the signals, which are blocked everywhere: a handler would wait until the
    compiler returns to the interpreter, and a system call of the loop would be interrupted.
    rclpy's own handlers shut the context down first, so that nothing could be published any more;
    they are left out (``SignalHandlerOptions.NO``).

    """

    def __init__(self) -> None:
        self.reason = ''
        """Why; empty as long as nothing asked."""
        self._starting = True
        self._lock = threading.Lock()

    def listen(self) -> None:
        """Take the signals; to be called before any other thread is started."""
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        threading.Thread(target=self._wait, name='signals', daemon=True).start()

    def started(self) -> None:
        """Note that the node has something to end in order: a bag, a run, an arm in motion."""
        with self._lock:
            self._starting = False

    def ask(self, reason: str) -> None:
        """Ask for the end; the first reason stands."""
        self.reason = self.reason or reason

    def _wait(self) -> None:
        while True:
            name = signal.Signals(signal.sigwait(SIGNALS)).name
            with self._lock:
                if self._starting:
                    program = os.path.basename(sys.argv[0]).removesuffix('.py')
                    print(f'{program}: ends while it starts: {name}', file=sys.stderr, flush=True)
                    os._exit(0)
            self.ask(name)
