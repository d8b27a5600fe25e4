"""The reference along simulated time: which trajectory is active, since when, what follows it."""

import numpy as np

from ur5_ros.control.point_to_point import MotionLimits, smooth_stop
from ur5_ros.control.tool_motion import Branch
from ur5_ros.control.trajectory import Hold, Trajectory
from ur5_ros.signals import Reference


class TrajectoryExecutor:
    """One trajectory at a time; one that ends at speed is brought to rest, then held."""

    def __init__(self) -> None:
        self.trajectory: Trajectory = Hold(np.zeros(6))
        """The active trajectory."""
        self.start = 0
        """Stamp of its time 0 [ns]."""
        self.name = ''
        """Name of the request."""
        self.branch: Branch | None = None
        """Inverse-kinematics branch of the active trajectory, where one was chosen."""

    @property
    def moving(self) -> bool:
        """Whether the reference moves."""
        return not isinstance(self.trajectory, Hold)

    def execute(self, trajectory: Trajectory, name: str, stamp: int,
                branch: Branch | None = None) -> None:
        """
        Replace the active trajectory.

        ``trajectory``: planned from the reference at ``stamp``; ``stamp``: its time 0 [ns].
        """
        self.trajectory, self.name = trajectory, name
        self.start, self.branch = stamp, branch

    def at(self, stamp: int, limits: MotionLimits) -> Reference:
        """
        Return the reference at a stamp; what has ended passes into a stop or into holding.

        ``stamp``: not before the stamp of the last call [ns].
        """
        trajectory = self.trajectory
        while stamp - self.start > trajectory.duration and not isinstance(trajectory, Hold):
            end = trajectory.at(trajectory.duration)
            self.start += trajectory.duration
            trajectory = smooth_stop(end, limits) if end.qd.any() else Hold(end.q)
            self.trajectory = trajectory
        return trajectory.at(stamp - self.start)
