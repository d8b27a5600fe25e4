"""What the exit code of a command means."""

SUCCESS = 0
"""Done; or judged and passed; or the same."""
FAILED = 1
"""Judged and failed; or different; or incomplete."""
BAD_INPUT = 2
"""Bad input or usage; nothing readable."""
WITH_LOSS = 3
"""Done, with loss."""
INTERNAL_ERROR = 4
"""A defect of this package; never the code of a verdict."""
INTERRUPTED = 130
"""Ended by Ctrl-C."""
