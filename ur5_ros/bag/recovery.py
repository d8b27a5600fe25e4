"""Recovery after a crash: a new bag of all whole records; the old one is only read."""

import filecmp
import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import yaml

from ur5_ros.bag.mcap.channels import TopicInfo
from ur5_ros.bag.mcap.chunk import Message
from ur5_ros.bag.mcap.reader import MessageSource
from ur5_ros.bag.metadata import qos_profile
from ur5_ros.bag.reader import Bag, open_bag
from ur5_ros.bag.rosbag2_folder import BagFolder, TopicRecords, make_topic
from ur5_ros.bag.run_folders import RECOVERED_SUFFIX, UNFINISHED, bags_of_run
from ur5_ros.config.strict_yaml import parse_yaml
from ur5_ros.errors import BagError, InputError
from ur5_ros.wording import number_of


class RecoveredBag(NamedTuple):
    """The recovery of one bag."""

    name: str
    """``sim`` or ``control``, or the name of the bag."""
    kept: dict[str, int]
    """Topic -> messages that were readable."""
    problems: list[str]
    """What was wrong with it, one sentence each; empty for a sound bag."""


class Recovery(NamedTuple):
    """The recovery of a run or bag."""

    source: Path
    out: Path | None
    """The repaired run or bag; None where nothing was wrong."""
    bags: list[RecoveredBag]

    @property
    def intact(self) -> bool:
        """Whether there was nothing to repair."""
        return not any(bag.problems for bag in self.bags)

    def sentences(self) -> list[str]:
        """Return the report: what was wrong, what was kept, where it is."""
        lines = []
        for bag in self.bags:
            lines += bag.problems
            total = sum(bag.kept.values())
            lines.append(f'{bag.name}: {number_of(total, "message")} on '
                         f'{number_of(len(bag.kept), "topic")} kept')
        lines.append(f'{self.source}: nothing to repair' if self.out is None
                     else f'repaired: {self.out}')
        return lines

    def to_plain(self) -> dict[str, object]:
        """Return the report for JSON: ``bags`` by name, with problems and messages kept."""
        return {
            'format': 'ur5_ros recovery', 'version': 1, 'source': str(self.source),
            'out': None if self.out is None else str(self.out),
            'intact': self.intact,
            'bags': {bag.name: {'problems': list(bag.problems), 'kept': dict(bag.kept)}
                     for bag in self.bags}}


def recover(path: Path | str, out: Path | str | None = None) -> Recovery:
    """
    Write a sound copy of a run or a bag beside it; the original is only read.

    Doing it again gives the same files. The copy appears under its name when it is whole.

    ``path``: A run (``sim/`` and ``control/`` in it), a bag folder or an MCAP file; ``out``: where
    to; default: ``<name>.recovered`` beside it.  Returned: ``out`` is None where nothing was
    wrong; then nothing has been written.
    """
    path = Path(os.path.abspath(path))
    bags, unreadable = [], []
    for folder in bags_of_run(path):
        try:
            bag = open_bag(folder)
            bag.check()
            bags.append(bag)
        except BagError as problem:
            unreadable.append(RecoveredBag(_name(folder), {}, [str(problem)]))
    if not bags:
        raise BagError(unreadable[0].problems[0])
    found = [RecoveredBag(_name(bag.path), bag.counts(), bag.problems)
             for bag in bags] + unreadable
    if all(not each.problems for each in found):
        return Recovery(path, None, found)

    out = Path(out) if out is not None else path.with_name(_name(path) + RECOVERED_SUFFIX)
    out = Path(os.path.abspath(out))
    unfinished = out.with_name(f'{out.name}.{os.getpid()}{UNFINISHED}')
    try:
        _clear_left_over(out)
        for bag in bags:
            target = unfinished if bag.path == path else unfinished / _name(bag.path)
            if bag.problems:
                _rewrite(bag, target)
            else:
                shutil.copytree(bag.path, target)
        _publish(unfinished, out)
    except OSError as error:
        raise InputError(f'{out}: cannot be written: {error.strerror}; '
                         'give another place with --out') from None
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    return Recovery(path, out, found)


