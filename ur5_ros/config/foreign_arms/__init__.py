"""Arm files from what others have: a URDF, or a robot's calibration."""
