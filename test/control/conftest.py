import numpy as np
import pytest
from hypothesis import settings

from ur5_ros.config import load_arm
from ur5_ros.control.controller import controller_from_parameters
from ur5_ros.model.dynamics import forward_dynamics
from ur5_ros.signals import ArmState, stamp_of_period

# the first example of a kind may compile a kernel
settings.register_profile('control', deadline=None)
settings.load_profile('control')


class ExactArm:
    """The plant that the equations describe: forward dynamics and semi-implicit Euler."""

    def __init__(self, arm, rate, q, qd=None):
        self.arm, self.rate, self.k = arm, rate, 1
        self.q, self.qd = np.array(q, dtype=float), np.zeros(6) if qd is None else np.array(qd)
        self.effort = np.zeros(6)

    @property
    def state(self):
        stamp = stamp_of_period(self.k, self.rate)
        return ArmState(stamp, self.q.copy(), self.qd.copy(), self.effort)

    def step(self, torque):
        qdd = forward_dynamics(self.q + self.arm.angle_offset, self.qd, torque, self.arm)
        self.qd = self.qd + qdd / self.rate
        self.q = self.q + self.qd / self.rate
        self.effort = torque
        self.k += 1


class Run:
    """What happened, a row a period."""

    def __init__(self, answers, states):
        self.q = np.array([state.q for state in states])
        self.qd = np.array([state.qd for state in states])
        self.reference = np.array([answer.reference.q for answer in answers])
        self.reference_qd = np.array([answer.reference.qd for answer in answers])
        self.reference_qdd = np.array([answer.reference.qdd for answer in answers])
        self.torque = np.array([answer.torque.total for answer in answers])
        self.status = [answer.status for answer in answers]
        self.limited = [answer.limited for answer in answers]
        self.error = self.q - self.reference


def go(controller, plant, periods):
    """Close the loop for some periods."""
    answers, states = [], []
    for _ in range(periods):
        state = plant.state
        answer = controller.update(state)
        answers.append(answer)
        states.append(state)
        plant.step(answer.torque.total)
    return Run(answers, states)


@pytest.fixture(scope='session')
def ur5():
    return load_arm('ur5')


@pytest.fixture
def close_loop():
    return go


@pytest.fixture
def exact_arm():
    return ExactArm


@pytest.fixture
def holding(ur5):
    """Return a controller that holds an arm, and the arm, after its first period."""

    def make(q, rate=500, **parameters):
        controller = controller_from_parameters({name.replace('__', '.'): value
                                 for name, value in parameters.items()}, rate)
        plant = ExactArm(controller.arm, rate, q)
        go(controller, plant, 1)
        return controller, plant

    return make
