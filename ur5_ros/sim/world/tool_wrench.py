"""Force and torque at the tool, as a sensor between flange and tool feels them."""

from collections.abc import Sequence

import numpy as np

from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.world.contact import Contacts
from ur5_ros.sim.world.contact_rows import PLACE, A, B

#: Index of the link that carries the tool.
TOOL_LINK = 5


def tool_wrench(steps: Sequence[Contacts], wrench: np.ndarray, q: np.ndarray,
                arm: ArmParameters) -> np.ndarray:
    """
    Return force [N] and torque [N m] of the environment on the tool, at and in ``tool0``, (6,).

    ``steps``: the physics steps of one control period; the mean is taken; ``wrench`` (6,): what
    acts besides at the origin of ``tool0``, in base [N], [N m]; ``q`` (6,): joint positions at the
    end of the period, for the axes of the wrench [rad].
    """
    total = np.zeros(6)
    for each in steps:
        sign = (each.points[:, A] == TOOL_LINK).astype(float)
        sign -= each.points[:, B] == TOOL_LINK
        if sign.any():
            pose = forward_kinematics(np.array(each.q) + arm.angle_offset, arm)
            force = sign[:, None] * each.force
            lever = each.points[:, PLACE:PLACE + 3] - pose[:3, 3]
            moment = np.cross(lever, force).sum(axis=0)
            total += _in_tool(np.concatenate([force.sum(axis=0), moment]), pose)
    total /= max(len(steps), 1)
    if wrench.any():
        total += _in_tool(wrench, forward_kinematics(q + arm.angle_offset, arm))
    return total


def _in_tool(wrench: np.ndarray, pose: np.ndarray) -> np.ndarray:
    return (pose[:3, :3].T @ wrench.reshape(2, 3).T).T.ravel()
