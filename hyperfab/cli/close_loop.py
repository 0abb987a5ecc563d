"""``hf close-loop``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.reading import (
    Branch,
    Columns,
    Cycle,
    Diameter,
    GaugeLength,
    Preload,
    Resample,
    SkipRows,
    Specimen,
    Thickness,
    Width,
    Zero,
)
from hyperfab.cli.shared import Debug, Quiet, Strict, Target, run_chapter

SHORT_HELP = "What the model lacks, found in measured data"


def close_loop(
    context: typer.Context,
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL", help="A material, contact, drape or press document, a mold.toml, or -."
        ),
    ],
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="[FILE]...", help="Measured data that say themselves what they are (CSV, .xlsx)."
        ),
    ] = [],
    measured: Annotated[
        list[str], typer.Option(metavar="CSV", help="Measured data; repeat for more files.")
    ] = [],
    uniaxial: Annotated[
        list[str], typer.Option(metavar="CSV", help="Uniaxial test of a fabric that does not say so.")
    ] = [],
    shear: Annotated[list[str], typer.Option(metavar="CSV", help="Planar shear test of a fabric.")] = [],
    biaxial: Annotated[list[str], typer.Option(metavar="CSV", help="Biaxial test of a fabric.")] = [],
    hold_out: Annotated[
        list[str],
        typer.Option(
            metavar="CSV", help="Data that take no part and are predicted; auto leaves out test by test."
        ),
    ] = ["auto"],
    noise: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="Standard deviation of a reading, as 0.002MPa, 0.5N or 0.2mm; estimated where not given.",
        ),
    ] = None,
    fix: Annotated[list[str], typer.Option(metavar="KEY", help="Hold a constant of the model.")] = [],
    prior: Annotated[
        str | None,
        typer.Option(
            metavar="SHARE",
            help="Standard deviation of the model's own constants, as 10%; else they are free.",
        ),
    ] = None,
    specimen: Specimen = None,
    gauge_length: GaugeLength = None,
    width: Width = None,
    thickness: Thickness = None,
    diameter: Diameter = None,
    branch: Branch = "all",
    cycle: Cycle = "all",
    zero: Zero = False,
    preload: Preload = None,
    resample: Resample = None,
    columns: Columns = [],
    skip_rows: SkipRows = None,
    decimal: Annotated[
        str | None, typer.Option(metavar="MARK", help="Decimal mark of the files: . or ,")
    ] = None,
    output: Target = "-",
    strict: Strict = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Compare a model with measured data, find the effect it lacks, and add it where the data are sure.

    \b
    Example:
      hf close-loop fabric.json specimens/lycra/warp-23C.csv specimens/lycra/weft-23C.csv -o loop.json
    """
    run_chapter(context)
