"""Functions of time with two derivatives: ramps, waves, and where the tool should be."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5_ros.config.experiments import Axis, JointWaves, ToolCircle, ToolWaves, Wave
from ur5_ros.model.rotations import rotation_of_rpy
from ur5_ros.signals import JOINT_NAMES, Reference

_AXES: tuple[Axis, ...] = ('x', 'y', 'z')


class Curve(NamedTuple):
    """A quantity along time and its derivatives, each of shape (n,)."""

    value: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray


class ToolSamples(NamedTuple):
    """Where the tool should be, how it should move, in ``base``."""

    pose: np.ndarray
    """Poses, shape (n, 4, 4)."""
    twist: np.ndarray
    """Velocity [m/s] of the tool origin, angular velocity [rad/s], shape (n, 6)."""
    twist_rate: np.ndarray
    """Their time derivatives [m/s^2, rad/s^2], shape (n, 6)."""


def quintic_rise(t: np.ndarray, duration: float) -> Curve:
    """
    Return x^3 (10 - 15 x + 6 x^2), x = t / duration held within 0 and 1: C2, at rest at both ends.

    ``t`` (n,): times [s]; ``duration``: length of the rise [s]; zero = already risen.
    """
    if duration == 0.0:
        return Curve(np.ones_like(t), np.zeros_like(t), np.zeros_like(t))
    x = np.clip(t / duration, 0.0, 1.0)
    return Curve(
        x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
        30.0 * x * x * (1.0 - x) * (1.0 - x) / duration,
        60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (duration * duration),
    )


def window(t: np.ndarray, duration: float, ramp: float, ramp_down: float) -> Curve:
    """
    Return the weight that rises over ``ramp`` and falls over the last ``ramp_down`` seconds.

    ``t`` (n,): times [s].
    """
    up = quintic_rise(t, ramp)
    if ramp_down == 0.0:
        return up
    fall = quintic_rise(t - (duration - ramp_down), ramp_down)
    return _product(up, Curve(1.0 - fall.value, -fall.rate, -fall.acceleration))


def waves(t: np.ndarray, terms: Sequence[Wave], weight: Curve) -> Curve:
    """
    Return weight(t) times the sum of amplitude sin(2 pi frequency t + phase).

    ``t`` (n,): times [s].
    """
    total = Curve(np.zeros_like(t), np.zeros_like(t), np.zeros_like(t))
    for term in terms:
        omega = 2.0 * np.pi * term.frequency
        angle = omega * t + np.deg2rad(term.phase_degrees)
        sine, cosine = np.sin(angle), np.cos(angle)
        total = Curve(
            total.value + term.amplitude * sine,
            total.rate + term.amplitude * omega * cosine,
            total.acceleration - term.amplitude * omega * omega * sine,
        )
    return _product(weight, total)


def tool_waves(t: np.ndarray, spec: ToolWaves, start: np.ndarray) -> ToolSamples:
    """
    Return the tool swinging about its start: p0 + w waves, R0 Rz(c) Ry(b) Rx(a).

    ``t`` (n,): times [s]; ``spec``: waves along the axes of base [m] and of the three angles
    [rad]; ``start`` (4, 4): pose about which the tool swings.
    """
    weight = window(t, spec.duration, spec.ramp, spec.ramp_down)
    axes = [waves(t, spec.position.get(axis, []), weight) for axis in _AXES]
    a, b, c = (waves(t, spec.rotation.get(axis, []), weight) for axis in _AXES)
    turn, omega, alpha = _angles(a, b, c)
    pose = np.empty((t.size, 4, 4))
    pose[:, :3, :3] = np.matmul(start[:3, :3], turn)
    pose[:, :3, 3] = start[:3, 3] + np.stack([axis.value for axis in axes], axis=-1)
    pose[:, 3] = 0.0, 0.0, 0.0, 1.0
    return ToolSamples(
        pose,
        np.concatenate([np.stack([axis.rate for axis in axes], axis=-1),
                        _turned(start, omega)], axis=-1),
        np.concatenate([np.stack([axis.acceleration for axis in axes], axis=-1),
                        _turned(start, alpha)], axis=-1),
    )


def joint_waves(t: np.ndarray, spec: JointWaves) -> Reference:
    """
    Return the joints swinging about their start.

    ``t`` (n,): times [s]; ``spec``: waves of each joint [rad].  Returned: arrays of shape (n, 6).
    """
    weight = window(t, spec.duration, spec.ramp, spec.ramp_down)
    terms = {str(name): terms for name, terms in spec.joints.items()}
    curves = [waves(t, terms.get(name, []), weight) for name in JOINT_NAMES]
    q, qd, qdd = (np.stack([curve[part] for curve in curves], axis=-1) for part in range(3))
    return Reference(np.deg2rad(spec.start_degrees) + q, qd, qdd)


def tool_circle(t: np.ndarray, spec: ToolCircle, start: np.ndarray) -> ToolSamples:
    """
    Return the tool running around a circle without turning, at rest at both ends.

    ``t`` (n,): times [s]; ``spec``: centre from the start [m], axis, turns, duration [s];
    ``start`` (4, 4): pose at which it begins and ends (after whole turns).
    """
    centre = np.array(spec.centre)
    axis = np.array(spec.normal)
    axis = axis - centre * (axis @ centre) / (centre @ centre)
    across = np.cross(axis / np.linalg.norm(axis), centre)
    rise = quintic_rise(t, spec.duration)
    angle, rate, acceleration = (2.0 * np.pi * spec.turns * part[:, None] for part in rise)
    sine, cosine = np.sin(angle), np.cos(angle)
    along = centre * sine - across * cosine  # derivative of the position by the angle
    pose = np.broadcast_to(start, (t.size, 4, 4)).copy()
    pose[:, :3, 3] += centre * (1.0 - cosine) - across * sine
    still = np.zeros((t.size, 3))
    inward = centre * cosine + across * sine
    return ToolSamples(
        pose,
        np.concatenate([rate * along, still], axis=-1),
        np.concatenate([acceleration * along + rate * rate * inward, still], axis=-1),
    )


def _product(a: Curve, b: Curve) -> Curve:
    return Curve(
        a.value * b.value,
        a.rate * b.value + a.value * b.rate,
        a.acceleration * b.value + 2.0 * a.rate * b.rate + a.value * b.acceleration,
    )


def _angles(a: Curve, b: Curve, c: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return Rz(c) Ry(b) Rx(a) (n, 3, 3), its angular velocity and acceleration (n, 3)."""
    sb, cb = np.sin(b.value), np.cos(b.value)
    sc, cc = np.sin(c.value), np.cos(c.value)
    omega = np.stack([
        cc * cb * a.rate - sc * b.rate,
        sc * cb * a.rate + cc * b.rate,
        c.rate - sb * a.rate,
    ], axis=-1)
    alpha = np.stack([
        cc * cb * a.acceleration - (sc * cb * c.rate + cc * sb * b.rate) * a.rate
        - sc * b.acceleration - cc * c.rate * b.rate,
        sc * cb * a.acceleration + (cc * cb * c.rate - sc * sb * b.rate) * a.rate
        + cc * b.acceleration - sc * c.rate * b.rate,
        c.acceleration - sb * a.acceleration - cb * b.rate * a.rate,
    ], axis=-1)
    return rotation_of_rpy(a.value, b.value, c.value), omega, alpha


def _turned(start: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return R0 v, summed in one order whatever n is, so that n samples equal n times one."""
    x, y, z = vectors[:, 0:1], vectors[:, 1:2], vectors[:, 2:3]
    return start[:3, 0] * x + start[:3, 1] * y + start[:3, 2] * z
