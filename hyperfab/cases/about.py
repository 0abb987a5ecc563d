"""What is asked of the commands that write no document: ``hf report``, ``summary``, ``sample`` and ``schema``."""

from __future__ import annotations

from dataclasses import dataclass

from hyperfab.cases.case import Case
from hyperfab.cases.field import files, flag, text


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
