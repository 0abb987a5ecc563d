"""``hf mold-heat``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, StlUnit, Target, run_chapter

SHORT_HELP = "Warm-up of a heated mold"


def mold_heat(
    context: typer.Context,
    mold: Annotated[
        str, typer.Argument(metavar="MOLD.toml", help="Mold document: parts, heaters, conditions.")
    ],
    stl_unit: StlUnit = "mm",
    output: Target = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Heat a mold: transient conduction and convection on 10-node tetrahedra.

    \b
    Example:
      hf mold-heat molds/proposed.toml -o heat.json
    """
    run_chapter(context)
