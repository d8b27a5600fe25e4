"""Plant and law in a plain for loop, without ROS: re-simulation, re-control, sweeps."""
