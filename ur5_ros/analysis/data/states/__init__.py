"""The joint states of a recording that count: stamps, sources, fields."""
