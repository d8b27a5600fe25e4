"""
The paper's law, eq (11), compiled, with the checks that tell an ordinary period from others.

One kernel for the controller, for loops without ROS and for :func:`computed_torque`: one set of
machine code, hence the same bits.
"""

from math import fabs

import numpy as np

from ur5_ros.model.kernels.compiled import R1, R2, W2, kernel
from ur5_ros.model.kernels.dynamics import terms_of_state
from ur5_ros.model.kernels.lanes import put

#: Rows of the output, as :class:`ur5_ros.signals.Torque` has them.
TOTAL, INERTIAL, FEEDBACK, CORIOLIS, GRAVITY = range(5)

#: Where the bounds stand: lowest and highest position, speed, torque, jump of position.
LOWER, UPPER, SPEED, EFFORT, JUMP, BOUNDS = 0, 6, 12, 18, 24, 25

#: Bounds that everything finite keeps.
UNBOUNDED = np.concatenate([np.full(6, -np.inf), np.full(19, np.inf)])

#: Rows of the working space: the model's angles, M, C; and its shape.  Rows, as ``reshape`` in
#: compiled code loads more of Numba at every start.
ANGLES, INERTIA, VELOCITY, END = 0, 1, 7, 13
WORK = (END, 6)


@kernel(R1, R1, R1, R1, R1, R1, R1, R1, R2, R2, R1, W2, W2)
def law(q, qd, q_before, q_wanted, qd_wanted, qdd_wanted, k, offset, kp, kd, bounds, work, torque):
    """
    Write M qdd*, M (-Kd e' - Kp e), C qd, g and their sum as rows of ``torque``, (5, 6).

    Returns 0 if state and torque keep all bounds; otherwise 1, and the torque may be unwritten.
    """
    for i in range(6):
        # a comparison with NaN is false: what is not finite keeps no bound
        if not (fabs(q[i] - q_before[i]) <= bounds[JUMP]
                and bounds[LOWER + i] <= q[i] <= bounds[UPPER + i]
                and fabs(qd[i]) <= bounds[SPEED + i]):
            return 1
        work[ANGLES, i] = q[i] + offset[i]
    m, c = work[INERTIA:VELOCITY], work[VELOCITY:END]
    g, correction = torque[GRAVITY], torque[TOTAL]
    terms_of_state(work[ANGLES], qd, k, m, c, g, 0, np.intp(1), put)
    for i in range(6):
        correction[i] = 0.0
        for j in range(6):
            correction[i] -= (kd[i, j] * (qd[j] - qd_wanted[j])
                              + kp[i, j] * (q[j] - q_wanted[j]))
    for i in range(6):
        inertial = feedback = coriolis = 0.0
        for j in range(6):
            inertial += m[i, j] * qdd_wanted[j]
            feedback += m[i, j] * correction[j]
            coriolis += c[i, j] * qd[j]
        torque[INERTIAL, i] = inertial
        torque[FEEDBACK, i] = feedback
        torque[CORIOLIS, i] = coriolis
    kept = True
    for i in range(6):
        total = torque[INERTIAL, i] + torque[FEEDBACK, i] + torque[CORIOLIS, i] + g[i]
        torque[TOTAL, i] = total
        kept &= fabs(total) <= bounds[EFFORT + i]
    return 0 if kept else 1
