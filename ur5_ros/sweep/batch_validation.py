"""Many run folders judged, each on its own."""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.result import FAIL
from ur5_ros.analysis.validate import validate
from ur5_ros.config.validation import Marks, load_marks
from ur5_ros.errors import InputError

#: Verdicts of a folder that cannot be read, and of one that is read and cannot be judged.
UNREADABLE, NOT_JUDGED = 'unreadable', 'not judged'

#: From this many folders on it pays to start workers.
SHARED_FROM = 16


class Judgement(NamedTuple):
    """What was found of one run folder; plain values that travel between processes."""

    folder: str
    run: str
    verdict: str
    """``pass``, ``fail``, ``unreadable`` or ``not judged``."""
    why: str
    """The sentences of the checks that failed, or why it cannot be read; empty if it passed."""
    result: dict[str, Any]
    """The JSON document of the result."""


@cache
def marks_of(path: str = '') -> Marks:
    """Return the pass marks of a file, or of the package, read once a process."""
    return load_marks(path)


def judge_folder(folder: str, given: Mapping[str, Any], marks: str = '') -> Judgement:
    """
    Return the validator's judgement of a run folder.

    ``given``: ``arm``, ``control_arm``, ``kp``, ``kd`` for bags without them; ``marks``: file of
    pass marks; those of the package by default.
    """
    name, limits = Path(folder).name, marks_of(marks)
    verdict = UNREADABLE
    try:
        run = load_run(Path(folder), **given)
        verdict = NOT_JUDGED
        result = validate(run, limits)
    except InputError as refusal:
        return Judgement(folder, name, verdict, str(refusal), {})
    except Exception as error:  # one run must not end the others
        what = f'internal error: {type(error).__name__}: {error}'
        return Judgement(folder, name, NOT_JUDGED, what, {})
    why = '; '.join(check.sentence for check in result.checks if check.verdict == FAIL)
    return Judgement(folder, result.run, result.verdict, why, json.loads(result.to_json()))


def judge_all(
    folders: list[Path], given: Mapping[str, Any], marks: str = '',
) -> Iterator[Judgement]:
    """Yield the judgement of each folder, in any order; many are shared among Dask workers."""
    names = [str(folder.absolute()) for folder in folders]
    shown = dict(zip(names, map(str, folders), strict=True))
    if len(names) < SHARED_FROM or find_spec('distributed') is None:
        for name in names:
            yield judge_folder(name, given, marks)._replace(folder=shown[name])
        return
    from ur5_ros.sweep.workers import cluster, connected, map_batches  # dask is an extra
    with cluster() as address, connected(address) as client:
        for found in map_batches(client, judge_batch, (dict(given), marks), iter(names), 1, _lost):
            for judgement in found:
                yield judgement._replace(folder=shown[judgement.folder])


def judge_batch(
    given: Mapping[str, Any], marks: str, folders: list[str],
) -> list[Judgement]:
    """Return the judgements of some folders: the task that travels to a worker."""
    return [judge_folder(folder, given, marks) for folder in folders]


def _lost(folder: str, error: BaseException) -> Judgement:
    return Judgement(folder, Path(folder).name, UNREADABLE, repr(error), {})
