"""What is asked of the commands that write no document: ``export``, ``report``, ``summary``, ``sample``, ``schema``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import amount, file, files, flag, text
from hyperfab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class ReportCase(Case):
    """Write one self-contained page: verdicts, tables, curves, turnable views. It opens without a network.

    \b
    Example:
      hf report build/fabric.json build/drape.json build/press.json -o report.html
    """

    COMMAND = "report"
    OUTPUT = ("NAME.html", "Where the page goes; - is standard output.")

    documents: tuple[str, ...] = files(
        "DOCUMENT...", "Documents of any kind, in any order.", argument=True, required=True
    )
    title: str | None = text(
        "TEXT", "Title of the page; left out, what its one document is, else From fabric to press."
    )


@dataclass(frozen=True, kw_only=True)
class SummaryCase(Case):
    """Print what documents say, a few lines each, and where their pictures are.

    \b
    Example:
      hf summary fabric.json contact.json drape.json
    """

    COMMAND = "summary"
    OUTPUT = None

    documents: tuple[str, ...] = files("DOCUMENT...", "Documents of any kind.", argument=True, required=True)


@dataclass(frozen=True, kw_only=True)
class SampleCase(Case):
    """Write the sample specimens and molds.

    \b
    Example:
      hf sample .
    """

    COMMAND = "sample"
    OUTPUT = None

    folder: str = text("DIR", "Folder that receives specimens/ and molds/.", argument=True, required=True)
    force: bool = flag("Overwrite files that differ.")


@dataclass(frozen=True, kw_only=True)
class SchemaCase(Case):
    """Print the JSON Schema of a kind of document.

    \b
    Example:
      hf schema material
    """

    COMMAND = "schema"
    OUTPUT = None

    kind: str = text(
        "KIND",
        "material, contact, drape, mold, heat, foam, press, loop, study or sweep.",
        argument=True,
        required=True,
    )


@dataclass(frozen=True, kw_only=True)
class ExportCase(Case):
    """Write the constants of a material as the card of a finite-element program, in its own convention.

    \b
    Example:
      hf export fabric.json --to abaqus -o card.inp
    """

    COMMAND = "export"
    OUTPUT = ("FILE", "Where the card goes; - is standard output.")

    document: str = file("FABRIC.json", "Material document; - is standard input.", argument=True, required=True)
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
