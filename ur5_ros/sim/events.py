"""What happens to the plant besides motion, as records for the bag."""

import json
from typing import Any, NamedTuple


class Event(NamedTuple):
    """Something that the equations need to know about a run."""

    stamp: int
    """Stamp of the state from which it acts [ns]."""
    kind: str
    """One of parameter, reset, wrench, fallback, limit, protective_stop, lockstep, ..."""
    message: str
    """One sentence."""
    values: dict[str, str]
    """JSON texts by key."""


def event(stamp: int, kind: str, message: str, /, **values: Any) -> Event:
    """
    Return an event with its values as JSON texts.

    ``stamp``: stamp of the state from which it acts [ns].
    """
    return Event(stamp, kind, message, {key: json.dumps(value) for key, value in values.items()})
