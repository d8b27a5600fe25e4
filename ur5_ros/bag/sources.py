"""The files of a bag, their descriptions, and whether they agree with metadata.yaml."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ur5_ros.bag.mcap.reader import McapReader, MessageSource
from ur5_ros.bag.mcap.record_scan import opened
from ur5_ros.bag.mcap.records import CHECKSUM, MAGIC, checksum
from ur5_ros.bag.metadata import METADATA_FILE, Information, read_metadata
from ur5_ros.bag.rosbag2_folder import DESCRIPTION_RECORD, NOTE_RECORD
from ur5_ros.bag.sqlite3_reader import SQLITE3_MAGIC, ZSTANDARD_MAGIC, Sqlite3Reader
from ur5_ros.errors import BagError, InputError
from ur5_ros.wording import number_of

Report = Callable[[str], None]

#: How a bag of ROS 1 begins.
ROS1_MAGIC = b'#ROSBAG V'

#: How the name of a robot's log ends.
LOGS = ('.csv', '.csv.gz', '.txt', '.tsv')

#: How a compressed file begins -> what decompresses it.
COMPRESSED = {ZSTANDARD_MAGIC: 'zstd -d', b'\x1f\x8b': 'gunzip', b'BZh': 'bunzip2',
              b'\xfd7zXZ': 'unxz', b'PK\x03\x04': 'unzip', b'\x04"M\x18': 'lz4 -d'}


def open_sources(path: Path, report: Report) -> tuple[Information | None, Sequence[MessageSource]]:
    """
    Return the content of metadata.yaml (None without a sound one) and the files of a bag.

    ``path`` is the folder of a bag, or one storage file; ``report`` takes a sentence about each
    defect. BagError if nothing can be read, InputError if there is no such bag.

    """
    if path.is_file():
        return None, [_open_file(path, report)]
    if not path.is_dir():
        raise InputError(f'{path}: no such bag; give a folder with {METADATA_FILE}, or an .mcap '
                         'or .db3 file')
    present = sorted((*path.glob('[!.]*.mcap'), *path.glob('[!.]*.db3')), key=_natural)
    information = None
    if (path / METADATA_FILE).is_file():
        try:
            information = read_metadata(path)
        except BagError as problem:
            if not present:
                raise
            report(str(problem))
    compressed = sorted(path.glob('*.zstd'))
    if not present and compressed:
        name = compressed[0].name
        raise InputError(f'{path}: its files are compressed as a whole, which is not read; unpack '
                         f'each: unzstd {name} -o {name.removesuffix(".zstd")}')
    if information:
        _check_storage(path, information)
    if not present:
        raise BagError(f'{path}: no .mcap file in it, and no .db3 file; give the folder of a bag')
    if information:
        _compare_files(path, information, present, report)
    return information, _open_files(present, report)


def report_missing_metadata(
    path: Path, sources: Sequence[MessageSource], described: bool, report: Report,
) -> None:
    """Report a folder without metadata.yaml where its writer, this package's, did not end."""
    if path.is_dir() and not (path / METADATA_FILE).is_file() and (described or any(
            isinstance(source, McapReader) and source.summary is None for source in sources)):
        report(f'{path}: no file {METADATA_FILE}, the recording was ended before it was closed; '
               'repair it with: ur5 recover')


def _check_storage(path: Path, information: Information) -> None:
    """Refuse compressed messages, and storage that is neither MCAP nor sqlite3."""
    storage, mode = information.storage_identifier, information.compression_mode
    if mode.lower() not in ('', 'none', 'file') or storage not in ('', 'mcap', 'sqlite3'):
        compressed = f' compressed by {mode[:20]}' if mode else ''
        raise InputError(f'{path}: storage {storage[:20]!r}{compressed} is not read; convert '
                         'it to mcap with: ros2 bag convert')


def _open_file(path: Path, report: Report) -> MessageSource:
    """Open a storage file by its first bytes; what is neither kind is tried as MCAP."""
    start = b''
    if path.is_file():
        with opened(path) as file:
            start = file.read(len(SQLITE3_MAGIC))
    if start.startswith(ROS1_MAGIC):
        raise BagError(f'{path}: a bag of ROS 1, not an MCAP file; convert it with: '
                       'rosbags-convert')
    if path.name.lower().endswith(LOGS):
        raise BagError(f"{path}: not a bag; a robot's log becomes one by: ur5 import {path.name} "
                       '--out RUN --arm NAME')
    for magic, command in COMPRESSED.items():
        if start.startswith(magic):
            raise BagError(f'{path}: a compressed file; decompress it with: {command} {path.name}')
    if start == SQLITE3_MAGIC or path.suffix == '.db3' and not start.startswith(MAGIC):
        return Sqlite3Reader(path, report)
    return McapReader(path, report)


