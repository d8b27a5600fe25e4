"""The node processes of `ur5 demo`."""
