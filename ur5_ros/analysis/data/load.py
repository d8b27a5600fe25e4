"""Bags to a :class:`~ur5_ros.analysis.data.run.Run`: states, answers and references, by stamp."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.analysis.data.bags import BagData, open_bags
from ur5_ros.analysis.data.contact import contact_rows, contact_series
from ur5_ros.analysis.data.effort_meaning import with_effort_meaning
from ur5_ros.analysis.data.given_reference import given_reference
from ur5_ros.analysis.data.node_records import messages_of
from ur5_ros.analysis.data.options import ReadingOptions, check_effort_meaning
from ur5_ros.analysis.data.order_pairing import efforts_of_arrays, hold_by_order, pair_by_order
from ur5_ros.analysis.data.rows import FIELDS, StateRows, foreign_rows, own_rows
from ur5_ros.analysis.data.run import (
    PARTS,
    NodeRecord,
    ParameterChange,
    RecordedEvent,
    Run,
    States,
    total_effort,
)
from ur5_ros.analysis.data.target_wrench import target_wrenches
from ur5_ros.analysis.data.topic_roles import PART_NAMES
from ur5_ros.config import CONTROL_PARAMETERS, complete, load_arm
from ur5_ros.errors import InputError
from ur5_ros.signals import Reference

__all__ = ['PARTS', 'NodeRecord', 'ParameterChange', 'RecordedEvent', 'Run', 'States', 'load_run']

#: Nodes whose bag is preferred for what the simulator, and what the law, publishes.
_FROM_SIM, _FROM_LAW = ('sim', 'robot', '', 'control'), ('control', 'robot', '', 'sim')


def load_run(
    folder: Path | str, arm: str | None = None, control_arm: str | None = None,
    kp: list[float] | None = None, kd: list[float] | None = None,
    topics: dict[str, str] | None = None, joint_prefix: str | None = None,
    effort: str | None = None, keep_arm: bool = False, reference: str = '',
) -> Run:
    """
    Return the run that a folder of bags holds.

    Parameters
    ----------
    folder : path
        Run folder with ``sim`` and ``control``, one bag folder, or one MCAP or sqlite3 file;
        written by this package, by ``ros2 bag record`` or by another recorder.
    arm, control_arm : str, optional
        Arms of plant and law, for bags that do not state them or to try others.
    kp, kd : list of float, optional
        Gains likewise.
    topics : dict of str to str, optional
        Role -> topic, for bags that do not state it.
    joint_prefix : str, optional
        Text before the joint names; found if not given.
    effort : str, optional
        What the recorded effort is: ``total``, ``gravity_excluded``, ``target``, ``current`` or
        ``other_sign``.
    keep_arm : bool, optional
        Use ``arm`` and ``control_arm`` only where the bag does not state its own.
    reference : str, optional
        The reference where none is recorded, or another one: a topic, an experiment, six joint
        angles or a tool pose; see :func:`~ur5_ros.analysis.data.given_reference.given_reference`.

    Returns
    -------
    Run
        As far as every bag is whole; ``problems`` and ``remarks`` list what is missing.

    Raises
    ------
    InputError
        If nothing can be judged: no bag, no states, other joints, bags of different runs.

    Examples
    --------
    >>> from ur5_ros import load_run, run_closed_loop, run_config
    >>> _ = run_closed_loop(run_config('joint_step', duration=0.5), folder='recorded')
    >>> run = load_run('recorded')
    >>> run.states.q.shape, run.control_rate
    ((500, 6), 1000.0)

    """
    check_effort_meaning(effort)
    folder = Path(folder)
    bags, problems = open_bags(folder, ReadingOptions(topics or {}, joint_prefix))
    problems += [problem for bag in bags for problem in bag.problems]
    remarks = [remark for bag in bags for remark in bag.remarks]
    bag = _first(bags, 'joint_states', ('sim', 'robot', '', 'control'))
    if bag is None:
        why = f' ({problems[0]})' if problems else ''
        raise InputError(f'{folder}: no joint states in it; nothing can be judged{why}')
    sim = next((bag.record for bag in bags if bag.node == 'sim'), None)
    control = next((bag.record for bag in bags if bag.node in ('control', 'robot')), None)
    counts: dict[str, int] = {}
    found = _states(bag, bags, counts, problems, remarks)
    stamp = found.stamp
    if len(stamp) < 2:
        raise InputError(f'{folder}: {len(stamp)} states; at least two are needed')
    gains = {key: value for key, value in (('kp', kp), ('kd', kd)) if value is not None}
    if keep_arm:
        arm, control_arm = (arm if not (sim or control) else None,
                            control_arm if control is None else None)
    recorded = _reference(bags, stamp)
    run = Run(
        name=next((each.run for each in bags if each.run), folder.resolve().name),
        stamp=stamp, states=_published(bag, found.states),
        control_rate=float(sim.parameters['control_rate']) if sim else _rate(stamp),
        physics_rate=float(sim.parameters['physics_rate']) if sim else 0.0,
        truth=_truth(bags, stamp), reference=recorded, parts=_parts(bags, stamp),
        sim=_sim_record(sim, arm),
        control=_control_record(control, control_arm or (arm if sim is None else None), gains),
        events=tuple(event for each in bags for event in each.events), counts=counts,
        problems=tuple(problems), remarks=tuple(remarks), dropped=found.dropped,
        jumps=found.jumps, folder=str(folder), current=_current(bags, stamp),
        follows_reference=bag.effort == 'target torque' and recorded is not None,
        target_wrenches=tuple(wrench for each in bags if each.node == 'control'
                              for wrench in target_wrenches(each, found.states)),
        **_answers(bags, bag, found, counts), **_contact(bags, stamp, sim))
    run = with_effort_meaning(run, effort)
    return replace(run, reference=given_reference(run, reference)) if reference else run


def _published(bag: BagData, states: States) -> States:
    """Return the states of a bag with the torque that acted as effort."""
    if bag.node != 'sim' or bag.record is None:
        return states
    return total_effort(states, bag.record.parameters, bag.record.arm)


def _first(bags: list[BagData], role: str, order: tuple[str, ...]) -> BagData | None:
    """Return the bag that has a role, of several the first in the order of nodes."""
    ranked = sorted((bag for bag in bags if bag.has(role)), key=lambda bag: order.index(bag.node))
    return ranked[0] if ranked else None


def _states(bag: BagData, bags: list[BagData], counts, problems, remarks) -> StateRows:
    """Return the joint states that count, as far as every unfinished bag reaches."""
    columns = bag.data['joint_states']
    if bag.node not in ('sim', 'control'):
        found = foreign_rows(columns, bag.path, counts, problems, remarks)
        dropped = np.concatenate([found.dropped, np.array(bag.dropped, np.int64)])
        return found._replace(dropped=np.sort(dropped))
    found = own_rows(columns, bag.path, counts, problems)
    for each in bags:
        if not each.problems or each.node != 'control':
            continue
        ends = [int(each.data[role].stamp.max()) for role in ('joint_command', 'reference')
                if each.has(role)]
        if ends:
            count = int((found.stamp <= min(ends)).sum())
            found = found._replace(rows=found.rows[:count], stamp=found.stamp[:count],
                                   states=States(*(part[:count] for part in found.states)))
    return found


def _rate(stamp: np.ndarray) -> float:
    """Return the rate of states whose bag does not state it [Hz]."""
    rate = 1e9 / float(np.median(np.diff(stamp)))
    return float(round(rate)) if abs(rate - round(rate)) < 1e-3 * rate else rate


def _match(stamp: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and rows of the others with equal stamp; of equal others the first."""
    unique, first = np.unique(others, return_index=True)
    _, rows, found = np.intersect1d(stamp, unique, assume_unique=True, return_indices=True)
    return rows, first[found]


