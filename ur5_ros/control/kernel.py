"""
The torque of every mode in one compiled call, with the checks of state and torque.

One kernel for the controller, for rollouts and for
:func:`~ur5_ros.control.computed_torque.computed_torque`: the same machine code, hence equal bits.
"""

from math import fabs, inf

import numpy as np
from numba import float64

from ur5_ros.model.kernels.base_parameters import SIZE
from ur5_ros.model.kernels.compiled import R1, W2, kernel
from ur5_ros.model.kernels.dynamics import terms_of_state

#: Rows of the output, as :class:`ur5_ros.signals.Torque` has them.
TOTAL, INERTIAL, FEEDBACK, CORIOLIS, GRAVITY = range(5)

#: Modes in which the terms below 1 are M qdd* and C qd, below 2 g; only the first weighs by M.
COMPUTED_TORQUE, IMPEDANCE, GRAVITY_PD, PD = range(4)

#: Bits of the return code: the state is not finite or out of bounds; the torque exceeds the effort
#: limits; it changes faster than allowed; it is not finite.
STATE, EFFORT, RATE, NOT_FINITE = 1, 2, 4, 8

#: Indices of the packed constants: those of the arm, the zero of its angles, KP and KD row by row,
#: lowest and highest position, speed, torque, jump of position, mode, whether g is left out.
OFFSET = SIZE
KP = OFFSET + 6
KD = KP + 36
LOWER = KD + 36
UPPER, SPEED, LARGEST_EFFORT, JUMP = LOWER + 6, LOWER + 12, LOWER + 18, LOWER + 24
MODE, GRAVITY_EXCLUDED = JUMP + 1, JUMP + 2

#: Bounds that all finite numbers keep.
UNBOUNDED = np.concatenate([np.full(6, -np.inf), np.full(19, np.inf)])

#: Rows of the working space: the model's angles, M, C; and its shape.  Rows, because ``reshape``
#: in compiled code loads more of Numba at every start.
ANGLES, INERTIA, VELOCITY, END = 0, 1, 7, 13
WORK = (END, 6)


@kernel(R1, R1, R1, R1, R1, R1, R1, float64, R1, W2, W2, hot=True)
def law(q, qd, q_before, q_ref, qd_ref, qdd_ref, torque_before, largest_change, k, work, torque):
    """Write the rows of ``torque``, (5, 6), and return the bits of what is out of bounds."""
    code, mode, gravity_excluded = 0, k[MODE], k[GRAVITY_EXCLUDED] != 0.0
    for i in range(6):
        # a comparison with NaN is false: what is not finite keeps no bound
        if not (fabs(q[i] - q_before[i]) <= k[JUMP]
                and k[LOWER + i] <= q[i] <= k[UPPER + i]
                and fabs(qd[i]) <= k[SPEED + i]):
            code = STATE
        work[ANGLES, i] = q[i] + k[OFFSET + i]
    m, c = work[INERTIA:VELOCITY], work[VELOCITY:END]
    g, correction = torque[GRAVITY], torque[TOTAL]
    terms_of_state(work[ANGLES], qd, k, m, c, g, 0)
    for i in range(6):
        correction[i] = 0.0
        for j in range(6):
            correction[i] -= (k[KD + 6 * i + j] * (qd[j] - qd_ref[j])
                              + k[KP + 6 * i + j] * (q[j] - q_ref[j]))
    for i in range(6):
        inertial = feedback = coriolis = 0.0
        for j in range(6):
            inertial += m[i, j] * qdd_ref[j]
            feedback += m[i, j] * correction[j]
            coriolis += c[i, j] * qd[j]
        torque[INERTIAL, i] = inertial if mode < GRAVITY_PD else 0.0
        torque[FEEDBACK, i] = feedback if mode == COMPUTED_TORQUE else correction[i]
        torque[CORIOLIS, i] = coriolis if mode < GRAVITY_PD else 0.0
    for i in range(6):
        if mode == PD:
            g[i] = 0.0
        command = torque[INERTIAL, i] + torque[FEEDBACK, i] + torque[CORIOLIS, i]
        whole = command + g[i]
        if not gravity_excluded:
            command = whole
        torque[TOTAL, i] = command
        if not fabs(whole) <= k[LARGEST_EFFORT + i]:
            code |= EFFORT
        if not fabs(command - torque_before[i]) <= largest_change:
            code |= RATE
        if not fabs(whole) < inf:
            code |= NOT_FINITE
    return code


def pack(mode, arm, gains, gravity_excluded, bounds):
    """Return the constants of the kernel; ``bounds`` has 25 numbers, in the order of LOWER on."""
    return np.concatenate([arm.constants, arm.angle_offset, gains.kp.ravel(), gains.kd.ravel(),
                           bounds, [mode, gravity_excluded]])
