"""``hf mold-heat``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, StlUnit, Strict, Target, run_chapter

SHORT_HELP = "Warm-up of a heated mold"


def mold_heat(
    context: typer.Context,
    mold: Annotated[
        str, typer.Argument(metavar="MOLD.toml", help="Mold document: parts, heaters, conditions.")
    ],
    warmup_in: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Scale all heaters so that the target is reached in TIME."),
    ] = None,
    share_power: Annotated[
        bool,
        typer.Option("--share-power", help="Share the power among the heaters for an even work surface."),
    ] = False,
    heater_max: Annotated[
        str | None, typer.Option(metavar="POWER", help="Most that --share-power may give one heater.")
    ] = None,
    variations: Annotated[
        str | None,
        typer.Option(
            metavar="FILE.csv",
            help="Factors on film, power, conductivity, specific heat, one run a row, on a reduced model.",
        ),
    ] = None,
    stl_unit: StlUnit = "mm",
    output: Target = "-",
    strict: Strict = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Heat a mold: transient conduction and convection on 10-node tetrahedra.

    \b
    Example:
      hf mold-heat molds/proposed.toml -o heat.json
      hf mold-heat molds/original.toml --warmup-in 20min -o fast.json
      hf mold-heat molds/original.toml --variations factors.csv -o varied.json
    """
    run_chapter(context)
