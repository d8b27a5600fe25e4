"""Callbacks that learn that a kernel has to be compiled; a module that loads nothing."""

from collections.abc import Callable

_notices: list[Callable[[str], None]] = []


def on_compile(notice: Callable[[str], None]) -> None:
    """Have ``notice(name)`` called before a kernel is compiled that the cache does not have."""
    _notices[:] = [notice]


def announce(name: str) -> None:
    """Pass on that a kernel is about to be compiled."""
    for notice in _notices:
        notice(name)
