"""What each law and table of a run was used at, gathered while it runs: the document's ``validity``.

A chapter says of every law or table where it was used, and where that is known to hold; once a run and table:

    job.ranges.used("stretch", stretch, known=(1.0, 1.8), source="fabric.json")
    job.ranges.used("temperature_degC", 200.0, known=(23.0, 105.0), source="fabric.json", then="105 degC is taken")
    job.ranges.used("film.csv", wall, known=table.x, source="mold.toml", unit="degC")

Values and ``known`` are numbers or arrays, of which the ends count; ``known`` is None where nothing states a range.
``Job.write`` puts the entries into the document and tells what is outside in one line of warning; with ``--strict``
the command then ends with status 1. A command that writes no document calls ``job.judge_ranges()`` itself.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.documents.base import Validity

#: Ends closer than this, relative to the larger of them, are the same end: a table used at its last row is inside.
_SAME = 1e-9
#: So are ends that are closer than this share of what is known: hours are written with four decimals.
_ROUNDED = 1e-4


@dataclass
class Ranges:
    """What was used so far, by law or table and input: the entry, its unit in words, what is done beyond its range."""

    _uses: dict[tuple[object, ...], tuple[Validity, str, str]] = field(default_factory=dict)

    def used(
        self,
        of: str,
        values: ArrayLike,
        *,
        known: ArrayLike | None,
        source: str,
        direction: str | None = None,
        unit: str = "",
        then: str = "",
        stress: tuple[float, float] | None = None,
    ) -> Validity | None:
        """Note that a law or table was used at ``values``; ``then`` says what is done beyond what is ``known``.

        ``stress`` is the largest one of the law there, and that at the end of what is known: of a law that stiffens
        the stretch alone does not show how far beyond its tests it was used.

        Values that are not finite were not used; None is returned, and nothing noted, where none is left. Of the same
        law or table, in the same ``direction`` of the fabric, the values used are joined.

        >>> from hyperfab.chapters.validity import Ranges
        >>> ranges = Ranges()
        >>> ranges.used("stretch", [1.0, 2.03], known=(1.0, 1.8), source="fabric.json").within
        False
        >>> ranges.warning
        'used beyond what is known: stretch 1 to 2.03 (fabric.json: 1 to 1.8)'
        >>> _ = ranges.used("stretch", 1.3, known=(1.0, 1.1), source="a.json", then="extrapolated", stress=(192.0, 3.0))
        >>> ranges.warning[70:]
        'stretch 1.3 (a.json: 1 to 1.1; extrapolated to 64 times the stress at the end of its tests)'
        """
        met = _ends(values)
        if met is None:
            return None
        ends = None if known is None else _ends(known)
        key = (of, source, direction, ends)
        ratio = stress[0] / stress[1] if stress is not None and stress[1] > 0.0 and np.isfinite(stress).all() else None
        if key in self._uses:
            before = self._uses[key][0]
            met = (min(met[0], before.used[0]), max(met[1], before.used[1]))
            ratio = max((one for one in (ratio, before.stress_ratio) if one is not None), default=None)
        within = None
        if ends is not None:
            slack = max(_SAME * max(abs(ends[0]), abs(ends[1])), _ROUNDED * (ends[1] - ends[0]))
            within = ends[0] - slack <= met[0] and met[1] <= ends[1] + slack
        entry = Validity(
            of=of,
            direction=direction,
            used=met,
            known=ends,
            within=within,
            stress_ratio=None if within is not False else ratio,
            source=source,
        )
        self._uses[key] = (entry, unit or ("degC" if of.endswith("_degC") else ""), then)
        return entry

    def taken(self, name: str, document: Mapping[str, Any]) -> None:
        """Note what the document ``name`` tells of the ranges it was made on: what is made of it stands on them too.

        >>> from hyperfab.chapters.validity import Ranges
        >>> ranges = Ranges()
        >>> entry = {"of": "stretch", "used": [1.0, 2.0], "known": [1.0, 1.8], "from": "fabric.json"}
        >>> ranges.taken("drape.json", {"validity": [entry]})
        >>> ranges.warning
        'used beyond what is known: stretch 1 to 2 (fabric.json in drape.json: 1 to 1.8)'
        """
        for one in document.get("validity") or []:
            source = f"{one['from']} in {os.path.basename(name)}"
            ratio = one.get("stress_ratio")
            self.used(
                one["of"],
                one["used"],
                known=one.get("known"),
                source=source,
                direction=one.get("direction"),
                stress=None if ratio is None else (ratio, 1.0),
            )

    @property
    def entries(self) -> list[Validity]:
        """The entries, in the order in which their laws and tables were first used."""
        return [entry for entry, _, _ in self._uses.values()]

    @property
    def outside(self) -> bool:
        """Whether something was used beyond what is known of it."""
        return any(entry.within is False for entry in self.entries)

    @property
    def warning(self) -> str | None:
        """One line that names all that was used beyond what is known, or None."""
        words = []
        for entry, unit, then in self._uses.values():
            if entry.within is False and entry.known is not None:
                beyond = " ".join(filter(None, (then, _stressed(entry.stress_ratio))))
                known = f"{entry.source}: {span(*entry.known, unit=unit)}" + (f"; {beyond}" if beyond else "")
                along = f" along the {entry.direction}" if entry.direction else ""
                words.append(f"{entry.of.removesuffix('_degC')}{along} {span(*entry.used, unit=unit)} ({known})")
        return f"used beyond what is known: {', '.join(words)}" if words else None


def _stressed(ratio: float | None) -> str:
    if ratio is None or ratio < 1.05:  # by two digits no more than that
        return ""
    return f"to {float(f'{ratio:.2g}'):.15g} times the stress at the end of its tests"


def _ends(values: ArrayLike) -> tuple[float, float] | None:
    found = np.ravel(np.asarray(values, dtype=np.float64))
    found = found[np.isfinite(found)]
    return (float(found.min()), float(found.max())) if len(found) else None


def span(low: float, high: float, *, unit: str = "") -> str:
    """Return a range in words, or its one value."""
    ends = dict.fromkeys(f"{value:.4g}" for value in (low, high))
    return " to ".join(ends) + (f" {unit}" if unit else "")