def _name(path: Path) -> str:
    """Return the name of a bag: a file without its suffix, a folder as it is."""
    return path.stem if path.suffix == '.mcap' else path.name


def _rewrite(bag: Bag, folder: Path) -> None:
    """Write all that can be read of a bag, file by file, and bring it onto the disk."""
    copy = BagFolder(folder, _name(bag.path), bag.description)
    numbers: dict[tuple[str, str], int] = {}
    for position, source in enumerate(bag.sources):
        if position:
            copy.next_file()
        for messages in _messages(source, copy, numbers):
            copy.write(messages)
    for name, values in bag.notes.items():
        copy.note(name, {key: json.dumps(value) for key, value in values.items()})
    copy.note('recovery', {'from': json.dumps(bag.path.name),
                           'problems': json.dumps([problem.replace(str(bag.path.parent), '...')
                                                   for problem in bag.problems])})
    copy.finish()
    for written in (*folder.iterdir(), folder):
        _sync(written)


def _messages(source: MessageSource, copy: BagFolder,
              numbers: dict[tuple[str, str], int]) -> Iterator[list[Message]]:
    """Yield the messages of a file, their topics announced under the numbers of the copy."""
    for batch in source.batches():
        found = batch.messages
        of_channel = {}
        for channel, info in source.topics.items():
            key = (info.name, info.type)
            if key not in numbers:
                numbers[key] = len(numbers) + 1
                copy.topics.append(_topic(numbers, key, info))
            of_channel[channel] = numbers[key]
        yield [(of_channel[channel], log_time, publish_time, bytes(batch.buffer[at:at + length]))
               for channel, at, length, log_time, publish_time
               in zip(found.channels.tolist(), found.offsets.tolist(), found.lengths.tolist(),
                      found.log_times.astype('u8').tolist(),
                      found.publish_times.astype('u8').tolist(), strict=True)
               if channel in of_channel]


def _topic(numbers: dict[tuple[str, str], int], key: tuple[str, str], info: TopicInfo,
           ) -> TopicRecords:
    """Return a topic as another file announced it."""
    types = list(dict.fromkeys(type_name for _, type_name in numbers))
    try:
        qos = parse_yaml(info.qos, 'offered QoS profiles')
    except (InputError, yaml.YAMLError):
        qos = None
    if not isinstance(qos, list) or not all(isinstance(profile, dict) for profile in qos):
        qos = [qos_profile()]
    return make_topic(numbers[key], types.index(info.type) + 1, info.name,
                      (info.type, info.schema), qos, info.type_hash,
                      info.schema_encoding, info.encoding)


def _publish(unfinished: Path, out: Path) -> None:
    """Give the finished copy its name; an equal one that is there already stays."""
    for folder in unfinished.iterdir():
        if folder.is_dir():
            _sync(folder)
    _sync(unfinished)
    try:
        unfinished.rename(out)
    except OSError:
        if not out.exists():
            raise
        if not _same(unfinished, out):
            raise InputError(f'{out} exists and holds something else; move it away, or give '
                             'another place with --out') from None
    _sync(out.parent)


def _same(one: Path, other: Path) -> bool:
    """Return whether two folders hold the same files with the same bytes."""
    files = sorted(each.relative_to(one) for each in one.rglob('*') if each.is_file())
    if not other.is_dir() or files != sorted(
            each.relative_to(other) for each in other.rglob('*') if each.is_file()):
        return False
    return all(filecmp.cmp(one / file, other / file, shallow=False) for file in files)


def _clear_left_over(out: Path) -> None:
    """Remove the unfinished folders of recoveries of the same bag whose process has ended."""
    for folder in out.parent.glob(f'{out.name}.*{UNFINISHED}'):
        number = folder.name.removeprefix(out.name + '.').removesuffix(UNFINISHED)
        if number.isdecimal() and not Path(f'/proc/{number}').exists():
            shutil.rmtree(folder, ignore_errors=True)


def _sync(path: Path) -> None:
    """Bring a file or the entries of a folder onto the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
