"""Bags to a :class:`~ur5_ros.analysis.data.run.Run`: states, answers and references, by stamp."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.answers import answers_of
from ur5_ros.analysis.data.bags import BagData, open_bags
from ur5_ros.analysis.data.described_arm import described_arm
from ur5_ros.analysis.data.effort_meaning import with_effort_meaning
from ur5_ros.analysis.data.given_reference import given_reference
from ur5_ros.analysis.data.options import ReadingOptions, check_effort_meaning
from ur5_ros.analysis.data.run import NodeRecord, Run, States, total_effort
from ur5_ros.analysis.data.series import (
    contact_of,
    current_of,
    first_bag,
    parts_of,
    reference_of,
    temperature_of,
    truth_of,
)
from ur5_ros.analysis.data.states.rows import StateRows, foreign_rows, own_rows
from ur5_ros.analysis.data.target_wrench import target_wrenches
from ur5_ros.config import CONTROL_PARAMETERS, complete, load_arm
from ur5_ros.errors import InputError
from ur5_ros.wording import number_of

#: What a run says whose states carry noise.
EXACT_STATES = ('the measured states carry noise; checks and causes are of the exact ones '
                'recorded beside them, ur5 identify uses the measured ones')


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
    bag = first_bag(bags, 'joint_states', ('sim', 'robot', '', 'control'))
    if bag is None:
        why = f' ({(problems or remarks)[0]})' if problems or remarks else ''
        raise InputError(f'{folder}: no joint states in it; nothing can be judged{why}')
    arm, unknown = _with_description(bags, arm, keep_arm, remarks)
    records = _records(
        bags, arm, control_arm, keep_arm,
        {key: value for key, value in (('kp', kp), ('kd', kd)) if value is not None})
    run = replace(_run(folder, bags, bag, records, problems, remarks), described_arm=unknown)
    if run.truth is not None and replace(run, truth=None).noisy:
        run = replace(run, remarks=(*run.remarks, EXACT_STATES))
    run = with_effort_meaning(run, effort)
    return replace(run, reference=given_reference(run, reference)) if reference else run


def _run(folder: Path, bags: list[BagData], bag: BagData,
         records: tuple[NodeRecord | None, NodeRecord | None], problems: list[str],
         remarks: list[str]) -> Run:
    """Return the run in some bags, of which ``bag`` has the states; what is wrong is added."""
    counts: dict[str, int] = {}
    found = _states(bag, bags, counts, problems, remarks)
    stamp, (sim, control) = found.stamp, records
    if len(stamp) < 2:
        raise InputError(f'{folder}: {number_of(len(stamp), "state")}; at least two are needed')
    recorded = reference_of(bags, stamp)
    return Run(
        name=next((each.run for each in bags if each.run), folder.resolve().name),
        stamp=stamp, states=_published(bag, found.states),
        control_rate=float(sim.parameters['control_rate']) if sim else _rate(stamp),
        physics_rate=float(sim.parameters['physics_rate']) if sim else 0.0,
        truth=truth_of(bags, stamp), reference=recorded, parts=parts_of(bags, stamp),
        sim=sim, control=control,
        events=tuple(event for each in bags for event in each.events), counts=counts,
        problems=tuple(problems), remarks=tuple(remarks), dropped=found.dropped,
        jumps=found.jumps, folder=str(folder), current=current_of(bags, stamp),
        temperature=temperature_of(bags, stamp),
        follows_reference=bag.effort == 'target torque' and recorded is not None,
        target_wrenches=tuple(wrench for each in bags if each.node == 'control'
                              for wrench in target_wrenches(each, found.states)),
        **answers_of(bags, bag, found, counts), **contact_of(bags, stamp, sim))


def _with_description(bags: list[BagData], arm: str | None, keep_arm: bool,
                      remarks: list[str]) -> tuple[str | None, str]:
    """
    Return the arm to take, and what a robot description is of where no arm is known.

    ``remarks`` receives what the description says.
    """
    found = None if any(bag.record for bag in bags) else described_arm(bags)
    if found is None:
        return arm, ''
    if found.name and (arm is None or keep_arm):
        remarks.append(found.sentence)
        return found.name, ''
    if arm is None:
        return None, found.sentence
    if arm not in found.names:
        remarks.append(f'{found.sentence}; arm {arm} was taken, as stated')
    return arm, ''


def _records(
    bags: list[BagData], arm: str | None, control_arm: str | None, keep_arm: bool,
    gains: dict[str, list[float]],
) -> tuple[NodeRecord | None, NodeRecord | None]:
    """Return the records of simulator and controller, with the user's arms and gains in them."""
    sim = next((bag.record for bag in bags if bag.node == 'sim'), None)
    control = next((bag.record for bag in bags if bag.node in ('control', 'robot')), None)
    if keep_arm:
        arm, control_arm = (arm if not (sim or control) else None,
                            control_arm if control is None else None)
    control = _control_record(control, control_arm or (arm if sim is None else None), gains)
    if sim is not None and arm is not None:
        sim = replace(sim, arm_name=arm, arm=load_arm(arm))
    return sim, control


def _published(bag: BagData, states: States) -> States:
    """Return the states of a bag with the torque that acted as effort."""
    if bag.node != 'sim' or bag.record is None:
        return states
    return total_effort(states, bag.record.parameters, bag.record.arm)


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
