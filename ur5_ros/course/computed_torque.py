"""Exercise: the computed-torque law as a controller that answers states."""

from typing import Any

import numpy as np

from ur5_ros.config import load_arm
from ur5_ros.control.computed_torque import computed_torque
from ur5_ros.control.gains import Gains
from ur5_ros.course.exercise import Exercise, Line, WrongAnswer, checked, compare
from ur5_ros.course.kinematics import configurations
from ur5_ros.signals import ArmState, Reference
from ur5_ros.sim.plant import Plant

ARM = load_arm('ur5')
KP, KD = 100.0, 20.0
_GAINS = Gains(KP * np.eye(6), KD * np.eye(6))
_ZERO = np.zeros(6)


def respond(controller: Any, state: ArmState, reference: Reference) -> tuple[int, np.ndarray]:
    """Return stamp and torque with which a controller of the solution answers a state."""
    given = controller.update(state.stamp, state.q.copy(), state.qd.copy(),
                              *(part.copy() for part in reference))
    try:
        stamp, torque = given
    except (TypeError, ValueError):
        raise WrongAnswer('update returns no pair of stamp and torque') from None
    return int(checked('update as its stamp', stamp, ())), checked(
        'update as its torque', torque, (6,))


def make(module: Any) -> Any:
    """Return a controller of the solution."""
    if not isinstance(getattr(module, 'Controller', None), type):
        raise WrongAnswer('there is no class Controller')
    return module.Controller()


def questions(random: np.random.Generator, count: int = 6) -> list[tuple[ArmState, Reference]]:
    """Return states in a row with references near them."""
    found = []
    for k, q in enumerate(configurations(random, count)):
        qd, e, rate, qdd = random.uniform(-0.5, 0.5, (4, 6))
        found.append((ArmState((k + 1) * 1_000_000, q, qd, _ZERO),
                      Reference(q - e, qd - rate, qdd)))
    return found


def _torque(module: Any, random: np.random.Generator) -> tuple[str, str]:
    asked, controller = questions(random), make(module)
    got = np.array([respond(controller, *each)[1] for each in asked])
    right = [computed_torque(state, reference, ARM, _GAINS) for state, reference in asked]
    total, gravity, feedback = (np.array([getattr(each, name) for each in right])
                                for name in ('total', 'gravity', 'feedback'))
    if np.allclose(got[1:], total[:-1], atol=1e-5):
        return 'each torque is the answer to the state before', 'torque a period late'
    plain = np.array([
        -KP * (state.q - reference.q) - KD * (state.qd - reference.qd)
        + each.inertial + each.coriolis + each.gravity
        for (state, reference), each in zip(asked, right, strict=True)])
    return compare('the torque [N m]', got, total, {
        "gravity's sign": total - 2.0 * gravity, 'no gravity': total - gravity,
        "the error's sign": total - 2.0 * feedback,
        'the feedback is not weighed by M': plain}, 1e-5)


def _stamp(module: Any, random: np.random.Generator) -> tuple[str, str]:
    controller = make(module)
    for state, reference in questions(random):
        stamp = respond(controller, state, reference)[0]
        if stamp != state.stamp:
            return (f'the answer to the state of {state.stamp} ns carries {stamp}',
                    'wrong stamp: it is that of the state answered')
    return '', ''


def _loop(module: Any, random: np.random.Generator) -> tuple[str, str]:
    """The arm of PyBullet follows sines from an error at the start, by eq. (12)."""
    middle = np.array([0.0, -1.4, 1.4, -1.5, -1.4, 0.2])
    size, speed = random.uniform(0.05, 0.2, 6), random.uniform(1.0, 3.0, 6)
    start_error = random.uniform(-0.05, 0.05, 6)
    plant = Plant(ARM, {'initial_positions': (middle + start_error).tolist(),
                        'initial_velocities': (size * speed).tolist()})
    controller, errors = make(module), []
    try:
        for k in range(600):
            now, state = k * 1e-3, plant.state
            reference = Reference(middle + size * np.sin(speed * now),
                                  size * speed * np.cos(speed * now),
                                  -size * speed**2 * np.sin(speed * now))
            torque = respond(controller, state, reference)[1]
            errors.append(state.q - reference.q)
            plant.step(np.clip(torque, -1e4, 1e4))
    finally:
        plant.close()
    t = 1e-3 * np.arange(600)[:, None]
    promised = start_error * (1.0 + 10.0 * t) * np.exp(-10.0 * t)  # both poles at -10 / s
    far = float(np.abs(np.array(errors) - promised).max())
    return ('', '') if far < 2e-3 else (
        f'the error differs from the solution of eq. (12) by up to {far:.3g} rad', '')


EXERCISE = Exercise('computed_torque', (
    Line('torque', 4.0, _torque), Line('stamp', 2.0, _stamp), Line('closed loop', 4.0, _loop)))
