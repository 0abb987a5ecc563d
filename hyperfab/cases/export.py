"""What is asked of ``hf export``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import amount, file, text
from hyperfab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class ExportCase(Case):
    """Write the constants of a material as the card of a finite-element program, in its own convention.

    \b
    Example:
      hf export fabric.json --to abaqus -o card.inp
    """

    COMMAND = "export"
    OUTPUT = ("FILE", "Where the card goes; - is standard output.")

    document: str = file(
        "FABRIC.json", "Material document; - is standard input.", argument=True, required=True
    )
    to: str = text("SOLVER", "abaqus, ansys, ls-dyna or febio.", required=True)
    direction: str | None = text("WAY", "warp or weft, where the material has directions.")
    temperature: float | None = amount(
        "temperature", "TEMPERATURE", "Constants at this temperature, as 80degC.", example="80degC"
    )
    bulk_modulus: float | None = amount(
        "stress",
        "STRESS",
        "Bulk modulus; the volume is kept where none is known.",
        example="100MPa",
        above=0.0,
    )
    density: float = amount("density", "DENSITY", "Density of the fabric.", "1000 kg/m^3", above=0.0)
    name: str = text("NAME", "Name of the material in the card.", "fabric")

    def check(self) -> None:
        """Refuse what solvers do not take for a name."""
        super().check()
        if not re.fullmatch(r"[A-Za-z]\w{0,79}", self.name, re.ASCII):
            raise UsageError(
                f"--name {self.name[:90]}: a letter, then letters, digits and underscores, 80 in all at most, as "
                "lycra_warp"
            )
