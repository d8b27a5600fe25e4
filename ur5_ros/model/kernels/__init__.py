"""What Numba compiles: the formulas of the model on plain numbers, and how they are compiled."""
