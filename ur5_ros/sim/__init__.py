"""The plant: a UR arm in PyBullet, its imperfections, its limits, what it does when nobody commands."""
