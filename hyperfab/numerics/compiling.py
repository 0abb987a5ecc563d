"""That a kernel is being compiled, for those who say so; without numba, which takes a quarter of a second to import."""

from __future__ import annotations

from collections.abc import Callable

#: Whether the package is being built: what is compiled then is kept in it.
building = False
_announce: Callable[[], None] | None = None


def announced_by(announce: Callable[[], None] | None) -> None:
    """Let ``announce`` be called when a kernel that is kept nowhere is about to be compiled; once."""
    global _announce
    _announce = announce


def begins() -> None:
    """Say that a kernel is about to be compiled.

    >>> announced_by(lambda: print("compiling"))
    >>> begins()
    compiling
    >>> begins()
    """
    global _announce
    announce, _announce = _announce, None
    if announce is not None:
        announce()
