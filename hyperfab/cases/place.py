"""A place in a case: its path, what stands there, and the case with something else there.

A path is the key of a field in ``setup``, and where the field holds several, what follows the dot: ``depth_mm``,
``prestretch.1``, ``blank_holder_N_mm.y-``.
"""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from hyperfab.cases.case import Case
from hyperfab.cases.field import Setting
from hyperfab.cases.kinds import plain
from hyperfab.errors import UsageError

CaseT = TypeVar("CaseT", bound=Case)


def get(case: Case, path: str) -> Any:
    """Return what stands at a place, as plain data; None where nothing does."""
    one, *rest = _split(case, path)
    value = getattr(case, one.name)
    found = None if value is None else plain(one.kind.dump(value))
    for part in rest:
        if found is None:
            return None
        found = found[int(part)] if isinstance(found, list) else found.get(part)
    return found


def put(case: CaseT, path: str, value: Any) -> CaseT:
    """Return the case with ``value``, plain data, at a place; None takes the field back to nothing.

    Raises UsageError where the place cannot hold it.
    """
    one, *rest = _split(case, path)
    if rest:
        whole = copy.deepcopy(get(case, one.key))
        inner = whole
        for part in rest[:-1]:
            inner = inner[int(part)] if isinstance(inner, list) else inner[part]
        last = rest[-1]
        inner[int(last) if isinstance(inner, list) else last] = value
        value = whole
    if value is None:
        return dataclasses.replace(case, **{one.name: one.kind.read([], path) if one.kind.repeated else None})
    return dataclasses.replace(case, **{one.name: one.kind.checked(value, path, lambda: one.kind.load(plain(value)))})


def applied(case: CaseT, amounts: Mapping[str, float], places: Mapping[str, Sequence[str]]) -> CaseT:
    """Return the case with each amount added at the places it has; one of zero leaves the case as it is.

    Raises UsageError where a place cannot hold the sum.
    """
    for name, amount in amounts.items():
        for path in places.get(name, ()) if amount else ():
            case = put(case, path, (get(case, path) or 0.0) + amount)
    return case


def _split(case: Case, path: str) -> tuple[Any, ...]:
    first, *rest = path.split(".")
    found: Setting | None = next((one for one in case.settings().values() if first in (one.key, one.name)), None)
    if found is None:
        keys = ", ".join(one.key for one in case.settings().values())
        raise UsageError(f"{path}: hf {case.COMMAND} has no such setting; it has {keys}")
    return found, *rest
