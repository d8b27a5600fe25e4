"""Plant and control law in one process, without ROS: runs, re-simulation, rollouts."""
