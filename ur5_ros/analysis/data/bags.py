"""The bags of a run, opened: which topic plays which part, and what each says about its node."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import NodeRecord, ParameterChange, RecordedEvent
from ur5_ros.bag.arrays.columns import Columns, RawColumns
from ur5_ros.bag.reader import Bag, open_bag
from ur5_ros.bag.run_folders import bags_of_run, is_bag
from ur5_ros.cdr.codec import decode
from ur5_ros.config import CONTROL_PARAMETERS, SIM_PARAMETERS, complete, parse_arm
from ur5_ros.config.parameters import Parameter
from ur5_ros.config.topics import (
    CONTROL_TOPICS,
    ROBOT_TOPICS,
    SIM_TOPICS,
    WORLD_TOPICS,
    by_role,
)
from ur5_ros.config.worlds import NOTHING, World, parse_world, with_contact
from ur5_ros.errors import BagError, InputError
from ur5_ros.signals import JOINT_NAMES

#: The topics that are read, by role.
_READ = by_role(topic for topic in (
    *SIM_TOPICS, *WORLD_TOPICS, *CONTROL_TOPICS, *ROBOT_TOPICS) if topic.role in (
    'joint_states', 'joint_command', 'ground_truth', 'torque_parts', 'reference', 'events',
    'contact_effort', 'contacts', 'objects', 'motor_current'))
#: Those of them that are not numbers by joint.
_RAW = ('events', 'contacts', 'objects')


@dataclass(frozen=True, eq=False)
class BagData:
    """One bag, its hot topics read."""

    path: Path
    node: str
    """``sim``, ``control``, ``robot`` or empty where the bag does not say."""
    run: str
    side: NodeRecord | None
    effort: str
    """What the effort is, where it is not the torque that acted."""
    data: dict[str, Any]
    """By role; joint columns are in the order of JOINT_NAMES."""
    problems: tuple[str, ...]

    def has(self, role: str) -> bool:
        """Tell whether messages of this part were read."""
        return role in self.data and len(self.data[role].log_time) > 0


def open_bags(folder: Path) -> tuple[list[BagData], list[str]]:
    """
    Return the bags of a run, read, and what is wrong with the run as a whole.

    Parameters
    ----------
    folder : pathlib.Path
        Run folder with ``sim`` and ``control``, one bag folder, or one MCAP file.

    Raises
    ------
    InputError
        If nothing can be read, the bags belong to different runs, or one contradicts itself.

    """
    found, problems = [], []
    paths = bags_of_run(folder)
    for path in paths:
        try:
            found.append(_read(open_bag(path)))
        except BagError as problem:
            if len(paths) == 1:
                raise
            problems.append(str(problem))
    if not found:
        raise InputError('; '.join(problems))
    _check_same_run(found)
    nodes = {source.node for source in found}
    if paths != [folder] and not is_bag(folder):
        for node, other in (('sim', 'control'), ('control', 'sim')):
            if node in nodes and other not in nodes and not problems:
                problems.append(f'{folder}: the bag of the {other} node is missing')
    return found, problems


def _check_same_run(found: list[BagData]) -> None:
    named = [source for source in found if source.run]
    for source in named[1:]:
        if source.run != named[0].run:
            raise InputError(f'{named[0].path} is of run {named[0].run}, {source.path} of run '
                             f'{source.run}; put the bags of one run together')
    for node in ('sim', 'control'):
        twice = [str(source.path) for source in found if source.node == node]
        if len(twice) > 1:
            raise InputError(f'{" and ".join(twice)} are both of the {node} node; '
                             'give the bags of one run')


def _read(bag: Bag) -> BagData:
    side, node, run = _side(bag)
    prefix = str(side.parameters.get('tf_prefix', '')) if side else None
    topics = _topics(bag)
    names = {topic: _names(bag, role, topic, prefix) for role, topic in topics.items()}
    loaded = bag.load({topic: names[topic] for topic in topics.values()})
    data = {}
    for role, topic in topics.items():
        columns = loaded[topic]
        if isinstance(columns, Columns):
            if columns.skipped:
                bag.report(f'{bag.path}: {columns.skipped} messages of {topic} could not be '
                            'used: joint names missing, or lengths that contradict each other')
            if not len(columns.stamp):
                continue
        data[role] = columns
    problems = list(bag.problems)
    if side is not None and not side.summary:
        problems.append(f'{bag.path}: the recording was not closed: the node was killed, or '
                        'still runs')
    return BagData(bag.path, node, run, side, bag.description.get('effort', ''), data,
                  tuple(problems))


def _topics(bag: Bag) -> dict[str, str]:
    """Return part -> topic name, of those that the bag has with the right type."""
    said = _json(bag, 'topics', {})
    if not isinstance(said, dict):
        raise InputError(f'{bag.path}: its description names no topics; it is damaged')
    found = {}
    for role, topic in _READ.items():
        kind, ending = topic.type, topic.name.removeprefix('~')  # where a bag names no roles
        name = said.get(role)
        if name is None and not bag.description.get('node'):
            endings = [each for each in sorted(bag.topics, key=len) if each.endswith(ending)]
            name = endings[0] if endings else None
        if not isinstance(name, str) or name not in bag.topics:
            continue
        if bag.topics[name] != kind:
            raise InputError(f'{bag.path}: topic {name} is {bag.topics[name]}, not {kind}')
        found[role] = name
    return found


def _names(bag: Bag, role: str, topic: str, prefix: str | None) -> list[str] | None:
    """Return the columns wanted of a topic: the six joints, or the parts of their torque."""
    if role in _RAW:
        return None
    if prefix is None:
        prefix = _prefix(bag, topic)
    joints = [prefix + name for name in JOINT_NAMES]
    if role != 'torque_parts':
        return joints
    return [f'{part}/{joint}' for part in PART_NAMES for joint in joints]


#: Parts of a recorded torque, in the order of its columns.
PART_NAMES = ('total', 'inertial', 'feedback', 'coriolis', 'gravity')


def _prefix(bag: Bag, topic: str) -> str:
    """Return what stands before the joint names in a bag that does not say."""
    for _, message in bag.messages(topic):
        names = message.get('name') or message.get('joint_names') or []
        first = [name for name in names if name.endswith(JOINT_NAMES[0])]
        if not first:
            raise InputError(f'{bag.path}: {topic} names the joints '
                             f'{", ".join(names[:6]) or "-"}; '
                             f'wanted are {", ".join(JOINT_NAMES)}, with a common prefix or none')
        return first[0].removesuffix(JOINT_NAMES[0]).rpartition('/')[2]
    return ''


def _json(bag: Bag, key: str, default: Any) -> Any:
    text = bag.description.get(key)
    if text is None:
        return default
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f'{bag.path}: {key} in its description is not JSON; '
                         'the bag is damaged') from None


def _side(bag: Bag) -> tuple[NodeRecord | None, str, str]:
    """Return what a bag says about its node, which node and which run it is."""
    said = bag.description
    node = said.get('node', '')
    if node not in ('sim', 'control', 'robot'):
        return None, '', said.get('run', '')
    given = _json(bag, 'parameters', {})
    known = SIM_PARAMETERS if node == 'sim' else CONTROL_PARAMETERS
    if not isinstance(given, dict) or 'arm' not in said:
        raise InputError(f'{bag.path}: its description has no arm or no parameters; it is damaged')
    try:
        parameters = complete(known, {name: value for name, value in given.items()
                                      if name != 'use_sim_time'})
    except InputError as refusal:
        raise InputError(f'{bag.path}: {refusal}') from None
    arm = parse_arm(said['arm'], f'{bag.path}: arm')
    if node == 'robot':
        parameters['mode'] = 'unknown'
    side = NodeRecord(said.get('arm_name', arm.name), arm, parameters, _json(bag, 'versions', {}),
                bag.notes.get('summary', {}), _json(bag, 'fingerprint', {}),
                _changes(bag, known),
                _world(bag, parameters) if node == 'sim' else NOTHING)
    return side, node, said.get('run', '')


def _world(bag: Bag, parameters: dict[str, Any]) -> World:
    """Return what a simulator's bag says that the arm could touch."""
    world = parse_world(bag.description.get('world', ''), f'{bag.path}: world')
    return with_contact(world, parameters)


def _changes(bag: Bag, known: tuple[Parameter, ...]) -> tuple[ParameterChange, ...]:
    """Return the live changes of parameters that the node noted."""
    noted = bag.notes.get('parameter_changes', {}).get('changes', [])
    found = []
    try:
        for each in noted:
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


def events_of(source: BagData) -> Iterator[RecordedEvent]:
    """
    Yield the events that a simulator's bag holds.

    Raises
    ------
    InputError
        If one cannot be understood.

    """
    if not source.has('events'):
        return
    raw = source.data['events']
    for data in messages_of(raw):
        message = decode('diagnostic_msgs/msg/DiagnosticArray', data)
        stamp = message['header']['stamp']
        for status in message['status']:
            try:
                values = {pair['key']: json.loads(pair['value']) for pair in status['values']}
            except (ValueError, RecursionError):
                raise InputError(f'{source.path}: event {status["name"][:40]!r} has a value '
                                 'that is '
                                 'not JSON; the bag is damaged') from None
            yield RecordedEvent(stamp['sec'] * 1_000_000_000 + stamp['nanosec'], status['name'],
                        status['message'], values)
