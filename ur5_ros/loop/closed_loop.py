"""Plant and law in one process, in a plain for loop: what the two nodes do, without ROS."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis import series
from ur5_ros.analysis.series import Run, Side, States
from ur5_ros.config import load_arm
from ur5_ros.control.controller import Answer, Controller
from ur5_ros.loop.plan import Plan
from ur5_ros.loop.recording import LoopRecording
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference
from ur5_ros.sim.events import Event
from ur5_ros.sim.plant import Plant


class LoopRun(NamedTuple):
    """What a closed loop did, one entry a control period."""

    plan: Plan
    sim_arm: ArmParameters
    control_arm: ArmParameters
    states: list[ArmState]
    """States as measured."""
    truths: list[ArmState] | None
    """Exact states where noise or delay make them differ; None where they do not."""
    answers: list[Answer]
    """The answer to each state; the last one comes when the plant has stopped."""
    events: list[Event]


def run_closed_loop(plan: Plan, folder: Path | None = None) -> LoopRun:
    """
    Run plant and law against each other for the duration of a plan.

    Same states and commands to the last bit as the two nodes in lockstep.

    Parameters
    ----------
    plan : Plan
        Parameters of both sides.
    folder : Path, optional
        Run folder to record into, ``sim`` and ``control`` as the nodes do; nothing is recorded
        if not given.

    Returns
    -------
    LoopRun
        Every state and every answer.

    Raises
    ------
    Refusal
        If a parameter is refused, or the folder exists.

    """
    sim_arm, control_arm = load_arm(plan.sim['arm']), load_arm(plan.control['arm'])
    rate = plan.sim['control_rate']
    controller = Controller(plan.control, rate)
    plant = Plant(sim_arm, plan.sim)
    recording = LoopRecording(plan, folder) if folder is not None else None
    run = LoopRun(plan, sim_arm, control_arm, [], None if plant.exact_sensing else [], [], [])
    try:
        _go_round(plant, controller, run, max(1, round(plan.duration * rate)), recording)
    finally:
        plant.close()
        if recording is not None:
            recording.close('stop_after')
    return run


def _go_round(plant: Plant, controller: Controller, run: LoopRun, last: int,
              recording: LoopRecording | None) -> None:
    step, update = plant.step, controller.update
    keep_state, keep_answer = run.states.append, run.answers.append
    state = plant.state
    for k in range(1, last + 1):
        keep_state(state)
        if run.truths is not None:
            run.truths.append(plant.truth)
        answer = update(state)
        keep_answer(answer)
        if recording is not None:
            recording.period(state, plant.truth, answer, acts=k < last)
        if k < last:
            state = step(answer.torque.total)
            events = plant.drain_events()
            if events:
                _tell(events, run, recording)


def _tell(events: list[Event], run: LoopRun, recording: LoopRecording | None) -> None:
    for event in events:
        run.events.append(event)
        if recording is not None:
            recording.event(event)


def as_run(loop: LoopRun, name: str = 'loop') -> Run:
    """
    Return what the bags of a closed loop would be read as, without bags.

    Parameters
    ----------
    loop : LoopRun
        A finished loop.
    name : str
        What to call it.

    """
    sim, control = loop.plan.sim, loop.plan.control
    return Run(
        name=name,
        stamp=np.array([state.stamp for state in loop.states], dtype=np.int64),
        states=_stacked(loop.states),
        control_rate=float(sim['control_rate']),
        physics_rate=float(sim['physics_rate']),
        truth=None if loop.truths is None else _stacked(loop.truths),
        command=np.array([answer.torque.total for answer in loop.answers]),
        reference=Reference(*(
            np.array([getattr(answer.reference, part) for answer in loop.answers])
            for part in Reference._fields)),
        parts={part: np.array([getattr(answer.torque, part) for answer in loop.answers])
               for part in ('total', *series.PARTS)},
        sim=Side(sim['arm'], loop.sim_arm, sim),
        control=Side(control['arm'], loop.control_arm, control),
        events=tuple(series.Event(event.stamp, event.kind, event.message,
                                  {key: json.loads(value) for key, value in event.values.items()})
                     for event in loop.events),
    )


def _stacked(states: list[ArmState]) -> States:
    return States(*(np.array([state[part] for state in states]) for part in (1, 2, 3)))
