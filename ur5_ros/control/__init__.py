"""Laws and references: eq (11), trajectories, experiments; no clock, no file, no topic."""
