"""The sums of eq (11), compiled: at a thousand states a second NumPy's calls would cost most."""

from ur5_ros.model.compiled import R1, R2, W2, kernel

#: Rows of the output, as :class:`ur5_ros.signals.Torque` has them.
TOTAL, INERTIAL, FEEDBACK, CORIOLIS, GRAVITY = range(5)


@kernel(R2, R2, R1, R1, R1, R1, R1, R1, R2, R2, W2)
def parts(m, c, g, q, qd, q_wanted, qd_wanted, qdd_wanted, kp, kd, torque):
    """Write M qdd*, M (-Kd e' - Kp e), C qd, g and their sum as rows of ``torque`` (5, 6)."""
    for i in range(6):
        correction = 0.0
        for j in range(6):
            correction -= kd[i, j] * (qd[j] - qd_wanted[j]) + kp[i, j] * (q[j] - q_wanted[j])
        torque[GRAVITY, i] = correction
    for i in range(6):
        inertial = feedback = coriolis = 0.0
        for j in range(6):
            inertial += m[i, j] * qdd_wanted[j]
            feedback += m[i, j] * torque[GRAVITY, j]
            coriolis += c[i, j] * qd[j]
        torque[INERTIAL, i] = inertial
        torque[FEEDBACK, i] = feedback
        torque[CORIOLIS, i] = coriolis
        torque[TOTAL, i] = inertial + feedback + coriolis + g[i]
    for i in range(6):
        torque[GRAVITY, i] = g[i]
    return 0
