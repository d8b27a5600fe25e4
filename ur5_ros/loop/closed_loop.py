"""Plant and law in one process, in a plain for loop: what the two nodes do, without ROS."""

from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.run import States
from ur5_ros.control.controller import Controller
from ur5_ros.loop.loop_run import LoopRun
from ur5_ros.loop.recording import record
from ur5_ros.loop.rollout import rollout
from ur5_ros.loop.run_config import RunConfig, arm_named
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference
from ur5_ros.sim.plant import Plant
from ur5_ros.sim.world.publication import ContactPublication


def run_closed_loop(config: RunConfig, folder: Path | str | None = None) -> LoopRun:
    """
    Run plant and law against each other for the duration of a configuration.

    Same states and commands to the last bit as the two nodes in lockstep.

    Parameters
    ----------
    config : RunConfig
        Parameters of both sides.
    folder : path, optional
        Run folder to record into, ``sim`` and ``control`` as the nodes do; nothing is recorded
        if not given.

    Returns
    -------
    LoopRun
        Every state and every answer.

    Raises
    ------
    InputError
        If a parameter is refused, or the folder exists.

    Examples
    --------
    >>> from ur5_ros import load_run, run_closed_loop, run_config, validate
    >>> run = run_closed_loop(run_config('joint_step', duration=0.5), folder='step')
    >>> run.q.shape
    (500, 6)
    >>> validate(load_run('step')).verdict
    'pass'

    """
    run = rollout(config) or full_loop(config)
    if folder is not None:
        record(run, Path(folder))
    return run


def full_loop(config: RunConfig, sim_arm: ArmParameters | None = None,
              control_arm: ArmParameters | None = None) -> LoopRun:
    """Run Plant and Controller as the nodes run them; with other arms if given."""
    sim_arm = sim_arm or arm_named(config.sim.arm)
    control_arm = control_arm or arm_named(config.control.arm)
    controller = Controller(control_arm, config.control, config.sim.control_rate)
    plant = Plant(sim_arm, config.sim)
    states, truths, answers, events = [], [], [], []
    contact, reports = [], []
    publication = None if plant.mechanics.world is None else ContactPublication(config.sim)
    nothing = np.zeros((config.sim.physics_rate // config.sim.control_rate, 6))
    try:
        state = plant.state
        for k in range(1, config.periods + 1):
            states.append(state)
            truths.append(plant.truth)
            answer = controller.update(state)
            answers.append(answer)
            if publication is not None:
                torques = [torque for _, torque in plant.contact_effort()]
                contact.append(torques or nothing)
                reports.append(publication.messages(plant))
            if k < config.periods:
                state = plant.step(answer.torque.total)
                events += plant.drain_events()
        exact = plant.exact_sensing
    finally:
        plant.close()
    return LoopRun(
        config, sim_arm, controller.arm, np.array([state.stamp for state in states]),
        *_stacked(states), None if exact else _stacked(truths),
        np.array([answer.torque for answer in answers]),
        Reference(*np.moveaxis(np.array([answer.reference for answer in answers]), 1, 0)),
        tuple(events), np.array(contact) if contact else None, tuple(reports))


def _stacked(states: list[ArmState]) -> States:
    return States(*(np.array([state[part] for state in states]) for part in (1, 2, 3)))
