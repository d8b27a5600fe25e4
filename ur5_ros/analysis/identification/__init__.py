"""From recorded motion to the parameters of an arm."""
