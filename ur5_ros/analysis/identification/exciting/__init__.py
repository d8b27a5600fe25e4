"""A motion that excites every parameter: its search, its limits, its files and a trial of it."""
