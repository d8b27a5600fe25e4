"""The messages of a run's bags in the order of simulated time, as a replay sends them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.bag.arrays.columns import RawColumns
from ur5_ros.bag.reader import Bag, open_bag
from ur5_ros.bag.run_folders import bags_of_run
from ur5_ros.bag.untyped import declare_by_content
from ur5_ros.cdr.codec import decode, definitions_of, encode
from ur5_ros.errors import BagError, InputError

#: Bytes in front of each message, and the largest second one of them (DDS-XTypes 7.6.3.1.2).
HEADER, LAST_ENCAPSULATION = 4, 0x0b

_STAMPED = 'sensor_msgs/msg/JointState'


class Playback(NamedTuple):
    """Messages in the order in which they are sent."""

    types: dict[str, str]
    """Topic to type of everything that is sent."""
    messages: list[RawColumns]
    """The messages of each topic."""
    time: np.ndarray
    """When each message is send_time, since the beginning of the run [ns], shape (n,)."""
    topic: np.ndarray
    """Index into ``types`` of each message, shape (n,)."""
    row: np.ndarray
    """Which message of its topic, shape (n,)."""
    remarks: tuple[str, ...] = ()
    """What is left out, sent in another form or missing, one sentence each."""

    def data(self, i: int) -> bytes:
        """Return message ``i`` as CDR bytes."""
        messages, row = self.messages[self.topic[i]], self.row[i]
        return messages.data[messages.offsets[row]:messages.offsets[row + 1]].tobytes()


def load_playback(
    run: Path, topics: list[str] | None = None, start: float = 0.0, stop: float | None = None,
    clock: bool = True,
) -> Playback:
    """
    Return the messages of a run's bags, in simulated time where joint states give it.

    A topic that is in several bags (one node's output is the other's input) is taken from the
    first one.

    Parameters
    ----------
    run : Path
        Run folder or bag.
    topics : list of str, optional
        Only these; all if not given.
    start, stop : float, optional
        Part of the run [s].
    clock : bool, optional
        Send ``/clock`` as well.

    Raises
    ------
    InputError
        If there is no bag or no such topic, or there is no message between start and stop.

    """
    found: dict[str, RawColumns] = {}
    types: dict[str, str] = {}
    remarks: list[str] = []
    send_time: dict[str, np.ndarray] = {}
    for folder in bags_of_run(run):
        bag = open_bag(folder)
        named = [topic for topic in bag.topics if topic not in types
                 and (topics is None or topic in topics) and (clock or topic != '/clock')]
        simulated = _clock_of(bag)
        for topic in named:
            columns = ros2_messages(bag, topic, remarks)
            if columns is None:
                continue
            columns = _without_broken(columns, topic, remarks)
            if len(columns.log_time):
                types[topic], found[topic] = bag.topics[topic], columns
                send_time[topic] = simulated(columns.log_time)
        remarks += bag.problems
    for topic in topics or ():
        if topic not in types:
            why = ''.join(f' ({remark})' for remark in remarks if topic in remark)
            raise InputError(f'{run}: nothing on topic {topic}{why}; there is: '
                             f'{", ".join(types) or "nothing"}')
    if not types:
        remarks += [problem for folder in bags_of_run(run) for problem in open_bag(folder).check()]
        why = f': {remarks[0]}' if remarks else '; give a run with messages in it'
        raise InputError(f'{run}: no message to send{why}')
    return _in_order(types, found, send_time, start, stop, run)._replace(remarks=tuple(remarks))


def ros2_messages(bag: Bag, topic: str, remarks: list[str]) -> RawColumns | None:
    """Return the messages of a topic as ROS 2 sends them, None where they are of another kind."""
    if not bag.topics[topic] and not declare_by_content(bag, topic, _STAMPED):
        remarks.append(f'topic {topic}: the file does not state its type; it is left out')
        return None
    form = bag.form(topic)
    if form == 'other':
        try:
            bag.definitions(topic)
        except BagError as problem:
            remarks.append(f'{problem}; it is left out')
            return None
        remarks.append(f'topic {topic}: its messages have other fields than in ROS 2; those of '
                       'ROS 2 are sent')
        return _converted(bag, topic)
    return bag.columns(topic)


def _without_broken(raw: RawColumns, topic: str, remarks: list[str]) -> RawColumns:
    """Return messages without those that no subscriber could read: too short, or not CDR."""
    begins, sizes = raw.offsets[:-1], np.diff(raw.offsets)
    whole = sizes >= HEADER
    first = begins[whole]
    whole[whole] = (raw.data[first] == 0) & (raw.data[first + 1] <= LAST_ENCAPSULATION)
    if whole.all():
        return raw
    remarks.append(f'topic {topic}: {np.sum(~whole)} of {len(whole)} messages are no CDR; they '
                   'are left out')
    kept = [raw.data[begin:begin + size] for begin, size in
            zip(begins[whole].tolist(), sizes[whole].tolist(), strict=True)]
    return RawColumns(raw.log_time[whole], raw.publish_time[whole],
                      np.concatenate([*kept, np.zeros(0, np.uint8)]),
                      np.concatenate([[0], np.cumsum(sizes[whole])]))


def _converted(bag: Bag, topic: str) -> RawColumns:
    """Return messages with the fields that ROS 2 gives their type."""
    type_name, raw = bag.topics[topic], bag.columns(topic)
    definitions, times, data = bag.definitions(topic), [], []
    for i in range(len(raw.log_time)):
        try:
            message = decode(type_name, raw.data[raw.offsets[i]:raw.offsets[i + 1]].tobytes(),
                             definitions)
        except BagError:
            continue
        times.append(i)
        data.append(encode(type_name, _known_fields(type_name, message)))
    offsets = np.cumsum([0, *map(len, data)])
    return RawColumns(raw.log_time[times], raw.publish_time[times],
                      np.frombuffer(b''.join(data), np.uint8), offsets)


def _known_fields(type_name: str, message: dict[str, Any]) -> dict[str, Any]:
    """Return a message without the fields that its ROS 2 type does not have."""
    known: dict[str, Any] = {}
    for field in definitions_of(type_name)[type_name]:
        value = message[field.name]
        if field.nested:
            value = ([_known_fields(field.base, each) for each in value] if field.array else
                     _known_fields(field.base, value))
        known[field.name] = value
    return known


def _in_order(
    types: dict[str, str], found: dict[str, RawColumns], send_time: dict[str, np.ndarray],
    start: float, stop: float | None, run: Path,
) -> Playback:
    time = np.concatenate([send_time[topic] for topic in types])
    log_time = np.concatenate([found[topic].log_time for topic in types])
    number = np.concatenate([np.full(len(send_time[topic]), i) for i, topic in enumerate(types)])
    row = np.concatenate([np.arange(len(send_time[topic])) for topic in types])
    time = time - time.min()
    order = np.lexsort((log_time, time))
    low, high = start * 1e9, np.inf if stop is None else stop * 1e9
    order = order[(time[order] >= low) & (time[order] <= high)]
    if not len(order):
        raise InputError(f'{run}: no message between {start:g} s and {high * 1e-9:g} s; it is '
                         f'{time.max() * 1e-9:.3f} s long')
    return Playback(types, list(found.values()), time[order] - time[order[0]], number[order],
                    row[order])


def _clock_of(bag: Bag) -> Callable[[np.ndarray], np.ndarray]:
    """Return the function from log time to simulated time: the newest state's stamp."""
    names = [topic for topic, kind in bag.topics.items()
             if kind == _STAMPED and topic.endswith('joint_states')]
    try:
        states = bag.joint_states(names[0]) if names else None
    except BagError:  # such messages are left out of the replay
        states = None
    if states is None or len(states.stamp) < 2 or (np.diff(states.stamp) < 0).any() or (
            states.stamp[0] == states.stamp[-1]):
        return lambda log_time: log_time

    def simulated(log_time: np.ndarray) -> np.ndarray:
        at = np.searchsorted(states.log_time, log_time, side='right') - 1
        return states.stamp[np.maximum(at, 0)]

    return simulated