def _compare_files(path: Path, information: Information, present: Sequence[Path],
                   report: Report) -> None:
    listed = {Path(name).name.removesuffix('.zstd') for name in information.relative_file_paths}
    there = {file.name for file in present}
    for name in sorted(listed - there):
        report(f'{path / name}: is missing, though {METADATA_FILE} names it')
    for name in sorted(there - listed):
        report(f'{path / name}: is not named in {METADATA_FILE}; it was read all the same')


def _open_files(files: Sequence[Path], report: Report) -> list[MessageSource]:
    sources: list[MessageSource] = []
    problems: list[BagError] = []
    for file in files:
        try:
            sources.append(_open_file(file, report))
        except BagError as problem:
            problems.append(problem)
    if not sources:
        raise problems[0]
    for found in problems:
        report(str(found))
    return sources


def read_descriptions(
    path: Path, information: Information | None, sources: Sequence[MessageSource], report: Report,
) -> tuple[dict[str, str], dict[str, dict[str, Any]]]:
    """Return the description of a bag and its notes (name -> values), from sound records alone."""
    description: dict[str, str] = {}
    notes: dict[str, dict[str, Any]] = {}
    for source in sources:
        for name, values in source.metadata:
            if not (name == DESCRIPTION_RECORD or name.startswith(NOTE_RECORD)
                    or CHECKSUM in values):  # then it is ours and its name is damaged
                continue
            if values.get(CHECKSUM) != checksum(name, values):
                report(f'{source.path}: the metadata record {name[:80]!r} is damaged; it was '
                       'left out')
                continue
            values = {key: value for key, value in values.items() if key != CHECKSUM}
            if name != DESCRIPTION_RECORD:
                note = _note(values)
                if note is None:
                    report(f'{source.path}: the note {name[:80]!r} is damaged; it was left out')
                else:
                    notes[name.removeprefix(NOTE_RECORD)] = note
            elif description not in ({}, values):
                report(f'{source.path}: describes another run than the file before it')
            else:
                description = values
    custom = information.custom_data if information else None
    if custom and not description:
        description = dict(custom)
    elif custom is not None and description and custom != description:
        report(f'{path / METADATA_FILE}: its custom_data differ from the description in the files')
    return description, notes


def _note(values: dict[str, str]) -> dict[str, Any] | None:
    try:
        return {key: json.loads(value) for key, value in values.items()}
    except (ValueError, RecursionError):
        return None


def compare_counts(path: Path, information: Information | None, sources: Sequence[MessageSource],
                   report: Report) -> None:
    """Report where metadata.yaml states other numbers of messages than were read."""
    if information is None:
        return
    counted: dict[str, int] = {}
    types: dict[str, str] = {}
    for source in sources:
        for channel, info in source.topics.items():
            counted[info.name] = counted.get(info.name, 0) + source.counts.get(channel, 0)
            types[info.name] = info.type
    stated: dict[str, int] = {}
    for entry in information.topics_with_message_count:
        topic = entry.topic_metadata
        stated[topic.name] = stated.get(topic.name, 0) + entry.message_count
        if types.get(topic.name, topic.type) != topic.type:
            report(f'{path / METADATA_FILE}: says that {topic.name} is of another type')
    total = sum(counted.values())
    if information.message_count != total:
        report(f'{path / METADATA_FILE}: says '
               f'{number_of(information.message_count, "message")}; counted: {total}')
    for name in sorted(stated.keys() | counted.keys()):
        if stated.get(name, 0) != counted.get(name, 0):
            report(f'{path / METADATA_FILE}: says {number_of(stated.get(name, 0), "message")} on '
                   f'{name}; counted: {counted.get(name, 0)}')


def _natural(path: Path) -> tuple[str, int, str]:
    """Sort ``bag_10`` behind ``bag_9``."""
    stem, _, number = path.stem.rpartition('_')
    if number.isdecimal() and len(number) < 10:
        return stem, int(number), path.name
    return path.stem, -1, path.name
