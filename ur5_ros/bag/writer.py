"""Recording: the loop appends to a list; a thread packs, compresses and writes."""

import json
import struct
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ur5_ros.bag.mcap.chunk import MAX_MESSAGE, Message
from ur5_ros.bag.mcap.records import MESSAGE
from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.rosbag2_folder import BagFolder, make_topic
from ur5_ros.cdr.recorded_types import schema_text
from ur5_ros.cdr.recorded_types import type_hash as hash_of_type
from ur5_ros.errors import InputError

#: Wall time between two writes [s]. A killed process loses the messages of at most one such time
#: and of the write itself; 100 ms are promised.
FLUSH_PERIOD = 0.025

#: Messages that may wait for the disk; beyond it they are dropped and counted.
MAX_WAITING = 200_000

#: Largest time of MCAP [ns].
MAX_TIME = 2**64 - 1


class BagWriter:
    """
    A rosbag2 folder that is being written: metadata.yaml and ``<folder>_<n>.mcap``.

    No method raises because of the disk: after the first error nothing more is written,
    ``failure`` is the reason, and ``lost`` counts the messages that are in no file.

    ``folder``: the bag; it must not exist; ``description``: stands in every file and in
    ``custom_data`` of metadata.yaml; ``max_duration``: log time in one file [s]; 0 = no limit;
    ``max_size``: size of one file [bytes]; 0 = no limit;
    ``blocking``: :meth:`write` waits for the disk instead of dropping messages, for everything
    that is no control loop.

    """

    def __init__(self, folder: Path, description: Mapping[str, str],
                 max_duration: float = 60.0, max_size: int = 0, blocking: bool = False) -> None:
        self.folder = Path(folder)
        self._blocking = blocking
        self.failure: str | None = None
        """Why nothing is written any more, or what was wrong with a message, in one sentence."""
        self._waiting: list[Message] = []
        self._notes: list[tuple[str, dict[str, str]]] = []
        self._schema_ids: dict[str, int] = {}
        self._dropped = 0
        self._taken = 0
        self._broken = False
        self._stop = threading.Event()
        self._lock = threading.Lock()
        try:
            self._bag = BagFolder(self.folder, self.folder.name, description,
                                  round(max_duration * 1e9), max_size)
        except FileExistsError:
            raise InputError(f'{self.folder} exists already; give another folder') from None
        except OSError as error:
            raise InputError(f'{self.folder}: cannot record there: {error.strerror}; '
                             'give another folder') from None
        self._thread = threading.Thread(target=self._run, name='bag writer', daemon=True)
        self._thread.start()

    def topic(self, name: str, type: str, qos: Mapping[str, Any] | None = None,
              type_hash: str = '') -> int:
        """
        Announce a topic and return its id.

        ``type``: for example ``sensor_msgs/msg/JointState``; ``qos``: as
        :func:`ur5_ros.bag.metadata.qos_profile` returns it; default: its defaults; ``type_hash``:
        RIHS01 hash; empty: computed from the definition.
        """
        text = schema_text(type).encode()
        with self._lock:
            number = len(self._bag.topics) + 1
            schema_id = self._schema_ids.setdefault(type, len(self._schema_ids) + 1)
            self._bag.topics.append(make_topic(
                number, schema_id, name, (type, text), [qos or qos_profile()],
                type_hash or hash_of_type(type)))
        return number

    def write(self, topic: int, log_time: int, data: bytes,
              publish_time: int | None = None) -> None:
        """
        Hand over a message; the thread packs and writes it.

        ``log_time``: when it was recorded [ns]; ``publish_time``: when it was sent [ns]; default:
        the log time.
        """
        waiting = self._waiting
        while self._blocking and len(waiting) >= MAX_WAITING and self._thread.is_alive():
            time.sleep(FLUSH_PERIOD)
        if len(waiting) < MAX_WAITING:
            waiting.append((topic, log_time,
                            log_time if publish_time is None else publish_time, data))
        else:
            with self._lock:
                self._dropped += 1

    def recorder(self, offset: int) -> Callable[[int, bytes], None]:
        """
        Return :meth:`write` for a control loop: ``record(topic, data)`` of this moment.

        ``offset``: from the steady clock to log times [ns].
        """
        waiting, most, now = self._waiting, MAX_WAITING, time.monotonic_ns

        def record(topic: int, data: bytes) -> None:
            if len(waiting) < most:
                moment = now() + offset
                waiting.append((topic, moment, moment, data))
            else:
                with self._lock:
                    self._dropped += 1

        return record

    def note(self, name: str, values: Mapping[str, Any]) -> None:
        """Add a metadata record; the last one of a name counts."""
        self._notes.append((name, {key: json.dumps(value) for key, value in values.items()}))

    @property
    def lost(self) -> int:
        """Messages handed over that are in no file and never will be."""
        waiting = 0 if self._thread.is_alive() else len(self._waiting)
        return self._dropped + self._taken - self._bag.kept + waiting

    def close(self) -> None:
        """Write what waits, the summary and metadata.yaml; what is handed over later is lost."""
        self._stop.set()
        self._thread.join()

    def __enter__(self) -> 'BagWriter':
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        """Write what waits every FLUSH_PERIOD; runs in the thread."""
        while not self._stop.wait(FLUSH_PERIOD):
            self._flush()
        self._flush()
        if not self._broken:
            self._guard(self._bag.finish)

    def _flush(self) -> None:
        # Appending, slicing and deleting are each atomic under the interpreter lock, and others
        # only append: nothing is lost between the two lines.
        messages = self._waiting[:]
        del self._waiting[:len(messages)]
        notes = self._notes[:]
        del self._notes[:len(notes)]
        if messages and not self._broken:
            self._guard(self._write, messages)
        self._taken += len(messages)
        for note in notes:
            if not self._broken:
                self._guard(self._bag.note, *note)

    def _write(self, messages: list[Message]) -> None:
        """Write messages, leaving out those that no file could hold."""
        before = self._bag.written
        try:
            self._bag.write(messages)
        except (struct.error, TypeError, KeyError, OverflowError):
            rest = messages[self._bag.written - before:]
            sound = [message for message in rest if self._is_sound(message)]
            self.failure = self.failure or (
                f'bag {self.folder}: {len(rest) - len(sound)} malformed messages were left out; '
                'times are whole nanoseconds, data are bytes')
            self._bag.write(sound)

    def _is_sound(self, message: Message) -> bool:
        topic, log_time, publish_time, data = message
        return (type(topic) is int and 1 <= topic <= len(self._bag.topics)
                and type(log_time) is int and 0 <= log_time <= MAX_TIME
                and type(publish_time) is int and 0 <= publish_time <= MAX_TIME
                and isinstance(data, (bytes, bytearray))
                and len(data) + MESSAGE.size <= MAX_MESSAGE)

    def _guard(self, action: Callable[..., None], *arguments: Any) -> None:
        """Do something to the disk; on the first error give the file up for good."""
        try:
            action(*arguments)
        except Exception as error:  # a bug here must not end the thread, let alone the loop
            reason = getattr(error, 'strerror', None) or f'{type(error).__name__}: {error}'
            self._broken = True
            self.failure = (f'bag {self.folder}: {reason}; recording has stopped, the run goes '
                            'on; repair what was recorded with: ur5 recover')
            with suppress(OSError):
                self._bag.abandon()
