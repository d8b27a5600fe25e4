"""The plant: a UR arm in PyBullet, its imperfections, its limits, its fallbacks; no ROS."""
