"""Commands without a stamp, paired with states by their order: lockstep makes that certain."""

import numpy as np

from ur5_ros.bag.arrays.columns import Columns, RawColumns
from ur5_ros.cdr.codec import decode


def pair_by_order(
    states: Columns, stamp: np.ndarray, log_time: np.ndarray, efforts: np.ndarray,
) -> np.ndarray | None:
    """
    Return the command that answers each state, from what the simulator's bag recorded in lockstep.

    A command answers the state that was sent last before it. The simulator sends the next state
    when it has taken one, so that each state but the first has one command at most.

    Parameters
    ----------
    states : Columns
        States as recorded, copies included.
    stamp : numpy.ndarray, shape (n,)
        Stamps of the states of the run [ns], ascending.
    log_time, efforts : numpy.ndarray, shapes (m,), (m, 6)
        When each command was recorded [ns], and its torques [N m].

    Returns
    -------
    numpy.ndarray, shape (n, 6), or None
        NaN where a state has no command; None where a state has several.

    """
    order = np.argsort(states.log_time, kind='stable')
    sent = np.searchsorted(states.log_time[order], log_time, side='right') - 1
    known = sent >= 0
    answered = states.stamp[order][sent[known]]
    rows, efforts = np.searchsorted(stamp, answered), efforts[known]
    inside = (rows < len(stamp)) & (stamp[np.minimum(rows, len(stamp) - 1)] == answered)
    rows, efforts = rows[inside], efforts[inside]
    if np.any(np.bincount(rows, minlength=1)[1:] > 1):
        return None
    command = np.full((len(stamp), 6), np.nan)
    command[rows] = efforts  # of several answers to the first state the last one acted
    return command


def hold_by_order(states: Columns, stamp: np.ndarray, commands: Columns,
                  timeout: float) -> np.ndarray:
    """
    Return the command that acted from each state on, where commands come at their own rate.

    A paced simulator lets the newest command act that is neither from the future nor older than
    ``command_timeout``; its bag has states and commands in the order in which they came.

    Parameters
    ----------
    states : Columns
        States as recorded by the simulator.
    stamp : numpy.ndarray, shape (n,)
        Stamps of the states of the run [ns], ascending.
    commands : Columns
        Commands as recorded by the simulator, refused ones included.
    timeout : float
        ``command_timeout`` [simulated s].

    Returns
    -------
    numpy.ndarray, shape (n, 6)
        NaN where no command acted, and in the last row.

    """
    oldest = round(timeout * 1e9)
    sent = states.log_time[np.searchsorted(states.stamp, stamp)]
    present = np.searchsorted(sent, commands.log_time, side='right') - 1
    held = np.full((len(stamp), 6), np.nan)
    acting, acting_stamp, at = None, 0, 0
    finite = np.isfinite(commands.effort).all(axis=1)
    for row in range(len(stamp) - 1):
        while at < len(present) and commands.log_time[at] < sent[row + 1]:
            now = int(stamp[max(int(present[at]), 0)])
            own = int(commands.stamp[at]) or now
            if finite[at] and acting_stamp <= own <= now and now - own <= oldest:
                acting, acting_stamp = commands.effort[at], own
            at += 1
        if acting is not None and stamp[row] - acting_stamp <= oldest:
            held[row] = acting
    return held


def efforts_of_arrays(raw: RawColumns) -> np.ndarray:
    """Return the torques of std_msgs/Float64MultiArray messages, shape (n, 6); NaN for others."""
    efforts = np.full((len(raw.log_time), 6), np.nan)
    for i, (begin, end) in enumerate(zip(raw.offsets[:-1].tolist(), raw.offsets[1:].tolist(),
                                         strict=True)):
        message = decode('std_msgs/msg/Float64MultiArray', raw.data[begin:end].tobytes())
        if len(message['data']) == 6:
            efforts[i] = message['data']
    return efforts
