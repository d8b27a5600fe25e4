"""Where a real robot was probably touched: external torque that its model does not explain."""

from typing import Any, NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.external_torque import robot_external_torque
from ur5_ros.analysis.result import Check, judge, not_applicable
from ur5_ros.signals import JOINT_NAMES

NAME = 'contact likely'

#: An external torque counts as a contact when for this long [s] it exceeds what friction may hold
#: at rest by this many times what the arm's model left unexplained, RMS, on a recording that it
#: was not fitted to.
LASTING, TIMES = 0.3, 5.0
#: Share of a recording above which a load explains it as well as a contact.
LOAD_SHARE = 0.5


class _Touch(NamedTuple):
    """A time in which a contact is likely."""

    start: float
    """[s]."""
    duration: float
    """[s]."""
    joint: str
    """The joint that is most above its mark."""
    torque: float
    """Largest external torque there [N m]."""


def contact_likely(run: Run) -> tuple[list[Check], dict[str, Any]]:
    """
    Return the check of a real robot's recording, and the series for the figure.

    ``run``: A recording that is not of this package's simulator; of others nothing is returned.
    """
    record = run.law_record
    if run.sim is not None or record is None:
        return [], {}
    arm = record.arm
    if arm.unexplained_torque is None:
        return ([] if run.current is None else [not_applicable(
            NAME, f'the file of arm {arm.name} does not have what the model leaves unexplained; '
            'make one of recordings without contact: ur5 identify RUN -o ARM.yaml')]), {}
    found = robot_external_torque(run, arm)
    if found is None:
        return [not_applicable(NAME, f'arm {arm.name} has no torque constants for the recorded '
                               'currents, or no torque is recorded')], {}
    estimate, marks = found.estimate, found.held + TIMES * arm.unexplained_torque
    level = np.abs(estimate) / marks
    lasting = _moving_minimum(level, max(1, round(LASTING * run.control_rate)))
    touches = _touches(run, estimate, level, lasting)
    most = np.abs(estimate).max(axis=0)
    check = judge(NAME, float(lasting.max(initial=0.0)), 1.0, '1', _sentence(run, touches, most),
                  touches=[touch._asdict() for touch in touches],
                  unexplained_torque=arm.unexplained_torque.tolist(),
                  torque_max=dict(zip(JOINT_NAMES, most.tolist(), strict=True)))
    return [check], {'external_torque': (estimate, marks)}


def _sentence(run: Run, touches: list[_Touch], most: np.ndarray) -> str:
    if not touches:
        return (f'no external torque lasts {LASTING:g} s above what friction may hold at rest '
                f'and {TIMES:g} times what the model leaves unexplained (largest: '
                f'{most.max():.3g} N m at {JOINT_NAMES[int(most.argmax())]})')
    listed = '; '.join(f'{touch.start:.3g} s on for {touch.duration:.2g} s, {touch.torque:.3g} '
                       f'N m at {touch.joint}' for touch in touches[:10])
    load = sum(touch.duration for touch in touches) > LOAD_SHARE * float(run.t[-1])
    return f'contact is likely from {listed}' + (
        '; it lasts through most of the recording: a payload that the arm does not declare looks '
        'the same' if load else '')


def _touches(run: Run, estimate: np.ndarray, level: np.ndarray,
             lasting: np.ndarray) -> list[_Touch]:
    """Return the times in which a joint is above its mark long enough."""
    length = len(level) - len(lasting) + 1
    above = np.zeros(len(level) + 1, dtype=int)
    for first in np.flatnonzero(lasting.max(axis=1) > 1.0):
        above[first:first + length] = 1
    edges = np.diff(above, prepend=0)
    found = []
    for first, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        joint = int(level[first:end].max(axis=0).argmax())
        found.append(_Touch(float(run.t[first]), float(run.t[end - 1] - run.t[first]),
                            JOINT_NAMES[joint], float(np.abs(estimate[first:end, joint]).max())))
    return found


def _moving_minimum(values: np.ndarray, length: int) -> np.ndarray:
    """Return the least of each ``length`` rows that follow each other, (n - length + 1, 6)."""
    if length > len(values):
        return values[:0]
    size = 1
    while 2 * size <= length:
        values = np.minimum(values[:-size], values[size:])
        size *= 2
    rest = length - size
    return np.minimum(values[:-rest], values[rest:]) if rest else values
