"""Friction of the joints: families that a fit chooses from, and parts of an arm file."""
