"""The reference along simulated time: which motion is on, since when, and what comes after it."""

import numpy as np

from ur5_ros.control.point_to_point import MotionLimits, smooth_stop
from ur5_ros.control.tool_motion import Branch
from ur5_ros.control.trajectory import Hold, Trajectory
from ur5_ros.signals import Reference


class TrajectoryExecutor:
    """One motion at a time; a motion that ends at speed is brought to rest, then held."""

    def __init__(self) -> None:
        self.motion: Trajectory = Hold(np.zeros(6))
        """The motion that is on."""
        self.start = 0
        """Stamp at which it began [ns]."""
        self.name = ''
        """What asked for it."""
        self.branch: Branch | None = None
        """Inverse-kinematics branch of the newest motion that chose one."""

    @property
    def moving(self) -> bool:
        """Tell whether the reference moves."""
        return not isinstance(self.motion, Hold)

    def begin(self, motion: Trajectory, name: str, stamp: int,
              branch: Branch | None = None) -> None:
        """
        Let a motion take over.

        Parameters
        ----------
        motion : Motion
            Planned from the reference at ``stamp``.
        name : str
            What asked for it.
        stamp : int
            Its time 0 [ns].
        branch : Branch, optional
            The inverse-kinematics branch chosen for it.

        """
        self.motion, self.name, self.start, self.branch = motion, name, stamp, branch

    def at(self, stamp: int, limits: MotionLimits) -> Reference:
        """
        Return the reference at a stamp and let what is over pass into a stop or standing still.

        Parameters
        ----------
        stamp : int
            Not before the last one asked for [ns].
        limits : MotionLimits
            For the stop.

        Returns
        -------
        Reference
            Continuous in position and velocity but where an experiment asks for a jump.

        """
        motion = self.motion
        while stamp - self.start > motion.duration and not isinstance(motion, Hold):
            end = motion.at(motion.duration)
            self.start += motion.duration
            motion = smooth_stop(end, limits) if end.qd.any() else Hold(end.q)
            self.motion = motion
        return motion.at(stamp - self.start)
