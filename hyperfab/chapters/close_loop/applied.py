"""A case with what the loop found, added at its places: the predictor computes on it, the writer writes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from hyperfab.cases.case import Case
from hyperfab.cases.place import get, put

CaseT = TypeVar("CaseT", bound=Case)


def applied(case: CaseT, amounts: Mapping[str, float], places: Mapping[str, Sequence[str]]) -> CaseT:
    """Return the case with each amount added at the places it has; one of zero leaves the case as it is.

    Raises UsageError where a place cannot hold the sum.
    """
    for name, amount in amounts.items():
        for path in places.get(name, ()) if amount else ():
            case = put(case, path, (get(case, path) or 0.0) + amount)
    return case
