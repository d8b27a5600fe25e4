"""The topic of each role: stated by the bag or the user, or found by type and content."""

from collections import Counter
from collections.abc import Mapping
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.joint_names import prefixes_of, quoted
from ur5_ros.analysis.data.node_records import json_field
from ur5_ros.analysis.data.options import ReadingOptions
from ur5_ros.analysis.data.topic_roles import (
    RAW_ROLES,
    ROLE_ENDINGS,
    ROLE_FIELDS,
    ROLE_TYPES,
    role_columns,
)
from ur5_ros.bag.arrays.columns import COLUMN_TYPES
from ur5_ros.bag.reader import Bag
from ur5_ros.bag.untyped import declare_by_content
from ur5_ros.cdr.codec import decode
from ur5_ros.errors import BagError, InputError
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import number_of

_JOINT_STATE = 'sensor_msgs/msg/JointState'


#: Messages that are decoded to learn what a topic holds.
SAMPLE = 400


class FoundTopic(NamedTuple):
    """The topic of a role and the columns to read of it."""

    name: str
    columns: list[str] | None


class _Form(NamedTuple):
    """The form of a message: its names and the fields that are filled."""

    names: tuple[str, ...]
    fields: frozenset[str]


def find_topics(
    bag: Bag, prefix: str | None, options: ReadingOptions, remarks: list[str],
) -> dict[str, FoundTopic]:
    """
    Return role -> topic; ``remarks`` receives a sentence about each choice and each omission.

    Parameters
    ----------
    bag : Bag
        The bag.
    prefix : str or None
        Prefix of the joint names that the bag states.
    options : ReadingOptions
        Statements of the user; these come first.
    remarks : list of str
        Grows.

    Raises
    ------
    InputError
        If a stated topic is of another type or does not exist, or no topic holds the joints.

    """
    stated = json_field(bag, 'topics', {})
    if not isinstance(stated, dict):
        raise InputError(f'{bag.path}: its description names no topics; it is damaged')
    found: dict[str, FoundTopic] = {}
    if bag.description.get('node') and not options.topics and options.joint_prefix is None:
        for role, expected in ROLE_TYPES.items():
            name = stated.get(role)
            if isinstance(name, str) and name in bag.topics:
                if bag.topics[name] != expected:
                    raise InputError(f'{bag.path}: topic {name} is {bag.topics[name]}, not '
                                     f'{expected}')
                found[role] = FoundTopic(name, role_columns(role, prefix or ''))
        return found
    return _Search(bag, stated, options, remarks).all_roles()


