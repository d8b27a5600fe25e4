"""The bags of a run, opened and read: the messages of each role as arrays."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ur5_ros.analysis.data.node_records import describe_node, events_in
from ur5_ros.analysis.data.options import ReadingOptions
from ur5_ros.analysis.data.run import NodeRecord, RecordedEvent
from ur5_ros.analysis.data.topics import FoundTopic, find_topics
from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.bag.metadata import METADATA_FILE
from ur5_ros.bag.reader import Bag, open_bag
from ur5_ros.bag.run_folders import bags_of_run, is_bag
from ur5_ros.errors import BagError, InputError
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import agree, number_of

#: How the reader says that metadata.yaml counts other messages than there are.
COUNTS = re.compile(r': says (\d+) messages?.*; counted: (\d+)$')


@dataclass(frozen=True, eq=False)
class BagData:
    """One bag, the topics of its roles read."""

    path: Path
    node: str
    """``sim``, ``control``, ``robot`` or empty where the bag does not state it."""
    run: str
    record: NodeRecord | None
    effort: str
    """What the effort is, where it is not the torque that acted."""
    data: Mapping[str, Any]
    """By role; joint columns are in the order of JOINT_NAMES."""
    events: tuple[RecordedEvent, ...] = ()
    problems: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    """What was chosen, passed over or assumed."""
    topics: Mapping[str, str] = field(default_factory=dict)
    """Role -> topic."""
    prefix: str = ''
    """Text before the joint names."""
    dropped: tuple[int, ...] = ()
    """Stamps of rows of a robot's log that were dropped when it was imported [ns]."""

    def has(self, role: str) -> bool:
        """Whether messages of this role were read."""
        return role in self.data and len(self.data[role].log_time) > 0


def open_bags(
    folder: Path, options: ReadingOptions | None = None,
) -> tuple[list[BagData], list[str]]:
    """
    Return the bags of a run, read, and what is wrong with the run as a whole.

    Parameters
    ----------
    folder : pathlib.Path
        Run folder with ``sim`` and ``control``, one bag folder, or one storage file.
    options : ReadingOptions, optional
        Statements of the user about topics and joints.

    Raises
    ------
    InputError
        If nothing can be read, the bags belong to different runs, or one contradicts itself.

    """
    found, problems = [], []
    paths = bags_of_run(folder)
    for path in paths:
        try:
            found.append(_read(open_bag(path), options or ReadingOptions()))
        except BagError as problem:
            if len(paths) == 1:
                raise
            problems.append(str(problem))
    if not found:
        raise InputError('; '.join(problems))
    _check_same_run(found)
    nodes = {data.node for data in found}
    if paths != [folder] and not is_bag(folder):
        for node, other in (('sim', 'control'), ('control', 'sim')):
            if node in nodes and other not in nodes and not problems:
                problems.append(f'{folder}: the bag of the {other} node is missing')
    return found, problems


def _check_same_run(found: list[BagData]) -> None:
    named = [data for data in found if data.run]
    for data in named[1:]:
        if data.run != named[0].run:
            raise InputError(f'{named[0].path} is of run {named[0].run}, {data.path} of run '
                             f'{data.run}; put the bags of one run together')
    for node in ('sim', 'control'):
        twice = [str(data.path) for data in found if data.node == node]
        if len(twice) > 1:
            raise InputError(f'{" and ".join(twice)} are both of the {node} node; '
                             'give the bags of one run')


def _read(bag: Bag, options: ReadingOptions) -> BagData:
    record, node, run = describe_node(bag)
    prefix = str(record.parameters.get('tf_prefix', '')) if record else None
    remarks: list[str] = []
    topics = find_topics(bag, prefix, options, remarks)
    loaded = bag.load({topic.name: topic.columns for topic in topics.values()})
    data = {}
    for role, topic in topics.items():
        columns = loaded[topic.name]
        if isinstance(columns, Columns):
            for sentence in _left_out(columns, topic):
                if node in ('sim', 'control'):
                    bag.report(f'{bag.path}: {sentence}')
                else:
                    remarks.append(sentence)
            if not len(columns.stamp):
                continue
        data[role] = columns
    events: tuple[RecordedEvent, ...] = ()
    if 'events' in data:
        try:
            events = tuple(events_in(data['events'], bag.path))
        except InputError:
            if node:
                raise
            remarks.append(f"{topics['events'].name} holds no events of this package's simulator")
    note = bag.notes.get('dropped', {})
    remarks += [str(remark) for remark in note.get('remarks', ())]
    problems = list(bag.problems)
    if not node:
        problems, harmless = _of_the_contents(problems, bag.path)
        remarks += harmless
    if record is not None and not record.summary:
        problems.append(f'{bag.path}: the recording was not closed: the node was killed, or '
                        'still runs')
    return BagData(bag.path, node, run, record, bag.description.get('effort', ''), data, events,
                   tuple(problems), tuple(remarks),
                   {role: topic.name for role, topic in topics.items()}, _prefix(topics),
                   tuple(int(stamp) for stamp in note.get('stamps', ())))


def _prefix(topics: Mapping[str, FoundTopic]) -> str:
    """Return the text before the names of the joint states."""
    columns = topics['joint_states'].columns if 'joint_states' in topics else None
    return columns[0].removesuffix(JOINT_NAMES[0]) if columns else ''


def _of_the_contents(problems: list[str], path: Path) -> tuple[list[str], list[str]]:
    """
    Return what is wrong with the messages of a bag, and with its table of contents alone.

    A metadata.yaml that is missing, damaged or of a newer version takes nothing from a file that
    was closed; nor does a file of another name, where the messages are as many as were written, or
    one that was written before more messages were.

    """
    table = str(path / METADATA_FILE)
    others = [each for each in problems if METADATA_FILE not in each]
    counts = [COUNTS.search(each) for each in problems if each.startswith(table)]
    if others or any(each and int(each[1]) > int(each[2]) for each in counts):
        return problems, []
    return [], problems


def _left_out(columns: Columns, topic: FoundTopic) -> list[str]:
    """Return what of the messages of a topic was left out, in sentences."""
    total = columns.skipped + len(columns.stamp)
    skipped = [f'{number_of(columns.skipped, "message")} of {topic.name}, of {total}, could not '
               'be used: joint names missing or twice, or lengths that contradict each other'
               ] if columns.skipped else []
    return skipped + [f'{number_of(count, "message")} of {topic.name}, of {total}, '
                      f'{agree(count, "have")} fewer values of {field} than names: that field '
                      'was left out'
                      for field, count in columns.short.items()]
