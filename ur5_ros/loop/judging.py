"""Many run folders judged, each on its own."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ur5_ros.analysis.result import FAIL
from ur5_ros.analysis.run import load_run
from ur5_ros.analysis.validate import validate
from ur5_ros.config.validation import load_marks
from ur5_ros.errors import Refusal

#: Verdict of a folder that cannot be read.
UNREADABLE = 'unreadable'


class Judgement(NamedTuple):
    """What was found of one run folder; plain values that travel between processes."""

    folder: str
    run: str
    verdict: str
    """``pass``, ``fail`` or ``unreadable``."""
    why: str
    """The sentences of the checks that failed, or why it cannot be read; empty if it passed."""
    result: dict[str, Any]
    """The JSON document of the result."""


def judge_folder(folder: str, given: Mapping[str, Any]) -> Judgement:
    """
    Return what the validator says of a run folder.

    Parameters
    ----------
    folder : str
        Run folder.
    given : mapping
        ``arm``, ``control_arm``, ``kp``, ``kd`` for bags that do not say.

    """
    try:
        result = validate(load_run(Path(folder), **given), load_marks())
    except Refusal as refusal:
        return Judgement(folder, Path(folder).name, UNREADABLE, str(refusal), {})
    why = '; '.join(check.sentence for check in result.checks if check.verdict == FAIL)
    return Judgement(folder, result.run, result.verdict, why, result.to_plain())


def judge_all(folders: list[Path], given: Mapping[str, Any]) -> Iterator[Judgement]:
    """Yield the judgement of each folder, in any order."""
    for folder in folders:
        yield judge_folder(str(folder), given)
