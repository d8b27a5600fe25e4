"""The command ``ur5``."""
