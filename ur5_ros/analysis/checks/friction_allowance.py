"""What friction of joints at rest may do to a force at the tool: stated beside a figure."""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.config.experiments import Figure
from ur5_ros.config.friction import joint_friction
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.friction import friction_terms
from ur5_ros.model.kinematics import jacobian

#: Rows of a window that are looked at, at most.
ROWS = 200

#: Joint speed that counts as rest [rad/s].
AT_REST = 1e-3


def friction_allowance(run: Run, rows: np.ndarray, figure: Figure, value: float,
                       force: np.ndarray) -> float:
    """
    Return by how much friction of joints at rest may move a figure; 0 where it cannot.

    Friction f of a joint at rest is anything up to its dry friction, so that a force at the tool
    is off by up to J^-T f, and a static stiffness by that force over the deflection.  Friction in
    motion is not excused: a law can feed it forward.

    Parameters
    ----------
    run : Run
        A recording.
    rows : numpy.ndarray, shape (n,)
        The window of the figure.
    figure : Figure
        What the experiment names.
    value : float
        What the run gave.
    force : numpy.ndarray, shape (3,)
        Mean force at the tool, in base [N].

    """
    if figure.quantity not in ('normal_force', 'stiffness'):
        return 0.0
    axis = 'xyz'.index(figure.axis)
    held = _held_force(run, rows[::max(1, len(rows) // ROWS)])[axis]
    if figure.quantity == 'normal_force':
        return held
    return abs(value) * held / abs(float(force[axis])) if force[axis] else 0.0


def _held_force(run: Run, rows: np.ndarray) -> list[float]:
    """Return the force that friction may hold along x, y and z of base, its mean [N]."""
    sim = run.required_sim
    friction = joint_friction(sim.parameters)
    if friction.none:
        return [0.0] * 3
    q, qd = run.exact.q[rows] + sim.arm.angle_offset, run.exact.qd[rows]
    load = inverse_dynamics(q, qd, np.zeros(q.shape), sim.arm)
    _, level, offset = friction_terms(friction, np.zeros(q.shape), load)
    torque = np.where(np.abs(qd) < AT_REST, level + np.abs(offset), 0.0)
    lever = np.abs(np.linalg.inv(np.swapaxes(jacobian(q, sim.arm), 1, 2)))[:, :3]
    return (np.einsum('nij,nj->i', lever, torque) / len(rows)).tolist()
