"""Simulated torque control of Universal Robots arms in ROS 2, with evidence."""

__version__ = '0.1.0'
