"""The paper: kinematics and dynamics of a UR arm in closed form; numpy and numba, nothing else."""
