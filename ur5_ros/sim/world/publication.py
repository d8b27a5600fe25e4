"""What a plant in a world reports each period, as messages: the same for node and loop."""

import numpy as np

from ur5_ros.cdr.contact_messages import (
    ContactForce,
    FixedWrench,
    encode_markers,
    encode_poses,
)
from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.plant import Plant


class ContactPublication:
    """The messages of contact, a list every control period."""

    def __init__(self, parameters: SimParameters):
        prefix, rate = parameters.tf_prefix, parameters.monitor_rate
        self._base = f'{prefix}base'
        self._effort = FixedJointState([prefix + name for name in JOINT_NAMES],
                                       fields=('effort',))
        self._wrench = FixedWrench(f'{prefix}tool0')
        self._sensor = ForceTorqueSensor()
        self._period, self._monitored = round(1e9 / rate) if rate else 0, -1

    def zero(self, plant: Plant) -> None:
        """Take the wrench of now for zero, as ``zero_force_torque_sensor`` of a UR robot does."""
        self._sensor.zero(plant)

    def messages(self, plant: Plant) -> list[tuple[str, bytes]]:
        """Return role and bytes of each message of the present period."""
        found = [('contact_effort', self._effort.encode(stamp, (), (), torque))
                 for stamp, torque in plant.contact_effort()]
        stamp = plant.stamp
        found.append(('wrench', self._wrench.encode(stamp, self._sensor.read(plant))))
        if self._period and stamp // self._period != self._monitored:
            self._monitored = stamp // self._period
            found.append(('contacts', encode_markers(stamp, self._base, contact_forces(plant))))
            if bodies := plant.mechanics.objects():
                found.append(('objects', encode_poses(
                    stamp, self._base, [(place, turn) for _, place, turn in bodies])))
        return found


class ForceTorqueSensor:
    """The wrench at the tool as a sensor gives it: offset, noise, a zero that can be set."""

    def __init__(self) -> None:
        self._zero = np.zeros(6)

    def zero(self, plant: Plant) -> None:
        """Subtract from now on what it shows now."""
        self._zero = self._zero + self.read(plant)

    def read(self, plant: Plant) -> np.ndarray:
        """Return force [N] and torque [N m] of the environment on the tool, in ``tool0``, (6,)."""
        given = plant.parameters
        wrench = plant.tool_wrench() + given.force_torque_offset - self._zero
        noise = np.repeat([given.force_torque_noise_force, given.force_torque_noise_torque], 3)
        if noise.any():
            draw = np.random.Generator(np.random.Philox(key=[given.seed, 1],
                                                        counter=[plant.k, 0, 0, 0]))
            wrench = wrench + noise * draw.standard_normal(6)
        return wrench


def contact_forces(plant: Plant) -> list[ContactForce]:
    """Return the contacts with a force in the last physics step of the present period."""
    if not plant.mechanics.contacts:
        return []
    last, found = plant.mechanics.contacts[-1], []
    for point, force, pair in zip(last.points, last.force, last.pairs, strict=True):
        if force.any():
            normal = point[5:8] * (point[5:8] @ force)
            found.append(ContactForce(pair, point[2:5], normal, force - normal, float(point[9])))
    return found
