"""Bags to a :class:`~ur5_ros.analysis.data.run.Run`: states, answers and references, by stamp."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.bags import (
    PART_NAMES,
    BagData,
    events_of,
    messages_of,
    open_bags,
)
from ur5_ros.analysis.data.contact import contact_rows, contact_series
from ur5_ros.analysis.data.run import (
    PARTS,
    NodeRecord,
    ParameterChange,
    RecordedEvent,
    Run,
    States,
)
from ur5_ros.bag.arrays.columns import Columns
from ur5_ros.config import CONTROL_PARAMETERS, complete, load_arm
from ur5_ros.errors import InputError
from ur5_ros.signals import Reference

__all__ = ['PARTS', 'ParameterChange', 'RecordedEvent', 'Run', 'NodeRecord', 'States', 'load_run']


def load_run(
    folder: Path | str, arm: str | None = None, control_arm: str | None = None,
    kp: list[float] | None = None, kd: list[float] | None = None,
) -> Run:
    """
    Return the run that a folder of bags holds.

    Parameters
    ----------
    folder : path
        Run folder with ``sim`` and ``control``, one bag folder, or one MCAP file; written by
        this package or by ``ros2 bag record``.
    arm, control_arm : str, optional
        Arms of plant and law, for bags that do not say or to try others.
    kp, kd : list of float, optional
        Gains likewise.

    Returns
    -------
    Run
        As far as every bag is whole; ``problems`` says what is missing.

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
    folder = Path(folder)
    sources, problems = open_bags(folder)
    problems += [problem for source in sources for problem in source.problems]
    stated = _first(sources, 'joint_states', ('sim', 'robot', '', 'control'))
    if stated is None:
        why = f' ({problems[0]})' if problems else ''
        raise InputError(f'{folder}: no joint states in it; nothing can be judged{why}')
    states = stated.data['joint_states']
    sim = next((source.side for source in sources if source.node == 'sim'), None)
    control = next((source.side for source in sources if source.node in ('control', 'robot')),
                   None)
    counts: dict[str, int] = {}
    rows = _unique(states, counts, 'states', problems)
    rows = _finite(states, rows, problems, stated.path)
    rows = _common(sources, states, rows)
    if len(rows) < 2:
        raise InputError(f'{folder}: {len(rows)} states; at least two are needed')
    stamp = states.stamp[rows]
    run = next((source.run for source in sources if source.run), folder.resolve().name)
    rate = float(sim.parameters['control_rate']) if sim else _rate(stamp)
    gains = {key: value for key, value in (('kp', kp), ('kd', kd)) if value is not None}
    known = {'name': run, 'stamp': stamp, 'control_rate': rate, 'folder': str(folder),
             'states': States(*(getattr(states, field)[rows] for field in _FIELDS))}
    answer = _answers(sources, stamp, states, rows, counts)
    star = _reference(sources, stamp)
    return Run(
        **known, **answer, reference=star,
        physics_rate=float(sim.parameters['physics_rate']) if sim else 0.0,
        truth=_truth(sources, stamp), parts=_parts(sources, stamp),
        **_contact(sources, stamp, sim), sim=_sim_side(sim, arm),
        control=_control_record(control, control_arm or (arm if sim is None else None), gains),
        events=tuple(event for source in sources for event in events_of(source)),
        counts=counts, problems=tuple(problems), current=_current(sources, stamp),
        follows_reference=stated.effort == 'target torque' and star is not None)


_FIELDS = ('position', 'velocity', 'effort')


def _first(sources: list[BagData], role: str, order: tuple[str, ...]) -> BagData | None:
    ranked = sorted((source for source in sources if source.has(role)),
                    key=lambda source: order.index(source.node))
    return ranked[0] if ranked else None


def _unique(
    columns: Columns, counts: dict[str, int], what: str, problems: list[str],
) -> np.ndarray:
    """Return the rows of the first message of each stamp, in order of the stamps."""
    stamp = columns.stamp
    counts[f'{what}_back'] = int((np.diff(stamp) < 0).sum())
    if len(stamp) and np.all(np.diff(stamp) > 0):
        counts[f'{what}_copied'] = 0
        return np.arange(len(stamp))
    unique, first, inverse = np.unique(stamp, return_index=True, return_inverse=True)
    counts[f'{what}_copied'] = len(stamp) - len(unique)
    differing = 0
    for field in _FIELDS:
        a, b = columns.fields[field], columns.fields[field][first][inverse]
        differing = max(differing, int((~((a == b) | np.isnan(a) & np.isnan(b))).any(1).sum()))
    if differing:
        problems.append(f'{differing} {what} repeat a stamp with other numbers; two runs or two '
                        'publishers were mixed')
    return first


def _finite(states: Columns, rows: np.ndarray, problems: list[str], path: Path) -> np.ndarray:
    """Return the rows up to the first one that is no number."""
    for field in ('position', 'velocity'):
        if np.isnan(states.fields[field][rows]).all():
            raise InputError(f'{path}: the joint states have no {field}; it is needed')
    good = np.isfinite(np.hstack([states.position[rows], states.velocity[rows]])).all(axis=1)
    effort = states.effort[rows]
    if not np.isnan(effort).all():
        good &= np.isfinite(effort).all(axis=1)
    if good.all():
        return rows
    bad = int(np.argmin(good))
    problems.append(f'{path}: a joint state at {states.stamp[rows[bad]] * 1e-9:.9g} s holds what '
                    'is no number')
    return rows[:bad]


