"""What stands in a picture of a run: the links of its arm and the bodies of its world, placed."""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.viewer.picture.ray_caster import Placed
from ur5_ros.viewer.track import arm_of, joint_angles, number_frame, tree_of
from ur5_ros.viewer.urdf_tree import UrdfTree, link_poses
from ur5_ros.viewer.world_track import WorldTrack, force_arrows

#: Length of the drawn axes of ``base`` and of ``tool0`` [m].
BASE_AXES, TOOL_AXES = 0.25, 0.1


class Stage:
    """
    The arm and its world, as the browser's viewer shows them.

    ``tree``: the arm; that of the run by default.

    """

    def __init__(self, run: Run, tree: UrdfTree | None = None):
        self.tree = tree or tree_of(arm_of(run), run.sim.world if run.sim else None)
        """The arm and its tool."""
        self._world = WorldTrack(run)
        self._base, self._base_name = number_frame(self.tree)
        self.reach = sum(float(np.linalg.norm(joint.pose[:3, 3])) for joint in self.tree.joints)
        """Length of the stretched arm [m]."""
        self.has_forces = bool(run.contact_forces)
        """Whether forces of contact were recorded."""
        self.floor = 0.0
        """Height of the grid [m]."""

    def arm(self, q: np.ndarray) -> list[Placed]:
        """Return the links and the tool at joint positions ``q`` [rad] (6,)."""
        poses = link_poses(self.tree, joint_angles(self.tree, q))
        return [Placed(visual, poses[link] @ visual.pose)
                for link, visuals in self.tree.visuals.items() for visual in visuals]

    def world(self, t: float) -> list[Placed]:
        """Return the bodies that the arm can touch at a time [s]."""
        return [Placed(visual, self._base @ pose) for visual, pose in
                zip(self._world.visuals, self._world.poses(t), strict=True)]

    def frames(self, q: np.ndarray) -> list[tuple[str, np.ndarray, float]]:
        """Return name, pose and drawn length of the frames that are shown."""
        poses = link_poses(self.tree, joint_angles(self.tree, q))
        tool = next((link for link in poses if link.endswith('tool0')), None)
        shown = [(self._base_name, self._base, BASE_AXES)]
        return shown + ([(tool, poses[tool], TOOL_AXES)] if tool else [])

    def forces(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the lines of contact forces (n, 2, 3) in the root frame, and their colours."""
        points, colours = force_arrows(self._world.contacts(t))
        return points @ self._base[:3, :3].T + self._base[:3, 3], colours
