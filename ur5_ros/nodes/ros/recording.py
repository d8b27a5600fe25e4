"""What a node records: every input and output, into the run's folder, under one steady clock."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.run_folders import BAGS
from ur5_ros.bag.writer import BagWriter
from ur5_ros.config.topics import NEWEST, Qos
from ur5_ros.errors import InputError
from ur5_ros.nodes.ros.realtime import prioritize_threads

#: Messages kept while the run's name is not known yet: half a minute of a 1 kHz loop.
MOST_BUFFERED = 200_000

#: Values of the parameter ``bag`` without a recording; a shell makes nothing of bag:=''.
NO_BAG = ('', 'none')


class Recording:
    """
    A bag that is opened when the run has a name; what comes before waits in memory.

    ``where``: the parameter ``bag``: ``'auto'``, a folder, or empty for no recording; ``node``:
    ``'sim'`` or ``'control'``; ``max_duration``, ``max_size``: when a file is split [s], [bytes];
    0 = never.

    """

    def __init__(self, where: str, node: str, max_duration: float, max_size: int) -> None:
        self.where = where = '' if where in NO_BAG else where
        self.node = node
        self._split = (max_duration, max_size)
        self._topics: list[tuple[str, str, Mapping[str, Any]]] = []
        self._writer: BagWriter | None = None
        self._buffer: list[tuple[int, int, bytes]] = []
        self._dropped = 0
        self._lost = 0
        self._failure: str | None = None
        # the wall clock may jump, log times must not
        self._offset = time.time_ns() - time.monotonic_ns()
        self.write: Callable[[int, bytes], None] = self._keep if where else _forget
        """``write(topic, data)``: record CDR bytes under the number of a topic."""

    def topic(self, name: str, type_name: str, qos: Qos = NEWEST) -> int:
        """Announce a topic before the bag is opened and return its number."""
        self._topics.append((name, type_name, qos_profile(**qos._asdict())))
        return len(self._topics)

    @property
    def is_open(self) -> bool:
        """Whether there is a bag, or nothing to record at all."""
        return self._writer is not None or not self.where

    @property
    def folder(self) -> Path | None:
        """Where the bag is; None as long as there is none."""
        return self._writer.folder if self._writer else None

    @property
    def lost(self) -> int:
        """Messages that are in no file."""
        return self._lost + self._dropped + (self._writer.lost if self._writer else 0)

    @property
    def failure(self) -> str | None:
        """Why nothing is written any more; None while all is well."""
        return (self._writer.failure if self._writer else None) or self._failure

    def begin(self, run: str, description: Mapping[str, str]) -> None:
        """Open the bag and write what waits."""
        if not self.where:
            return
        self._writer = BagWriter(self._new_folder(run), description, *self._split)
        prioritize_threads()  # the writer's: this one waits for it where both need the interpreter
        for topic in self._topics:
            self._writer.topic(*topic)
        for message in self._buffer:
            self._writer.write(*message)
        self._buffer.clear()
        self.write = self._writer.recorder(self._offset)

    def note(self, name: str, values: Mapping[str, Any]) -> None:
        """Add a metadata record to the bag, if one is open."""
        if self._writer is not None:
            self._writer.note(name, values)

    def end(self, summary: Mapping[str, Any]) -> None:
        """Close the bag with its summary; messages of a next run wait in memory again."""
        if self._writer is None:
            return
        self._writer.note('summary', summary)
        self._writer.close()
        self._lost += self._writer.lost
        self._failure = self._failure or self._writer.failure
        self._writer = None
        self.write = self._keep

    def _keep(self, topic: int, data: bytes) -> None:
        if len(self._buffer) < MOST_BUFFERED:
            self._buffer.append((topic, time.monotonic_ns() + self._offset, data))
        else:
            self._dropped += 1

    def _new_folder(self, run: str) -> Path:
        """Return where the bag goes; a controller may join a run twice, or a second run."""
        folder = BAGS / run / self.node
        if self.where != 'auto':
            folder = Path(self.where).expanduser()
        if self.node == 'sim':
            return folder
        free, number = folder, 2
        while free.exists():
            free, number = folder.with_name(f'{folder.name}_{number}'), number + 1
        return free


def refuse_folder(where: str) -> None:
    """Refuse a folder for the bag that exists already."""
    if where not in (*NO_BAG, 'auto') and Path(where).expanduser().exists():
        raise InputError(f'bag folder {where} exists; give another one, or remove it')


def run_of(where: str, new_name: Callable[[], str]) -> str:
    """
    Return the name of the run that a node begins.

    A folder ``<run>/sim`` or ``<run>/control`` names it; otherwise it gets a new name.
    """
    if where in (*NO_BAG, 'auto'):
        return new_name()
    refuse_folder(where)
    folder = Path(where).expanduser()
    parent = folder.absolute().parent.name
    return parent if folder.name in ('sim', 'control') and parent else new_name()


def _forget(topic: int, data: bytes) -> None:
    """Record nothing."""
