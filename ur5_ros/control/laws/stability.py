"""Gains that are stable in continuous time and shake the arm when the torque is held a period."""

import numpy as np

from ur5_ros.config.parameters import HOME
from ur5_ros.control.gains import Gains, sampled_radius
from ur5_ros.errors import InputError
from ur5_ros.model.dynamics import inertia_matrix
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES


def check_sampled(mode: str, gains: Gains, weighed: bool, arm: ArmParameters,
                  control_rate: int) -> None:
    """
    Refuse gains with which the loop, stable in continuous time, shakes itself at this rate.

    A torque held for a period h takes more than the speed it should brake when
    h Kd / M > 2: soon so on a wrist without rotor inertia, in the modes that do not weigh by M.

    ``control_rate``: control periods a second [Hz].
    """
    if weighed:
        radius = sampled_radius(gains, None, 1.0 / control_rate)
        if radius >= 1.0:
            raise InputError(f'kp, kd make the loop unstable when sampled at {control_rate} Hz '
                             f'(spectral radius {radius:.4g}); lower kd below {control_rate} 1/s')
        return
    inertia = home_inertia(arm)
    radius = sampled_radius(gains, inertia, 1.0 / control_rate)
    if radius < 1.0:
        return
    # a torque on one joint alone accelerates it by the inverse of M
    largest = control_rate / np.diag(np.linalg.inv(inertia))
    joint = int((np.diag(gains.kd) / largest).argmax())
    if gains.kd[joint, joint] <= largest[joint]:
        raise InputError(f'mode {mode} sampled at {control_rate} Hz is unstable (spectral radius '
                         f'{radius:.4g}); lower kp')
    raise InputError(
        f'mode {mode} sampled at {control_rate} Hz is unstable: kd of {JOINT_NAMES[joint]} is '
        f'{gains.kd[joint, joint]:g} N m s/rad; for arm {arm.name} give at most about '
        f'[{", ".join(map(_two_digits, largest))}]')


def check_integral(mode: str, gains: Gains, ki: np.ndarray, inertia: np.ndarray,
                   control_rate: int) -> None:
    """
    Refuse an integral gain with which M e'' + Kd e' + Kp e + Ki int e = 0 is not stable.

    ``ki`` (6, 6): integral gain; ``inertia`` (6, 6): M where the law does not weigh by it; the
    unit matrix where it does; ``control_rate``: control periods a second [Hz].
    """
    slowest = float(np.linalg.eigvals(_companion(gains, ki, inertia)).real.max())
    if slowest >= 0.0:
        raise InputError(f'mode {mode}: with ki the error equation has a pole with real part '
                         f'{slowest:.4g}; all must be negative (Routh-Hurwitz): lower ki, or '
                         'raise kp or kd')
    radius = integral_radius(gains, ki, inertia, 1.0 / control_rate)
    if radius >= 1.0:
        raise InputError(f'mode {mode} sampled at {control_rate} Hz is unstable (spectral radius '
                         f'{radius:.4g}); lower ki, kp or kd')


def integral_radius(gains: Gains, ki: np.ndarray, inertia: np.ndarray, period: float) -> float:
    """Return the spectral radius of that equation sampled as the loop is; below 1 is stable."""
    weight, unit, zero = np.linalg.inv(inertia), np.eye(6), np.zeros((6, 6))
    # rows: position error, its rate, its integral; the integral of a state includes its error
    rate = np.hstack([-period * weight @ gains.kp, unit - period * weight @ gains.kd,
                      -period * weight @ ki])
    position = np.hstack([unit, zero, zero]) + period * rate
    integral = np.hstack([zero, zero, unit]) + period * position
    return float(np.abs(np.linalg.eigvals(np.vstack([position, rate, integral]))).max())


def home_inertia(arm: ArmParameters) -> np.ndarray:
    """Return M where the arm stands at home [kg m^2]."""
    return inertia_matrix(np.array(HOME) + arm.angle_offset, arm)


def _companion(gains: Gains, ki: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    zero, unit = np.zeros((6, 6)), np.eye(6)
    return np.block([[zero, unit, zero],
                     [-np.linalg.solve(inertia, part) for part in (gains.kp, gains.kd, ki)],
                     [unit, zero, zero]])


def _two_digits(value: float) -> str:
    return np.format_float_positional(value, 2, fractional=False, trim='-')
