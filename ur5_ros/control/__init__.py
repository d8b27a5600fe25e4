"""Laws and references: computed torque (eq 11), trajectories, experiments; no clock, no file, no topic."""
