"""Cartesian impedance: the tool yields like a mass on a spring and a damper, in six directions."""

from typing import NamedTuple

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.config.parameters import HOME
from ur5_ros.control.gains import Gains, definite_matrix, sampled_radius
from ur5_ros.control.laws import impedance_kernel as kernel
from ur5_ros.control.laws.law import Law
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.kinematics import forward_kinematics, jacobian
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

#: Singular value of J below which its inverse is limited (m and rad taken alike); the
#: inverse then multiplies a tool velocity by 1 / (2 SMALLEST_SINGULAR_VALUE) at most.
SMALLEST_SINGULAR_VALUE = 0.05


class Impedance(NamedTuple):
    """What the tool is asked to feel like."""

    stiffness: np.ndarray
    """K, shape (6, 6): [N/m] for the first three axes, [N m/rad] for the others."""
    damping: np.ndarray
    """D, shape (6, 6) [N s/m], [N m s/rad]."""
    inertia: np.ndarray | None
    """M_x, shape (6, 6) [kg], [kg m^2]; None = the inertia that the tool has."""
    frame: str
    """Axes of the three: ``base`` or ``tool``."""
    wrench: np.ndarray
    """Desired force [N] and torque [N m] of the tool on its surroundings, in base, shape (6,)."""


def limited_inverse(J: np.ndarray) -> np.ndarray:
    """Return J^-1 (..., 6, 6); near a singularity s/(s^2 + d^2) replaces 1/s (damped)."""
    U, s, Vt = np.linalg.svd(J)
    damping = np.where(s < SMALLEST_SINGULAR_VALUE, SMALLEST_SINGULAR_VALUE**2 - s**2, 0.0)
    return np.swapaxes(Vt, -1, -2) @ ((s / (s**2 + damping))[..., None]
                                      * np.swapaxes(U, -1, -2))


def inverse_is_limited(q: np.ndarray, arm: ArmParameters) -> bool:
    """Return whether :func:`limited_inverse` differs from J^-1 at ``q``, manufacturer's angles."""
    values = np.linalg.svd(jacobian(q + arm.angle_offset, arm), compute_uv=False)
    return bool(values[-1] < SMALLEST_SINGULAR_VALUE)


class CartesianImpedance(Law):
    r"""
    The law with its constants.

    The reference of the joints is that of the tool by forward kinematics.  With
    :math:`e = (p - p^*, \log R R^{*T})` and :math:`F = w - K e - D \dot e`:

    .. math::

        \tau &= M J^+ (a^* - \dot J \dot q) + C \dot q + g + J^T F \\
        \tau &= M J^+ (a^* - \dot J \dot q + M_x^{-1} F) + C \dot q + g

    without and with M_x.  The tool then answers a contact wrench w_c as
    :math:`\Lambda \ddot e + D \dot e + K e = w + w_c`, or
    :math:`M_x \ddot e + D \dot e + K e = w + M_x \Lambda^{-1} w_c`: shaping the inertia leaves
    the stiffness felt at rest changed, as w_c is not measured (Hogan 1985; Ott 2008, chapter 3).

    """

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        impedance = self._impedance = impedance_from(parameters, self.target_wrench)
        inertia = impedance.inertia
        self._softness = np.zeros((6, 6)) if inertia is None else np.linalg.inv(inertia)
        self._constants = np.concatenate([arm.constants, arm.angle_offset])
        self._inverse, self._work = np.empty((6, 6)), np.empty((kernel.WORK, 6))
        kernel.impedance_torque.prepare()

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse an impedance that is unstable when sampled; KP and KD have no part in it."""
        check_sampled_impedance(impedance_from(parameters, cls.target_wrench), arm, control_rate)

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return the torque; ``feedback`` is what impedance and desired wrench take [N m]."""
        impedance, arm, torque = self._impedance, self.arm, np.empty((5, 6))
        switches = np.array([impedance.frame == 'tool', impedance.inertia is not None,
                             1.0 / SMALLEST_SINGULAR_VALUE], dtype=float)
        arrays = (state.q, state.qd, *reference, self._constants, impedance.stiffness,
                  impedance.damping, self._softness, self.target_wrench, switches, self._inverse,
                  self._work, torque)
        if kernel.impedance_torque.run(1, [], arrays, []):  # near a singularity
            self._inverse[:] = limited_inverse(jacobian(state.q + arm.angle_offset, arm))
            switches[2] = 0.0
            kernel.impedance_torque.run(1, [], arrays, [])
        return Torque(*torque)


def impedance_from(parameters: ControlParameters, wrench: np.ndarray) -> Impedance:
    """Return the impedance of the parameters, with a desired wrench [N], [N m] in base."""
    given = parameters.impedance_inertia
    return Impedance(
        definite_matrix('impedance.stiffness', parameters.impedance_stiffness),
        definite_matrix('impedance.damping', parameters.impedance_damping),
        definite_matrix('impedance.inertia', given) if given else None,
        parameters.impedance_frame, wrench)


def check_sampled_impedance(impedance: Impedance, arm: ArmParameters, control_rate: int) -> None:
    """
    Refuse an impedance that shakes the arm when its torque is held for a control period.

    Judged where the arm stands in ``HOME``, as for the joint laws.
    """
    home = np.array(HOME) + arm.angle_offset
    J, M = jacobian(home, arm), dynamics_terms(home, np.zeros(6), arm)[0]
    turn = np.kron(np.eye(2), forward_kinematics(home, arm)[:3, :3])
    turn = turn if impedance.frame == 'tool' else np.eye(6)
    along = turn.T @ J  # from joint speeds to the axes of the impedance
    inertia = np.linalg.inv(along @ np.linalg.solve(M, along.T))
    if impedance.inertia is not None:
        inertia = impedance.inertia
    radius = sampled_radius(Gains(impedance.stiffness, impedance.damping), inertia,
                            1.0 / control_rate)
    if radius < 1.0:
        return
    largest = control_rate / np.diag(np.linalg.inv(inertia))
    axis = int((np.diag(impedance.damping) / largest).argmax())
    raise InputError(
        f'mode cartesian_impedance sampled at {control_rate} Hz is unstable (spectral radius '
        f'{radius:.4g}), most of all {_DIRECTIONS[axis]}: damping is '
        f'{impedance.damping[axis, axis]:g}; for arm {arm.name} give less than about '
        f'{largest[axis]:.2g}, or lower the stiffness')


_DIRECTIONS = ('along x', 'along y', 'along z', 'about x', 'about y', 'about z')
