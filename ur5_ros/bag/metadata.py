"""metadata.yaml, the table of contents of a rosbag2 folder (version 9, ROS 2 Jazzy)."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePath
from typing import Annotated, Any, NamedTuple

import yaml

from ur5_ros.config.records import Meta, Record, validate
from ur5_ros.config.strict_yaml import read_text, read_yaml
from ur5_ros.errors import BagError, InputError

METADATA_FILE = 'metadata.yaml'
VERSION = 9
DISTRO = 'jazzy'

#: Starting time that rosbag2 writes for a bag without messages [ns].
NO_TIME = 2**63 - 1

Count = Annotated[int, Meta(ge=0)]

#: rmw's infinite duration, as rosbag2 writes it.
_INFINITE = {'sec': 9223372036, 'nsec': 854775807}


def qos_profile(reliability: str = 'reliable', durability: str = 'volatile',
                history: str = 'keep_last', depth: int = 1) -> dict[str, Any]:
    """
    Return an offered QoS profile as rosbag2 writes it.

    ``reliability``: ``'reliable'`` or ``'best_effort'``; ``durability``: ``'volatile'`` or
    ``'transient_local'``; ``history``: ``'keep_last'`` or ``'keep_all'``; ``depth``: messages kept
    by ``'keep_last'``.
    """
    return {
        'history': history, 'depth': depth, 'reliability': reliability, 'durability': durability,
        'deadline': dict(_INFINITE), 'lifespan': dict(_INFINITE), 'liveliness': 'automatic',
        'liveliness_lease_duration': dict(_INFINITE), 'avoid_ros_namespace_conventions': False,
    }


class TopicEntry(NamedTuple):
    """One topic of a bag."""

    name: str
    type: str
    qos: Sequence[Mapping[str, Any]]
    type_hash: str
    messages: int


class FileEntry(NamedTuple):
    """One storage file of a bag."""

    path: str
    start: int | None
    """Smallest log time [ns], None in a file without messages."""
    end: int
    messages: int


class _Dumper(yaml.SafeDumper):
    """Block style with indented lists, as yaml-cpp writes them for rosbag2; no aliases."""

    def increase_indent(self, flow=False, indentless=False):
        """Indent lists below their key too."""
        return super().increase_indent(flow, False)

    def ignore_aliases(self, data):
        """Write everything out, however often it comes."""
        return True


def to_yaml(data: Any) -> str:
    """Return plain data as YAML in rosbag2's layout."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=10**6)


def describe_bag(files: Sequence[FileEntry], topics: Sequence[TopicEntry],
                 custom_data: Mapping[str, str]) -> dict[str, Any]:
    """Return the values below ``rosbag2_bagfile_information``, in rosbag2's order (version 9)."""
    starts = [file.start for file in files if file.start is not None]
    start = min(starts, default=NO_TIME)
    end = max((file.end for file in files if file.start is not None), default=NO_TIME)
    return {
        'version': VERSION,
        'storage_identifier': 'mcap',
        'duration': {'nanoseconds': end - start},
        'starting_time': {'nanoseconds_since_epoch': start},
        'message_count': sum(file.messages for file in files),
        'topics_with_message_count': [
            {'topic_metadata': {
                'name': topic.name, 'type': topic.type, 'serialization_format': 'cdr',
                'offered_qos_profiles': [dict(profile) for profile in topic.qos],
                'type_description_hash': topic.type_hash},
             'message_count': topic.messages}
            for topic in topics],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [file.path for file in files],
        'files': [
            {'path': file.path,
             'starting_time': {
                 'nanoseconds_since_epoch': NO_TIME if file.start is None else file.start},
             'duration': {'nanoseconds': 0 if file.start is None else file.end - file.start},
             'message_count': file.messages}
            for file in files],
        'custom_data': dict(custom_data) or None,
        'ros_distro': DISTRO,
    }


def write_metadata(folder: Path, information: Mapping[str, Any]) -> None:
    """Write metadata.yaml, complete or not at all; raises OSError where the disk does."""
    unfinished = folder / (METADATA_FILE + '.unfinished')
    try:
        with open(unfinished, 'w', encoding='utf-8') as file:
            file.write(to_yaml({'rosbag2_bagfile_information': dict(information)}))
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(folder / METADATA_FILE)
    except OSError:
        unfinished.unlink(missing_ok=True)
        raise


class _Loose(Record, frozen=True, forbid_unknown_fields=False):
    """A record of which only the fields that are used are checked; versions differ in the rest."""


class _TopicMetadata(_Loose, frozen=True):
    name: str
    type: str
    serialization_format: str = 'cdr'


class _TopicCount(_Loose, frozen=True):
    topic_metadata: _TopicMetadata
    message_count: Count


class _FileCount(_Loose, frozen=True):
    path: str
    message_count: Count


class Information(_Loose, frozen=True, kw_only=True):
    """The content of a metadata.yaml, of all versions that rosbag2 has written."""

    version: Annotated[int, Meta(ge=1)]
    storage_identifier: str = ''
    relative_file_paths: Annotated[list[str], Meta(max_length=100_000)]
    message_count: Count = 0
    topics_with_message_count: list[_TopicCount] = []
    compression_format: str = ''
    compression_mode: str = ''
    files: list[_FileCount] = []
    custom_data: dict[str, str] | None = None


def read_metadata(folder: Path) -> Information:
    """
    Return the content of the metadata.yaml of a folder; its paths stay inside the folder.

    BagError if it cannot be read, is of a newer version, or names a file twice or outside the
    folder.

    """
    path = folder / METADATA_FILE
    try:
        data = read_yaml(path)
    except InputError as error:
        raise BagError(str(error)) from None
    if not isinstance(data, dict) or not isinstance(data.get('rosbag2_bagfile_information'), dict):
        raise BagError(f'{path}: no rosbag2_bagfile_information in it; remove the file and repair '
                       'the bag with: ur5 recover')
    _keep_texts(path, data['rosbag2_bagfile_information'])
    try:
        found = validate(Information, data['rosbag2_bagfile_information'], str(path))
    except InputError as error:
        raise BagError(str(error)) from None
    if found.version > VERSION:
        raise BagError(f'{path}: version {found.version}; versions up to {VERSION} are read')
    names = found.relative_file_paths
    for name in names:
        # rosbag2 before version 4 named files as <folder>/<file>.
        plain = name.removeprefix(folder.name + '/') if found.version < 4 else name
        if PurePath(plain).name != plain or '\0' in plain or '\\' in plain or plain in ('', '..'):
            raise BagError(f'{path}: names the file {name[:80]!r}; '
                           'only files of the folder itself are read')
    if len(set(names)) != len(names):
        raise BagError(f'{path}: names a file twice')
    return found


def _keep_texts(path: Path, information: dict[str, Any]) -> None:
    """Take texts in custom_data for texts: rosbag2 writes none of them in quotes."""
    custom = information.get('custom_data')
    if isinstance(custom, dict) and not all(isinstance(each, str) for each in custom.values()):
        plain = yaml.load(read_text(path), Loader=yaml.BaseLoader)
        information['custom_data'] = plain['rosbag2_bagfile_information']['custom_data']
