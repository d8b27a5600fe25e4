"""Torque mode: when commands act, when silence ends that, and how large and fast torque may be."""

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.sim.event_log import EventLog


class TorqueMode:
    """
    Which commands act, and how much of them.

    The first command enters torque mode.  Silence leaves it: where ``leave_torque_mode`` is true
    commands are then ignored until :meth:`resume`, otherwise the next one enters it again.

    """

    def __init__(self, parameters: SimParameters, log: EventLog):
        self._latches, self._log = parameters.leave_torque_mode, log
        self._largest = np.array(parameters.torque_limit or [np.inf] * 6)
        self._change = parameters.torque_rate_limit / parameters.control_rate or np.inf
        limited = np.isfinite(self._largest).any() or np.isfinite(self._change)
        self.matters = bool(self._latches or limited)
        """Whether a command may act otherwise than as it is."""
        self._entered = self._left = False
        self._last = np.zeros(6)

    def admit(self, command: np.ndarray | None, stamp: int) -> np.ndarray | None:
        """
        Return the command if it acts; None where the fallback does.

        ``command`` (6,): the command for this period [N m]; None = silence; ``stamp``: of the
        present state [ns].
        """
        if command is None:
            self._last = np.zeros(6)
        if not self._latches:
            return command
        if self._left:
            return None
        if command is not None and not self._entered:
            self._entered = True
            self._log.add(stamp, 'torque_mode', 'torque mode is entered', active=True)
        elif command is None and self._entered:
            self._entered, self._left = False, True
            self._log.add(stamp, 'torque_mode', 'silence ends torque mode; commands are ignored '
                          'until ~/resume_torque_mode is called', active=False)
        return command

    def limit(self, command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return a command within its limits of size and rate [N m], and the joints limited."""
        least = np.maximum(-self._largest, self._last - self._change)
        most = np.minimum(self._largest, self._last + self._change)
        self._last = np.minimum(np.maximum(command, least), most)
        return self._last, self._last != command

    def resume(self) -> str:
        """Let the next command enter torque mode again; return what to answer."""
        if not self._left:
            return 'torque mode was not left: commands act'
        self._left = False
        return 'the next command enters torque mode'
