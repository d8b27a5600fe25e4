"""The torque of a law computed again from states and references, for every law without memory."""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.laws import Law
from ur5_ros.analysis.residual import CHUNK
from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.laws.cartesian_impedance import impedance_from, limited_inverse
from ur5_ros.model.dynamics import dynamics_terms, gravity_torque, inverse_dynamics
from ur5_ros.model.friction import friction_torque
from ur5_ros.model.kinematics import forward_kinematics, jacobian, jacobian_rate
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.rotations import rotation_vector
from ur5_ros.signals import Reference


def law_torque(run: Run, laws: list[Law], rows: np.ndarray) -> np.ndarray:
    """
    Return the torque of laws without memory for ascending rows, before any limit.

    ``laws``: those in force; each :attr:`~ur5_ros.analysis.laws.Law.without_memory`; ``rows``
    (n,): rows of the run, each of them answered by one of the laws.  Returned: gravity included [N
    m], (n, 6).
    """
    star, arm = run.required_reference, run.required_control.arm
    out = np.empty((len(rows), 6))
    for law in laws:
        begin, end = np.searchsorted(rows, (law.first, law.end))
        for start in range(begin, end, CHUNK):
            these = slice(start, min(start + CHUNK, end))
            some = rows[these]
            q, qd = run.states.q[some], run.states.qd[some]
            reference = Reference(*(part[some] for part in star))
            if law.mode == 'cartesian_impedance':
                out[these] = _tool_torque(q, qd, reference, law, arm, run.target_wrench_at(some))
            else:
                out[these] = _joint_torque(q, qd, reference, law, arm)
            if law.parameters.get('friction_feedforward'):
                load = inverse_dynamics(q + arm.angle_offset, qd, np.zeros(q.shape), arm)
                out[these] += friction_torque(arm.friction, reference.qd, load)
    return out


def _joint_torque(q: np.ndarray, qd: np.ndarray, star: Reference, law: Law,
                  arm: ArmParameters) -> np.ndarray:
    """Return the torque of the laws in joints; Kebria 2016, eq. (11), for computed torque."""
    angles = q + arm.angle_offset
    feedback = -(qd - star.qd) @ law.gains.kd.T - (q - star.q) @ law.gains.kp.T
    if law.mode == 'pd':
        return feedback
    if law.mode == 'gravity_pd':
        return feedback + gravity_torque(angles, arm)
    if law.mode == 'impedance':
        return feedback + inverse_dynamics(angles, qd, star.qdd, arm)
    return inverse_dynamics(angles, qd, star.qdd + feedback, arm)


def _tool_torque(q: np.ndarray, qd: np.ndarray, star: Reference, law: Law, arm: ArmParameters,
                 wrench: np.ndarray) -> np.ndarray:
    """Return the torque of the Cartesian impedance, whose docstring has the equations."""
    given = impedance_from(ControlParameters.of(law.parameters), np.zeros(6))
    angles, desired = q + arm.angle_offset, star.q + arm.angle_offset
    J, J_star = jacobian(angles, arm), jacobian(desired, arm)
    pose, target = forward_kinematics(angles, arm), forward_kinematics(desired, arm)
    turn = rotation_vector(pose[:, :3, :3] @ np.swapaxes(target[:, :3, :3], 1, 2))
    error = np.hstack([pose[:, :3, 3] - target[:, :3, 3], turn])
    speed = _times(J, qd) - _times(J_star, star.qd)
    acceleration = (_times(J_star, star.qdd)
                    + _times(jacobian_rate(desired, star.qd, arm), star.qd)
                    - _times(jacobian_rate(angles, qd, arm), qd))
    axes = np.broadcast_to(np.eye(6), (len(q), 6, 6))
    if given.frame == 'tool':
        axes = np.zeros((len(q), 6, 6))
        axes[:, :3, :3] = axes[:, 3:, 3:] = pose[:, :3, :3]
    back = np.swapaxes(axes, 1, 2)
    force = wrench - _times(axes, _times(back, error) @ given.stiffness.T
                            + _times(back, speed) @ given.damping.T)
    M, C, g = dynamics_terms(angles, qd, arm)
    if given.inertia is None:
        feedback = _times(np.swapaxes(J, 1, 2), force)
    else:
        feedback = np.zeros(q.shape)
        acceleration = acceleration + _times(
            axes, np.linalg.solve(given.inertia, _times(back, force).T).T)
    return _times(M, _times(limited_inverse(J), acceleration)) + _times(C, qd) + g + feedback


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return matrix times vector, row by row."""
    return np.einsum('nij,nj->ni', matrices, vectors)
