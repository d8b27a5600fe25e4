"""Prefixes of joint names: which arms the messages of a recording hold."""

from collections.abc import Iterable, Sequence

from ur5_ros.signals import JOINT_NAMES


def prefixes_of(names: Sequence[str]) -> list[str]:
    """Return the prefixes with which all six joints are in ``names``, in their order."""
    present = set(names)
    found = [name.removesuffix(JOINT_NAMES[0]) for name in names if name.endswith(JOINT_NAMES[0])]
    return [prefix for prefix in dict.fromkeys(found)
            if all(prefix + joint in present for joint in JOINT_NAMES)]


def with_prefix(prefix: str) -> list[str]:
    """Return the six joint names of the arm with this prefix."""
    return [prefix + joint for joint in JOINT_NAMES]


def quoted(prefixes: Iterable[str]) -> str:
    """Return prefixes as a list in words; the empty one is called so."""
    return ', '.join(repr(prefix) if prefix else "'' (none)" for prefix in prefixes)
