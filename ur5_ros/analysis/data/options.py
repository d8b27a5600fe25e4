"""Options for recordings that do not describe themselves."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ur5_ros.errors import InputError

#: What a recorded effort can be; ``--effort`` sets it.
EFFORT_MEANINGS = ('total', 'gravity_excluded', 'target', 'current', 'other_sign')


@dataclass(frozen=True)
class ReadingOptions:
    """Statements of the user about a recording."""

    topics: Mapping[str, str] = field(default_factory=dict)
    """Role -> topic."""
    joint_prefix: str | None = None
    """Text before the joint names; None: found."""


def parse_topics(given: list[str] | None, roles: Mapping[str, object]) -> dict[str, str]:
    """Return role -> topic from texts ``ROLE=NAME``; InputError for another form or role."""
    found: dict[str, str] = {}
    for text in given or ():
        role, equals, topic = text.partition('=')
        if not equals or not topic or role not in roles:
            raise InputError(f'--topic {text!r}; give ROLE=NAME, the roles are: '
                             f'{", ".join(roles)}')
        if role in found:
            raise InputError(f'--topic {role} is given twice; give each role once')
        found[role] = topic
    return found


def check_effort_meaning(meaning: str | None) -> None:
    """Refuse a meaning of effort that does not exist."""
    if meaning is not None and meaning not in EFFORT_MEANINGS:
        raise InputError(f'--effort {meaning!r}; give one of: {", ".join(EFFORT_MEANINGS)}')