class _Search:
    """The topics of one bag that does not state their roles, or whose user states others."""

    def __init__(self, bag: Bag, stated: Mapping[str, object], options: ReadingOptions,
                 remarks: list[str]) -> None:
        self._bag, self._options, self._remarks = bag, options, remarks
        self._chosen = {role: str(name) for role, name in stated.items()
                        if role in ROLE_FIELDS and name in bag.topics} | dict(options.topics)
        self._forms: dict[str, Counter[_Form]] = {}
        self._unread: dict[str, str] = {}  # topic -> why its first broken message cannot be read

    def all_roles(self) -> dict[str, FoundTopic]:
        """Return role -> topic."""
        states = self._states_topic()
        prefix = self._prefix(states)
        found = {'joint_states': FoundTopic(states, role_columns('joint_states', prefix))}
        for role in ROLE_FIELDS:
            topic = None if role == 'joint_states' else self._other(role, prefix, states)
            if topic is not None:
                found[role] = FoundTopic(topic, role_columns(role, prefix))
        return found

    def forms(self, topic: str, type_name: str) -> Counter[_Form]:
        """Return the forms of a sample of the messages of a topic, with their counts."""
        if topic not in self._forms:
            self._forms[topic] = Counter(self._sample(topic, type_name))
        return self._forms[topic]

    def _sample(self, topic: str, type_name: str) -> list[_Form]:
        kind, definitions = COLUMN_TYPES[type_name], self._bag.definitions(topic)
        raw = self._bag.columns(topic)
        count = len(raw.log_time)
        lengths, first = np.unique(np.diff(raw.offsets), return_index=True)
        rows = np.unique(np.concatenate([first, np.linspace(0, count - 1, min(count, SAMPLE))
                                         .astype(int)])) if count else first
        found = []
        for row in rows.tolist():
            data = raw.data[raw.offsets[row]:raw.offsets[row + 1]].tobytes()
            try:
                message = decode(type_name, data, definitions)
            except BagError as problem:
                self._unread.setdefault(topic, str(problem))
                continue
            values = kind.values(message)
            filled = {field for field in kind.fields
                      if len(values.get(field, ())) and np.isfinite(values[field]).any()
                      and (field != 'effort' or np.any(values[field]))}
            found.append(_Form(tuple(kind.names(message)), frozenset(filled)))
        return found

    def _of_type(self, role: str) -> list[str]:
        """Return the topics of the role's type; one without a type by its name and content."""
        expected = ROLE_TYPES[role]
        found = []
        for topic, type_name in list(self._bag.topics.items()):
            if type_name == expected:
                found.append(topic)
            elif not type_name and expected in COLUMN_TYPES and (
                    topic.endswith(ROLE_ENDINGS[role]) or topic in self._chosen.values()
                    or expected == _JOINT_STATE and role == 'joint_states') and (
                    declare_by_content(self._bag, topic, expected)):
                self._remarks.append(f'{topic}: the file does not state its type; its messages '
                                     f'are read as {expected}')
                found.append(topic)
        return found

    def _stated_topic(self, role: str) -> str | None:
        """Return the topic that the bag or the user states for a role, checked."""
        topic, bag = self._chosen.get(role), self._bag
        if topic is None:
            return None
        if topic not in bag.topics:
            raise InputError(f'{bag.path}: no topic {topic} for {role}; there are: '
                             f'{", ".join(sorted(bag.topics)) or "none"}')
        if topic not in self._of_type(role):
            raise InputError(f'{bag.path}: topic {topic} is {bag.topics[topic] or "of no type"}, '
                             f'not {ROLE_TYPES[role]}; give another one: --topic {role}=NAME')
        return topic

    def _states_topic(self) -> str:
        """Return the topic whose messages hold the six joints."""
        topic = self._stated_topic('joint_states')
        if topic is not None:
            return topic
        candidates, prefixes = {}, dict[str, None]()
        given = self._options.joint_prefix
        for topic in self._of_type('joint_states'):
            holding = [(form, count) for form, count in self.forms(topic, _JOINT_STATE).items()
                       if 'position' in form.fields and prefixes_of(form.names)]
            there = dict.fromkeys(each for form, _ in holding for each in prefixes_of(form.names))
            prefixes |= there
            if holding and (given is None or given in there):
                filled = frozenset().union(*(form.fields for form, _ in holding))
                ending = topic.endswith(ROLE_ENDINGS['joint_states'])
                candidates[topic] = (ending, len(filled), sum(count for _, count in holding))
        if prefixes and not candidates:
            raise InputError(f'{self._bag.path}: no joints with the prefix {given!r}; the '
                             f'prefixes there are: {quoted(prefixes)}')
        if not candidates:
            raise InputError(self._no_joints())
        best = max(candidates, key=lambda topic: candidates[topic])
        if len(candidates) > 1:
            others = ', '.join(sorted(set(candidates) - {best}))
            self._remarks.append(f'the joint states are those of {best}; the six joints are also '
                                 f'on {others}: choose with --topic joint_states=NAME')
        return best

    def _no_joints(self) -> str:
        """Return why there are no joint states, with what there is instead."""
        bag = self._bag
        topics = self._of_type('joint_states')
        if not topics:
            unread = [problem for topic, type_name in bag.topics.items()
                      if topic.endswith(ROLE_ENDINGS['joint_states'])
                      for problem in _unreadable(bag, topic)]
            if unread:
                return unread[0]
            listed = ', '.join(f'{topic} ({type_name or "no type"})'
                               for topic, type_name in sorted(bag.topics.items())[:8])
            return (f'{bag.path}: no joint states in it: no topic is {_JOINT_STATE}; there are: '
                    f'{listed or "no topics"}{self._damage()}')
        for topic in topics:
            if any(prefixes_of(form.names) for form in self.forms(topic, _JOINT_STATE)):
                return f'{bag.path}: the joint states on {topic} have no position; it is needed'
        topic = topics[0]
        names = [form.names for form in self.forms(topic, _JOINT_STATE) if form.names]
        if not names:
            count = len(bag.columns(topic).log_time)
            why = f': {self._unread[topic]}' if topic in self._unread else ''
            what = (f'none of {number_of(count, "message")} on {topic} is a {_JOINT_STATE} '
                    f'with names{why}'
                    if count else f'no message on {topic}')
            return f'{bag.path}: {what}{self._damage()}'
        shown = ', '.join(names[0][:7])
        return (f'{bag.path}: {topic} names the joints {shown}; '
                f'needed are {", ".join(JOINT_NAMES)}, with a common prefix or none')

    def _damage(self) -> str:
        """Return in brackets what is wrong with the bag, empty where nothing is."""
        problems = self._bag.problems
        return f' ({problems[0]})' if problems else ''

    def _prefix(self, topic: str) -> str:
        """Return the prefix of the joint names on a topic."""
        counts: Counter[str] = Counter()
        for form, count in self.forms(topic, _JOINT_STATE).items():
            for prefix in prefixes_of(form.names):
                counts[prefix] += count
        given = self._options.joint_prefix
        if given is not None:
            if given not in counts:
                raise InputError(f'{self._bag.path}: no joints with the prefix {given!r} on '
                                 f'{topic}; the prefixes there are: {quoted(counts) or "none"}')
            return given
        if not counts:
            raise InputError(self._no_joints())
        if len(counts) > 1:
            best = next(iter(counts))
            self._remarks.append(
                f'{topic} holds {len(counts)} arms, with the prefixes {quoted(counts)}; the one '
                f'with {best!r} was taken: choose with --joint-prefix')
            return best
        return next(iter(counts))

    def _other(self, role: str, prefix: str, states: str) -> str | None:
        """Return the topic of a role beside the joint states, None where there is none."""
        topic = self._stated_topic(role)
        if topic is not None and role in self._options.topics:
            if role not in RAW_ROLES and not self._holds(topic, role, prefix):
                raise InputError(f'{self._bag.path}: no message on {topic} has '
                                 f'{" and ".join(ROLE_FIELDS[role])} of the six joints; give '
                                 f'another one: --topic {role}=NAME')
            return topic
        ending = ROLE_ENDINGS[role]
        named = [each for each in sorted(self._bag.topics, key=lambda each: (
            -_shared_names(each, states), len(each))) if each.endswith(ending) and each != states]
        typed = self._of_type(role)
        for topic in named:
            if topic not in typed:
                kind = self._bag.topics[topic] or 'of no type'
                self._remarks.append(f'{topic} is {kind}, so it is not {role}')
            elif role in RAW_ROLES or self._holds(topic, role, prefix):
                return topic
            else:
                self._remarks.append(f'{topic} holds no {" and ".join(ROLE_FIELDS[role])} of the '
                                     f'six joints, so it is not {role}')
        return None

    def _holds(self, topic: str, role: str, prefix: str) -> bool:
        """Return whether messages of a topic hold the columns of a role, filled."""
        columns, fields = set(role_columns(role, prefix) or ()), set(ROLE_FIELDS[role])
        return any(columns <= set(form.names) and fields <= form.fields
                   for form in self.forms(topic, ROLE_TYPES[role]))


def _shared_names(topic: str, other: str) -> int:
    """Return how many names of their namespaces two topics have in common."""
    pairs = zip(topic.split('/')[:-1], other.split('/')[:-1], strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))


def _unreadable(bag: Bag, topic: str) -> list[str]:
    """Return why messages of a topic cannot be read, if that is so."""
    try:
        bag.definitions(topic)
    except BagError as problem:
        return [str(problem)]
    return []