def _aligned(stamp: np.ndarray, others: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return ``values`` at the states' stamps; NaN where there is none."""
    out = np.full((len(stamp), values.shape[1]), np.nan)
    rows, found = _match(stamp, others)
    out[rows] = values[found]
    return out


def _answers(bags: list[BagData], states_bag: BagData, states: StateRows,
             counts: dict[str, int]) -> dict[str, Any]:
    """Return command, and wall-clock times of states and commands at the simulator."""
    if held := _held_commands(bags, states.stamp, counts):
        return held
    bag = _first(bags, 'joint_command', ('control', 'sim', '', 'robot'))
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
    answer = {'command': _aligned(stamp, commands.stamp, commands.effort)}
    heard = _first(bags, 'joint_command', _FROM_SIM)
    if heard is not None and heard.has('joint_states'):
        commands, sent_states = heard.data['joint_command'], heard.data['joint_states']
        # Of copies of a state the last one sent is the one that is answered.
        order = np.arange(len(sent_states.stamp))[::-1]
        sent, arrived = np.zeros((2, len(stamp)), dtype=np.int64)
        at, found = _match(stamp, sent_states.stamp[order])
        sent[at] = sent_states.log_time[order][found]
        at, found = _match(stamp, commands.stamp)
        arrived[at] = commands.log_time[found]
        answer.update(state_time=sent, command_time=arrived)
    return answer


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


def _reference(bags: list[BagData], stamp: np.ndarray) -> Reference | None:
    bag = _first(bags, 'reference', _FROM_LAW)
    if bag is None:
        return None
    columns = bag.data['reference']
    return Reference(*(_aligned(stamp, columns.stamp, columns.fields[name])
                       for name in ('positions', 'velocities', 'accelerations')))


def _truth(bags: list[BagData], stamp: np.ndarray) -> States | None:
    bag = _first(bags, 'ground_truth', _FROM_SIM)
    if bag is None:
        return None
    columns = bag.data['ground_truth']
    return States(*(_aligned(stamp, columns.stamp, columns.fields[field]) for field in FIELDS))


def _efforts(bags: list[BagData], role: str, order: tuple[str, ...],
             stamp: np.ndarray) -> np.ndarray | None:
    """Return the efforts of a role at the states' stamps; None where it is not recorded."""
    bag = _first(bags, role, order)
    return None if bag is None else _aligned(stamp, bag.data[role].stamp, bag.data[role].effort)


def _parts(bags: list[BagData], stamp: np.ndarray) -> dict[str, np.ndarray]:
    values = _efforts(bags, 'torque_parts', _FROM_LAW, stamp)
    if values is None:
        return {}
    return {part: values[:, 6 * i:6 * i + 6] for i, part in enumerate(PART_NAMES)}


def _contact(bags: list[BagData], stamp: np.ndarray, sim: NodeRecord | None) -> dict[str, Any]:
    """Return what the arm touched, where there is a world."""
    if sim is None or sim.world.empty:
        return {}
    bag = next(bag for bag in bags if bag.node == 'sim')
    rate = float(sim.parameters['physics_rate'])
    steps = round(rate / sim.parameters['control_rate'])
    rows = np.zeros((len(stamp), steps, 6))
    if bag.has('contact_effort'):
        columns = bag.data['contact_effort']
        rows = contact_rows(stamp, rate, steps, columns.stamp, columns.effort)
    messages = ((role, data) for role in ('contacts', 'objects') if bag.has(role)
                for data in messages_of(bag.data[role]))
    return {'contact': rows, **contact_series(messages)}


def _current(bags: list[BagData], stamp: np.ndarray) -> np.ndarray | None:
    return _efforts(bags, 'motor_current', ('robot', '', 'sim', 'control'), stamp)


def _sim_record(record: NodeRecord | None, arm: str | None) -> NodeRecord | None:
    if record is None or arm is None:
        return record
    return replace(record, arm_name=arm, arm=load_arm(arm))


def _control_record(
    record: NodeRecord | None, name: str | None, gains: dict[str, list[float]],
) -> NodeRecord | None:
    """Return the controller's record from its bag, with the user's arm and gains in it."""
    if record is None:
        if name is None:
            return None
        given = complete(CONTROL_PARAMETERS, {'arm': name})
        unknown = {} if gains else {'mode': 'unknown'}
        return NodeRecord(name, load_arm(name), given | gains | unknown)
    if name:
        record = replace(record, arm_name=name, arm=load_arm(name))
    changes = tuple(
        change._replace(values={key: value for key, value in change.values.items()
                                if key not in gains}) for change in record.changes)
    return replace(record, parameters={**record.parameters, **gains}, changes=changes)