def _common(sources: list[BagData], states: Columns, rows: np.ndarray) -> np.ndarray:
    """Return the rows that every unfinished bag reaches."""
    for source in sources:
        if not source.problems or source.node != 'control':
            continue
        ends = [int(source.data[role].stamp.max()) for role in ('joint_command', 'reference')
                if source.has(role)]
        if ends:
            rows = rows[states.stamp[rows] <= min(ends)]
    return rows


def _rate(stamp: np.ndarray) -> float:
    """Return the rate of states whose bag does not say [Hz]."""
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


def _answers(sources, stamp, states, rows, counts) -> dict:
    """Return command, and wall-clock times of states and commands at the simulator."""
    source = _first(sources, 'joint_command', ('control', 'sim', '', 'robot'))
    if source is None:
        return {}
    commands = source.data['joint_command']
    stamped = commands.stamp > 0
    counts['answers_unstamped'] = int((~stamped).sum())
    if not stamped.any():
        return {}
    counts['answers_without_state'] = int(
        (~np.isin(commands.stamp[stamped], states.stamp)
         & (commands.stamp[stamped] <= stamp[-1])).sum())
    answer = {'command': _aligned(stamp, commands.stamp, commands.effort)}
    heard = _first(sources, 'joint_command', ('sim', 'robot', '', 'control'))
    if heard is not None and heard.has('joint_states'):
        commands, states = heard.data['joint_command'], heard.data['joint_states']
        # Of copies of a state the last one sent is the one that is answered.
        order = np.arange(len(states.stamp))[::-1]
        sent, arrived = np.zeros((2, len(stamp)), dtype=np.int64)
        at, found = _match(stamp, states.stamp[order])
        sent[at] = states.log_time[order][found]
        at, found = _match(stamp, commands.stamp)
        arrived[at] = commands.log_time[found]
        answer.update(state_time=sent, command_time=arrived)
    return answer


def _reference(sources: list[BagData], stamp: np.ndarray) -> Reference | None:
    source = _first(sources, 'reference', ('control', 'robot', '', 'sim'))
    if source is None:
        return None
    columns = source.data['reference']
    fields = columns.fields
    return Reference(*(_aligned(stamp, columns.stamp, fields[name])
                       for name in ('positions', 'velocities', 'accelerations')))


def _truth(sources: list[BagData], stamp: np.ndarray) -> States | None:
    source = _first(sources, 'ground_truth', ('sim', 'robot', '', 'control'))
    if source is None:
        return None
    columns = source.data['ground_truth']
    return States(*(_aligned(stamp, columns.stamp, columns.fields[field]) for field in _FIELDS))


def _parts(sources: list[BagData], stamp: np.ndarray) -> dict[str, np.ndarray]:
    source = _first(sources, 'torque_parts', ('control', 'robot', '', 'sim'))
    if source is None:
        return {}
    columns = source.data['torque_parts']
    values = _aligned(stamp, columns.stamp, columns.effort)
    return {part: values[:, 6 * i:6 * i + 6] for i, part in enumerate(PART_NAMES)}


def _contact(sources: list[BagData], stamp: np.ndarray, sim: NodeRecord | None) -> dict:
    """Return what was felt of the world, where there is one."""
    if sim is None or sim.world.empty:
        return {}
    source = next(source for source in sources if source.node == 'sim')
    rate = float(sim.parameters['physics_rate'])
    steps = round(rate / sim.parameters['control_rate'])
    rows = np.zeros((len(stamp), steps, 6))
    if source.has('contact_effort'):
        columns = source.data['contact_effort']
        rows = contact_rows(stamp, rate, steps, columns.stamp, columns.effort)
    messages = ((role, data) for role in ('contacts', 'objects') if source.has(role)
                for data in messages_of(source.data[role]))
    return {'contact': rows, **contact_series(messages)}


def _current(sources: list[BagData], stamp: np.ndarray) -> np.ndarray | None:
    source = _first(sources, 'motor_current', ('robot', '', 'sim', 'control'))
    if source is None:
        return None
    columns = source.data['motor_current']
    return _aligned(stamp, columns.stamp, columns.effort)


def _sim_side(side: NodeRecord | None, arm: str | None) -> NodeRecord | None:
    if side is None or arm is None:
        return side
    return replace(side, arm_name=arm, arm=load_arm(arm))


def _control_record(
    side: NodeRecord | None, name: str | None, gains: dict[str, list[float]],
) -> NodeRecord | None:
    """Return the controller's record from its bag, with the user's arm and gains in it."""
    if side is None:
        if name is None:
            return None
        given = complete(CONTROL_PARAMETERS, {'arm': name})
        unknown = {} if gains else {'mode': 'unknown'}
        return NodeRecord(name, load_arm(name), given | gains | unknown)
    if name:
        side = replace(side, arm_name=name, arm=load_arm(name))
    changes = tuple(
        change._replace(values={key: value for key, value in change.values.items()
                                if key not in gains}) for change in side.changes)
    return replace(side, parameters={**side.parameters, **gains}, changes=changes)
