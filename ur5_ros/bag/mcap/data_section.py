"""The data section of an MCAP file: checked by its CRC, or read around damage."""

from collections.abc import Callable, Iterator
from pathlib import Path

from ur5_ros.bag.mcap.record_scan import Buffer, data_crc, read_chunks, scan
from ur5_ros.bag.mcap.records import MAGIC, Opcode
from ur5_ros.bag.mcap.summary import Summary
from ur5_ros.errors import BagError

Report = Callable[[str], None]


def check_data(path: Path, summary: Summary | None,
               report: Report) -> tuple[bool | None, Buffer]:
    """
    Return whether all data have their CRC, None where none was kept, and the first bytes read.

    ``summary`` is None for an unfinished file; ``report`` takes a sentence about a mismatch.

    """
    if summary is None:
        return None, b''
    try:
        crc = data_crc(path, summary.start)
    except OSError as error:
        report(f'{path}: cannot be read: {error.strerror}')
        return None, b''
    if crc is None:
        report(f'{path}: its data do not end where its summary starts')
        return False, b''
    stated, found, start = crc
    if stated not in (0, found):
        report(f'{path}: was changed after it was written (CRC of the data)')
    return None if stated == 0 else stated == found, start


def data_records(path: Path, size: int, summary: Summary | None, damaged: bool,
                 report: Report, start: Buffer = b'') -> Iterator[tuple[int, memoryview]]:
    """
    Yield (opcode, whole record) of the data: all of them, or past damage the indexed chunks.

    ``summary`` is None for an unfinished file: then reading ends at the first damage. In data
    known to be ``damaged``, lengths are not followed. ``start`` are the first bytes of the file,
    if they have been read already.

    """
    at = len(MAGIC)
    if not (damaged and _indexed(path, summary, report)):
        for opcode, record in scan(path, size, report, start):
            at += len(record)
            if opcode != Opcode.DATA_END:
                yield opcode, record
                continue
            if summary is not None and at != summary.start:
                report(f'{path}: its data do not end where its summary starts')
            return
    left = [each for each in _indexed(path, summary, report) if each[0] >= at]
    yield from read_chunks(path, left, report)


def _indexed(path: Path, summary: Summary | None, report: Report) -> list[tuple[int, int]]:
    try:
        return summary.chunks(path) if summary else []
    except BagError as problem:
        report(str(problem))
        return []
