"""From a bag or a robot's log to the arrays of a run."""
