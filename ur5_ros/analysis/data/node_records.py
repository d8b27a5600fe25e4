"""A bag's own description: its node, run, arm, parameters, live changes and events."""

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import NodeRecord, ParameterChange, RecordedEvent
from ur5_ros.bag.arrays.columns import RawColumns
from ur5_ros.bag.reader import Bag
from ur5_ros.cdr.codec import decode
from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS, complete, parse_arm
from ur5_ros.config.arms import tool_of
from ur5_ros.config.parameters import Parameter
from ur5_ros.config.worlds import EMPTY_WORLD, World, parse_world, with_contact, with_tool
from ur5_ros.errors import InputError

#: Nodes that a bag can be of; ``robot`` is a robot's own log.
NODES = ('sim', 'control', 'robot')


class BagDescription(NamedTuple):
    """What a bag states about its node."""

    record: NodeRecord | None
    """None where the bag does not describe its node."""
    node: str
    """One of :data:`NODES`, or empty."""
    run: str


def describe_node(bag: Bag) -> BagDescription:
    """Return what a bag states about its node; InputError if it contradicts itself."""
    stated = bag.description
    node, run = stated.get('node', ''), stated.get('run', '')
    if node not in NODES:
        return BagDescription(None, '', run)
    given = json_field(bag, 'parameters', {})
    known = SIM_PARAMETERS if node == 'sim' else CONTROL_PARAMETERS
    if not isinstance(given, dict) or 'arm' not in stated:
        raise InputError(f'{bag.path}: its description has no arm or no parameters; it is damaged')
    try:
        parameters = complete(known, {name: value for name, value in given.items()
                                      if name != 'use_sim_time'})
    except InputError as refusal:
        raise InputError(f'{bag.path}: {refusal}') from None
    arm = parse_arm(stated['arm'], f'{bag.path}: arm')
    if node == 'robot':
        parameters['mode'] = 'unknown'
    record = NodeRecord(stated.get('arm_name', arm.name), arm, parameters,
                        json_field(bag, 'versions', {}), bag.notes.get('summary', {}),
                        json_field(bag, 'fingerprint', {}), _changes(bag, known),
                        _world(bag, parameters) if node == 'sim' else EMPTY_WORLD)
    return BagDescription(record, node, run)


def _world(bag: Bag, parameters: dict[str, Any]) -> World:
    """Return what a simulator's bag states that the arm could touch."""
    world = parse_world(bag.description.get('world', ''), f'{bag.path}: world')
    tool = tool_of(bag.description.get('arm', ''), f'{bag.path}: arm')
    return with_contact(with_tool(world, tool), parameters)


def json_field(bag: Bag, key: str, default: Any) -> Any:
    """Return the value of a JSON text in the description; InputError if it is not JSON."""
    text = bag.description.get(key)
    if text is None:
        return default
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f'{bag.path}: {key} in its description is not JSON; '
                         'the bag is damaged') from None


def _changes(bag: Bag, known: tuple[Parameter, ...]) -> tuple[ParameterChange, ...]:
    """Return the live changes of parameters that the node wrote down."""
    written = bag.notes.get('parameter_changes', {}).get('changes', [])
    found = []
    try:
        for each in written:
            values = {name: value for name, value in each.items() if name != 'stamp'}
            checked = complete(known, values)
            found.append(ParameterChange(int(each['stamp']),
                                         {name: checked[name] for name in values}))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f'{bag.path}: its note of parameters changed while it ran cannot be '
                         f'understood ({error}); the bag is damaged') from None
    return tuple(sorted(found, key=lambda change: change.stamp))


def messages_of(raw: RawColumns) -> Iterator[bytes]:
    """Yield the messages of a topic that is read as bytes."""
    for begin, end in zip(raw.offsets[:-1].tolist(), raw.offsets[1:].tolist(), strict=True):
        yield np.ascontiguousarray(raw.data[begin:end]).tobytes()


def events_in(raw: RawColumns, path: Any) -> Iterator[RecordedEvent]:
    """Yield the events of the simulator's topic; InputError if one is not understood."""
    for data in messages_of(raw):
        message = decode('diagnostic_msgs/msg/DiagnosticArray', data)
        stamp = message['header']['stamp']
        for status in message['status']:
            try:
                values = {pair['key']: json.loads(pair['value']) for pair in status['values']}
            except (ValueError, RecursionError):
                raise InputError(f'{path}: event {status["name"][:40]!r} has a value that is '
                                 'not JSON; the bag is damaged') from None
            yield RecordedEvent(stamp['sec'] * 1_000_000_000 + stamp['nanosec'], status['name'],
                                status['message'], values)
