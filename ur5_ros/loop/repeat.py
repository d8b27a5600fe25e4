"""A recording repeated: its commands into a new plant, its states into the law; the same bits?"""

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import NodeRecord, RecordedEvent, Run, States, total_effort
from ur5_ros.bag.fingerprint import fingerprint
from ur5_ros.control.controller import Controller
from ur5_ros.errors import InputError
from ur5_ros.signals import JOINT_NAMES, ArmState
from ur5_ros.sim.plant import Plant

#: Within this two runs are the same on machines of different fingerprints.
TOLERANCE = 1e-9
#: Parameters with which a command is the torque that acts.
PLAIN_COMMANDS = {
    'effort_convention': 'total', 'delay.command_periods': 0, 'leave_torque_mode': False,
    'torque_limit': [], 'torque_rate_limit': 0.0,
    'friction_compensation.viscous_scale': [0.0] * 6,
    'friction_compensation.coulomb_scale': [0.0] * 6}


class Repetition(NamedTuple):
    """How a repetition compares with its recording."""

    what: str
    """What was compared: states or commands."""
    fed: str
    """What was fed in."""
    compared: int
    """How many messages."""
    different: int
    """How many of them differ in any bit."""
    first_stamp: int | None
    """Stamp of the first one that differs [ns]."""
    first_joint: str
    """Joint of the largest difference in it."""
    largest: float
    """Largest difference of all [rad, rad/s or N m]."""
    same_machine: bool | None
    """Whether the recording names this machine's fingerprint; None where it names none."""

    @property
    def equal(self) -> bool:
        """Whether every bit is the same."""
        return self.different == 0

    @property
    def sentence(self) -> str:
        """The finding in words."""
        if self.first_stamp is None:
            return f'{self.compared} {self.what} equal to the last bit ({self.fed})'
        close = 'within' if self.largest <= TOLERANCE else 'beyond'
        machine = {True: 'the recording is of a machine like this one',
                   False: 'the recording is of another kind of machine',
                   None: 'the recording names no machine'}[self.same_machine]
        return (f'{self.different} of {self.compared} {self.what} differ, first at '
                f'{self.first_stamp * 1e-9:.9g} s ({self.first_joint}), by at most '
                f'{self.largest:.3g}, {close} {TOLERANCE:g} ({self.fed}; {machine})')


def resimulate(run: Run) -> Repetition:
    """
    Play the recorded commands into a new plant and compare its states with the recorded ones.

    Where states were left without a stamped answer (unstamped commands, paced runs, the fallback),
    the torque that acted is played instead: the effort of the following state.
    """
    side = _side(run, run.sim, 'simulator')
    whole = np.diff(run.stamp) > 1.5e9 / run.control_rate
    if whole.any():
        raise InputError(f'{run.name}: a gap after {run.stamp[np.argmax(whole)] * 1e-9:.9g} s; '
                         'only a recording without gaps can be repeated')
    given = dict(side.parameters) | {'gui': False}
    commands, fed = run.command, 'fed with the commands'
    by_command = bool(side.parameters['lockstep'] and commands is not None
                      and np.isfinite(commands[:-1]).all())
    if commands is None or not by_command:
        given |= PLAIN_COMMANDS
        commands = np.vstack([run.exact.effort[1:], np.zeros((1, 6))])
        fed = 'fed with the torques that acted'
    plant = Plant(side.arm, given)
    try:
        found = _replayed_states(plant, run, commands, by_command)
    finally:
        plant.close()
    states = total_effort(States(*np.split(found, 3, axis=1)), side.parameters, side.arm)
    return _compared('states', fed, run.stamp, np.hstack(run.states), np.hstack(states), side)


def recontrol(run: Run) -> Repetition:
    """Play the recorded states into the law and compare its commands with the recorded ones."""
    side = _side(run, run.control, 'controller')
    if run.command is None:
        raise InputError(f'{run.name}: no command is recorded; nothing to compare with')
    law = Controller(side.arm, side.parameters, round(run.control_rate))
    found = np.full_like(run.command, np.nan)
    changes = list(side.changes)
    for k, stamp in enumerate(run.stamp):
        while changes and changes[0].stamp < stamp:
            law.change(changes.pop(0).values)
        answer = law.update(ArmState(int(stamp), run.states.q[k], run.states.qd[k],
                                     run.states.effort[k]))
        found[k] = answer.torque.total
    known = np.isfinite(run.command).all(axis=1)
    return _compared('commands', 'fed with the states', run.stamp[known], run.command[known],
                     found[known], side)


def _side(run: Run, side: NodeRecord | None, what: str) -> NodeRecord:
    if side is None or not side.parameters:
        raise InputError(f'{run.name}: the {what} did not record; give a run of ur5_ros with '
                         'its bag')
    return side


def _replayed_states(plant: Plant, run: Run, commands: np.ndarray, by_command: bool) -> np.ndarray:
    events: dict[int, list[RecordedEvent]] = defaultdict(list)
    for event in run.events:
        events[event.stamp].append(event)
    found = np.full((len(run.stamp), 18), np.nan)
    state = plant.state
    for k, stamp in enumerate(run.stamp):
        found[k] = np.concatenate(state[1:])
        for event in events[int(stamp)]:
            _apply_event(plant, event, by_command)
        if k + 1 == len(run.stamp):
            break
        if any(event.kind == 'reset' for event in events[int(run.stamp[k + 1])]):
            state = plant.reset()
        else:
            state = plant.step(commands[k])
    return found


def _apply_event(plant: Plant, event: RecordedEvent, by_command: bool) -> None:
    if event.kind == 'parameter':
        name = event.values['name']
        if by_command or name not in PLAIN_COMMANDS:
            plant.change(name, event.values['value'])
    elif event.kind == 'wrench':
        plant.apply_wrench(event.values['force'], event.values['torque'])


def _compared(what: str, fed: str, stamp: np.ndarray, recorded: np.ndarray, found: np.ndarray,
              side: NodeRecord) -> Repetition:
    differs = (recorded.view(np.uint64) != found.view(np.uint64)).any(axis=1)
    first = int(np.argmax(differs)) if differs.any() else None
    difference = np.abs(recorded - found)
    return Repetition(
        what, fed, len(stamp), int(differs.sum()),
        None if first is None else int(stamp[first]),
        '' if first is None else JOINT_NAMES[int(np.argmax(difference[first])) % 6],
        float(difference.max(initial=0.0)),
        dict(side.fingerprint) == fingerprint() if side.fingerprint else None)
