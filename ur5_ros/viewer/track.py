"""A run thinned to what a screen can show: tool paths, errors, torques."""

import dataclasses
from typing import NamedTuple

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.config.worlds import World
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.viewer.urdf_tree import UrdfTree, link_poses, parse_urdf
from ur5_ros.wording import number_of


class Track(NamedTuple):
    """Rows of a run at even times; NaN where nothing was recorded."""

    t: np.ndarray
    """Simulated time since the first state [s], shape (n,)."""
    q: np.ndarray
    """Measured joint positions [rad], shape (n, 6)."""
    effort: np.ndarray
    """Torque that acted [N m], shape (n, 6)."""
    error: np.ndarray
    """Measured minus reference joint positions [rad], shape (n, 6)."""
    tool: np.ndarray
    """Measured tool position in the root frame [m], shape (n, 3)."""
    tool_reference: np.ndarray
    """Tool position of the reference in the root frame [m], shape (n, 3)."""
    base: np.ndarray = np.eye(4)
    """Pose of the frame in which positions are given as numbers, in the root frame, (4, 4)."""
    frame: str = 'base'
    """Name of that frame."""

    @property
    def tool_error(self) -> np.ndarray:
        """Distance of the tool from where it should be [m], shape (n,)."""
        return np.linalg.norm(self.tool - self.tool_reference, axis=-1)

    def tool_in_base(self, row: int) -> np.ndarray:
        """Return the measured tool position of a row in :attr:`frame` [m], shape (3,)."""
        return (self.tool[row] - self.base[:3, 3]) @ self.base[:3, :3]

    def row(self, t: float) -> int:
        """Return the last row that is not later than ``t`` [s]."""
        return int(np.clip(np.searchsorted(self.t, t, side='right') - 1, 0, len(self.t) - 1))


def arm_of(run: Run) -> ArmParameters:
    """Return the simulated arm of a run, else the law's, else the default arm."""
    record = run.sim or run.control
    if record is None:
        raise InputError(f'{run.name}: no arm is known; give one: --arm NAME')
    return record.arm


def drawable(arm: ArmParameters) -> ArmParameters:
    """Return an arm of the same looks that a URDF can hold: point masses get a size."""
    if arm.has_tensors:
        return arm
    return dataclasses.replace(arm, inertia=np.broadcast_to(1e-3 * np.eye(3), (6, 3, 3)))


def tree_of(arm: ArmParameters, world: World | None = None) -> UrdfTree:
    """Return the frames and shapes of an arm, with the tool of a world."""
    return parse_urdf(urdf_text(drawable(arm), world=world))


def tool_positions(tree: UrdfTree, q: np.ndarray) -> np.ndarray:
    """
    Return where the tool is.

    ``q`` (n, 6): joint positions, base to wrist [rad].  Returned: origin of ``tool0``, or of the
    last frame where there is none, in the root frame [m], (n, 3).
    """
    poses = link_poses(tree, joint_angles(tree, q))
    last = 'tool0' if 'tool0' in poses else tree.joints[-1].child
    name = next((link for link in poses if link.endswith('tool0')), last)
    return poses[name][..., :3, 3]


def number_frame(tree: UrdfTree) -> tuple[np.ndarray, str]:
    """Return pose and name of the frame ``base``, or of the root where there is none."""
    poses = link_poses(tree, {})
    name = next((link for link in poses if link.endswith('base')), tree.root)
    return poses[name], name


def joint_angles(tree: UrdfTree, q: np.ndarray) -> dict[str, np.ndarray]:
    """
    Return joint positions by the names of the tree, whatever their prefix.

    ``q`` (..., 6): joint positions, base to wrist [rad].  Returned: angle of each joint [rad],
    (...).
    """
    angles = {}
    for joint in tree.joints:
        for i, name in enumerate(JOINT_NAMES):
            if joint.name.endswith(name):
                angles[joint.name] = q[..., i]
    return angles


def track(run: Run, tree: UrdfTree, rows: int = 1500) -> Track:
    """Return at most ``rows`` rows of a run, evenly spread."""
    if len(run.stamp) < 2:
        raise InputError(f'{run.name}: {number_of(len(run.stamp), "state")}; a picture needs '
                         'two at least')
    pick = np.unique(np.linspace(0, len(run.stamp) - 1, rows).round().astype(int))
    q = run.states.q[pick]
    reference = np.full_like(q, np.nan) if run.reference is None else run.reference.q[pick]
    effort = run.states.effort[pick]
    if run.sim is not None:
        effort[0] = np.nan  # before the first state no torque acts
    return Track(run.t[pick], q, effort, q - reference,
                 tool_positions(tree, q), tool_positions(tree, reference), *number_frame(tree))
