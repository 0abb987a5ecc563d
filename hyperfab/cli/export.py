"""``hf export``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, Strict, run_chapter

SHORT_HELP = "Material card for a finite-element program"


def export(
    context: typer.Context,
    document: Annotated[
        str, typer.Argument(metavar="FABRIC.json", help="Material document; - is standard input.")
    ],
    to: Annotated[str, typer.Option(metavar="SOLVER", help="abaqus, ansys, ls-dyna or febio.")],
    direction: Annotated[
        str | None, typer.Option(metavar="WAY", help="warp or weft, where the material has directions.")
    ] = None,
    temperature: Annotated[
        str | None, typer.Option(metavar="TEMPERATURE", help="Constants at this temperature, as 80degC.")
    ] = None,
    bulk_modulus: Annotated[
        str | None,
        typer.Option(metavar="STRESS", help="Bulk modulus; the volume is kept where none is known."),
    ] = None,
    density: Annotated[str, typer.Option(metavar="DENSITY", help="Density of the fabric.")] = "1000 kg/m^3",
    name: Annotated[str, typer.Option(metavar="NAME", help="Name of the material in the card.")] = "fabric",
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE", help="Where the card goes; - is standard output.")
    ] = "-",
    strict: Strict = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write the constants of a material as the card of a finite-element program, in its own convention.

    \b
    Example:
      hf export fabric.json --to abaqus -o card.inp
    """
    run_chapter(context)
