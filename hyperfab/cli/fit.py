"""``hf fit``: its options and its help."""

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

#: The laws by name; the registry holds them, and its numbers take too long to load for a help page.
LAWS = (
    "alexander, arruda-boyce, arruda-boyce-langevin, arruda-boyce-lni2, blatz-ko, blatz-ko-general, carroll, "
    "extended-tube, fabric-fibres, gent, gent-gent, mooney-rivlin-2, mooney-rivlin-3, mooney-rivlin-5, "
    "mooney-rivlin-9, neo-hookean, ogden-1, ogden-2, ogden-3, yeoh-1, yeoh-2, yeoh-3, yeoh-3-lni2, orthotropic."
)

SHORT_HELP = "Constants of a law from fabric tests"


def fit(
    context: typer.Context,
    files: Annotated[
        list[str],
        typer.Argument(metavar="[FILE]...", help="Tests that say themselves what they are (CSV, .xlsx)."),
    ] = [],
    uniaxial: Annotated[
        list[str], typer.Option(metavar="CSV", help="Uniaxial test; repeat for more files.")
    ] = [],
    shear: Annotated[list[str], typer.Option(metavar="CSV", help="Planar shear (planar tension) test.")] = [],
    biaxial: Annotated[
        list[str], typer.Option(metavar="CSV", help="Equibiaxial or general biaxial test.")
    ] = [],
    volumetric: Annotated[list[str], typer.Option(metavar="CSV", help="Volumetric test.")] = [],
    model: Annotated[str, typer.Option(metavar="NAME", help="A strain-energy law, or all. " + LAWS)] = "all",
    fit_on: Annotated[
        str | None,
        typer.Option(
            metavar="TESTS", help="Tests that take part, as uniaxial,shear; the others are predicted."
        ),
    ] = None,
    objective: Annotated[
        str, typer.Option(metavar="KIND", help="relative (the default) or absolute least squares.")
    ] = "relative",
    stable: Annotated[
        bool, typer.Option("--stable", help="Only constants that are Drucker-stable over the data.")
    ] = False,
    plane: Annotated[
        bool, typer.Option("--plane", help="Check stability over all pairs of stretches too.")
    ] = False,
    accept: Annotated[
        str,
        typer.Option(metavar="R", help="Largest relative rms (absolute fit: NRMSE) accepted, as 0.05 or 5%."),
    ] = "0.30",
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
    noise: Annotated[
        str | None, typer.Option(metavar="STRESS", help="Standard deviation of a reading, as 0.002MPa.")
    ] = None,
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
    """Identify the constants of a strain-energy law from fabric tests (CSV).

    \b
    Example:
      hf fit --uniaxial specimens/treloar-1944/uniaxial.csv \\
             --biaxial specimens/treloar-1944/biaxial.csv --model yeoh-3 -o fabric.json
    """
    run_chapter(context)
