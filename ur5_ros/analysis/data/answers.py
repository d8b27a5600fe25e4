"""The commands that answered the states of a run, by stamp or by order."""

from typing import Any

import numpy as np

from ur5_ros.analysis.data.bags import BagData
from ur5_ros.analysis.data.series import (
    FROM_SIM,
    aligned,
    efforts_of_arrays,
    first_bag,
    matching_rows,
)
from ur5_ros.analysis.data.states.rows import StateRows
from ur5_ros.bag.arrays.columns import Columns


def answers_of(bags: list[BagData], states_bag: BagData, states: StateRows,
               counts: dict[str, int]) -> dict[str, Any]:
    """Return command, and wall-clock times of states and commands at the simulator."""
    if held := _held_commands(bags, states.stamp, counts):
        return held
    bag = first_bag(bags, 'joint_command', ('control', 'sim', '', 'robot'))
    if bag is None:
        return _unstamped_answers(bags, states.stamp, counts)
    stamp, commands = states.stamp, bag.data['joint_command']
    stamped = commands.stamp > 0
    counts['answers_unstamped'] = int((~stamped).sum())
    if not stamped.any():
        return _unstamped_answers(bags, stamp, counts)
    recorded = states_bag.data['joint_states'].stamp
    counts['answers_without_state'] = int(
        (~np.isin(commands.stamp[stamped], recorded)
         & (commands.stamp[stamped] <= stamp[-1])).sum())
    answer = {'command': aligned(stamp, commands.stamp, commands.effort)}
    if not any(each.node for each in bags):
        answer['command'] = _at_own_rate(answer['command'], len(commands.stamp), counts)
    received = first_bag(bags, 'joint_command', FROM_SIM)
    if received is not None and received.has('joint_states'):
        commands, sent_states = received.data['joint_command'], received.data['joint_states']
        # Of copies of a state the last one sent is the one that is answered.
        order = np.arange(len(sent_states.stamp))[::-1]
        sent, arrived = np.zeros((2, len(stamp)), dtype=np.int64)
        at, found = matching_rows(stamp, sent_states.stamp[order])
        sent[at] = sent_states.log_time[order][found]
        at, found = matching_rows(stamp, commands.stamp)
        arrived[at] = commands.log_time[found]
        answer.update(state_time=sent, command_time=arrived)
    return answer


def _at_own_rate(command: np.ndarray, count: int, counts: dict[str, int]) -> np.ndarray:
    """Return the commands of a robot: where they are fewer than its states each acts on."""
    rows = np.flatnonzero(np.isfinite(command).all(axis=1))
    if len(rows) < 2 or np.median(np.diff(rows)) < 2.0:
        return command
    counts['commands_held'] = count
    last = np.searchsorted(rows, np.arange(len(command)), side='right') - 1
    return np.where((last >= 0)[:, None], command[rows[np.maximum(last, 0)]], np.nan)


def _held_commands(bags: list[BagData], stamp: np.ndarray,
                   counts: dict[str, int]) -> dict[str, Any]:
    """Return the commands of a paced run by another controller: each acts until the next."""
    sim = next((bag for bag in bags if bag.node == 'sim' and bag.record is not None), None)
    if sim is None or sim.record is None or any(bag.node == 'control' for bag in bags):
        return {}
    parameters = sim.record.parameters
    if (parameters['lockstep'] or not sim.has('joint_command')
            or parameters.get('repeated_command_timeout') or parameters['delay.command_periods']):
        return {}
    commands = sim.data['joint_command']
    counts['commands_held'] = len(commands.stamp)
    command = hold_by_order(sim.data['joint_states'], stamp, commands,
                            parameters['command_timeout'])
    for event in sim.events:  # each holds from its stamp to the next of its kind
        if event.kind == 'fallback':
            later = [each.stamp for each in sim.events
                     if each.kind == 'fallback' and each.stamp > event.stamp]
            if event.values.get('active'):
                command[(stamp >= event.stamp) & (stamp < min(later, default=np.inf))] = np.nan
    return {'command': command}


def _unstamped_answers(bags: list[BagData], stamp: np.ndarray,
                       counts: dict[str, int]) -> dict[str, Any]:
    """Return commands without a stamp, paired by order where the simulator ran in lockstep."""
    for bag in bags:
        if bag.node != 'sim' or bag.record is None or not bag.record.parameters['lockstep']:
            continue
        role = 'joint_command' if bag.has('joint_command') else 'forward_command'
        if not bag.has(role) or bag.record.summary.get('lockstep_fired'):
            continue
        commands = bag.data[role]
        efforts = commands.effort if role == 'joint_command' else efforts_of_arrays(commands)
        command = pair_by_order(bag.data['joint_states'], stamp, commands.log_time, efforts)
        if command is not None:
            counts['answers_paired_by_order'] = int(np.isfinite(command).all(axis=1).sum())
            return {'command': command}
    return {}


def pair_by_order(
    states: Columns, stamp: np.ndarray, log_time: np.ndarray, efforts: np.ndarray,
) -> np.ndarray | None:
    """
    Return the command that answers each state, from what the simulator's bag recorded in lockstep.

    A command answers the state that was sent last before it. The simulator sends the next state
    when it has taken one, so that each state but the first has one command at most.

    ``states`` are as recorded, copies included; ``stamp`` are those of the run's states,
    ``log_time`` when each command was recorded [ns], ``efforts`` its torques (m, 6).  The result
    (n, 6) is NaN where a state has no command, and None where one has several.

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

    ``states`` and ``commands`` are as recorded, refused ones included; ``timeout`` is
    ``command_timeout`` [simulated s].  The result (n, 6) is NaN where no command acted, and in the
    last row.

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
