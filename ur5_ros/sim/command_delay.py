"""Commands that arrive some control periods after they were given."""

import numpy as np


class CommandDelay:
    """
    A line of commands under way.

    A command given in period k under a delay of d acts in period k + d.  Of several that arrive
    together the one given last acts.  A period in which none arrives, because the delay has just
    grown, keeps the command before.

    """

    def __init__(self):
        self.clear()

    def clear(self) -> None:
        """Drop everything under way."""
        self._under_way: list[tuple[int, np.ndarray | None]] = []
        self.acting: np.ndarray | None = None
        """The command that acted last; without a delay the plant keeps it up to date."""

    @property
    def busy(self) -> bool:
        """Whether commands are under way."""
        return bool(self._under_way)

    def exchange(self, k: int, command: np.ndarray | None, delay: int) -> np.ndarray | None:
        """
        Return the command that acts in period ``k``, given the one issued in it.

        ``command`` (6,): what is given now; None = no command.
        """
        kept = None if command is None else np.array(command, dtype=float)
        self._under_way.append((k + delay, kept))
        arrived = [i for i, (due, _) in enumerate(self._under_way) if due <= k]
        if arrived:
            self.acting = self._under_way[arrived[-1]][1]
            del self._under_way[:arrived[-1] + 1]  # older ones still under way are overtaken
        return self.acting
