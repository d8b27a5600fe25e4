"""Other programs' ways to the same numbers; each is left out with one line where it is missing."""

import importlib
from collections.abc import Callable
from types import ModuleType

import numpy as np

from ur5_ros.model.dynamics import forward_dynamics, inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.urdf import urdf_text

#: Largest difference between two engines' numbers for the same state [N m, rad/s^2].
SAME = 1e-7


def optional(module: str) -> ModuleType | None:
    """Return a module, or None with one line about what is left out."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        print(f'left out: {module} ({error}); pip install ".[bench]"')
        return None


def mujoco_dynamics(arm: ArmParameters, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
                    ) -> tuple[Callable[[], object], Callable[[], object]] | None:
    """
    Return MuJoCo's inverse and forward dynamics of one state as calls; None without MuJoCo.

    Contacts, limits and every other constraint are switched off: dynamics is all that it does.

    Raises
    ------
    ValueError
        If its numbers are not ours.

    """
    mujoco = optional('mujoco')
    if mujoco is None:
        return None
    model = mujoco.MjModel.from_xml_string(urdf_text(arm, bare=True))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.opt.gravity[:] = arm.gravity
    model.dof_armature[:] = arm.armature
    there, back = mujoco.MjData(model), mujoco.MjData(model)
    torque = inverse_dynamics(q, qd, qdd, arm)

    def inverse() -> np.ndarray:
        there.qpos[:], there.qvel[:], there.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(model, there)
        return there.qfrc_inverse

    def forward() -> np.ndarray:
        back.qpos[:], back.qvel[:], back.qfrc_applied[:] = q, qd, torque
        mujoco.mj_forward(model, back)
        return back.qacc

    _same('mj_inverse', inverse(), torque)
    _same('mj_forward', forward(), forward_dynamics(q, qd, torque, arm))
    return inverse, forward


def ssik_kinematics(q: np.ndarray, branches: int) -> Callable[[], object] | None:
    """
    Return ssik's inverse kinematics of its own UR5 as a call; None without ssik.

    The pose is that of ``q`` (a robot's angles) in its own frames; each branch comes once, without
    its turns.

    Raises
    ------
    ValueError
        If it finds another number of branches.

    """
    solver = optional('ssik.prebuilt.universal_robots.ur5_ik')
    if solver is None:
        return None
    pose = solver.fk(q)

    def solve() -> list:
        return solver.solve(pose, enumerate_windings=False)

    if len(solve()) != branches:
        raise ValueError(f'ssik finds {len(solve())} branches, not {branches}')
    return solve


def _same(name: str, theirs: np.ndarray, ours: np.ndarray) -> None:
    difference = float(np.abs(theirs - ours).max())
    if not difference < SAME:
        raise ValueError(f'{name} differs by {difference:.3g} from ours: not the same arm')
