"""A right solution."""

from ur5_ros import dynamics_terms, load_arm

ARM = load_arm('ur5')
KP, KD = 100.0, 20.0


class Controller:
    def update(self, stamp, q, qd, q_ref, qd_ref, qdd_ref):
        M, C, g = dynamics_terms(q, qd, ARM)
        a = qdd_ref - KD * (qd - qd_ref) - KP * (q - q_ref)
        return stamp, M @ a + C @ qd + g
