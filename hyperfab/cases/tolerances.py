"""How sure the numbers of a set-up are: standard deviations that people stated, by the places of the numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hyperfab.io.units import Toleranced, toleranced


def tolerances(value: Any, path: str) -> dict[str, float]:
    """Return the standard deviations that a value states, by the places of its numbers: ``size_mm.0``.

    >>> tolerances((Toleranced(20.0, 0.5), 30.0), "size_mm")
    {'size_mm.0': 0.5}
    """
    if isinstance(value, Toleranced):
        return {path: value.sd}
    found: dict[str, float] = {}
    if isinstance(value, (Mapping, tuple, list)):
        items = value.items() if isinstance(value, Mapping) else enumerate(value)
        for key, one in items:
            found |= tolerances(one, f"{path}.{key}")
    return found


def with_tolerances(value: Any, path: str, known: Mapping[str, float]) -> Any:
    """Return a value with the standard deviations that are ``known`` of its numbers, by their places."""
    if isinstance(value, float) and path in known:
        return toleranced(value, known[path])
    if isinstance(value, tuple):
        return tuple(with_tolerances(one, f"{path}.{i}", known) for i, one in enumerate(value))
    if isinstance(value, Mapping):
        return {key: with_tolerances(one, f"{path}.{key}", known) for key, one in value.items()}
    return value
