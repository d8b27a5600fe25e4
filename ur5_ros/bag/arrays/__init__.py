"""Recorded messages as NumPy arrays."""
