"""A robot's own log: its table, its columns, and the bag that it becomes."""
