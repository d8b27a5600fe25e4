"""Exercises that grade themselves."""
