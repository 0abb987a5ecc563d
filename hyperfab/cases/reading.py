"""How measured files are read, alike in all commands that read them."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import amount, choice, flag, text, texts, whole
from hyperfab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class ReadingCase(Case):
    """Sizes of specimens, chosen rows, and what the columns of a table are."""

    specimen: str | None = text("NAME", "Standard specimen, as iso-37-2 or iso-13934-1.")
    gauge_length: float | None = amount(
        "length", "LENGTH", "Gauge length of force-extension tests.", example="100mm", above=0.0
    )
    width: float | None = amount("length", "LENGTH", "Width of force-extension tests.", example="50mm", above=0.0)
    thickness: float | None = amount(
        "length", "LENGTH", "Thickness of the fabric, as 0.6mm.", example="0.6mm", above=0.0
    )
    diameter: float | None = amount("length", "LENGTH", "Diameter of a biaxial disc.", example="100mm", above=0.0)
    branch: str = choice("BRANCH", "Rows that take part: load, unload or all.", ("load", "unload", "all"), "all")
    cycle: str = text("CYCLE", "Cycle that takes part: a number, first, last or all.", "all")
    zero: bool = flag("Count stretch and stress from the first row of each test.")
    preload: str | None = text("LOAD", "Take out slack: count from where this is reached, as 0.1N or 0.002MPa.")
    resample: int | None = whole(
        "N", "Mean of N equal steps of stretch on each branch.", example="50 points a curve", least=3
    )
    columns: tuple[str, ...] = texts("LIST", 'What columns are, as "Standardkraft=force [N],Weg=extension [mm]".')
    skip_rows: int | None = whole(
        "N", "Lines above the head of the table, where they cannot be told.", example="12", least=0
    )
    decimal: str | None = choice("MARK", "Decimal mark of the files, a point or a comma.", (".", ","))

    def check(self) -> None:
        """Refuse what means nothing."""
        super().check()
        if self.cycle not in ("all", "first", "last") and not self.cycle.isdigit():
            raise UsageError(f"--cycle {self.cycle}: it is a number, first, last or all")
