"""One curve of a fabric test."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hyperfab.arrays import Array, Ints


@dataclass(frozen=True)
class Reading:
    """One curve: a test in one direction at one temperature [degC], nominal stress in MPa.

    ``temperature`` is the mean over tests that count as at one temperature, ``warmth`` the lowest and highest reading.
    """

    mode: str
    source: str
    stretch: Array
    stress: Array
    direction: str | None = None
    temperature: float | None = None
    warmth: tuple[float, float] | None = None
    specimen: str | None = None
    stretch2: Array | None = None
    stress2: Array | None = None
    sd: Array | None = None
    lines: Ints | None = None
    branch: Ints | None = None
    cycle: Ints | None = None

    def take(self, rows: Any) -> Reading:
        """Return the same curve with some of its rows."""

        def pick(column: Any) -> Any:
            return None if column is None else column[rows]

        return replace(
            self,
            stretch=self.stretch[rows],
            stress=self.stress[rows],
            stretch2=pick(self.stretch2),
            stress2=pick(self.stress2),
            sd=pick(self.sd),
            lines=pick(self.lines),
            branch=pick(self.branch),
            cycle=pick(self.cycle),
        )
