"""``hf press-contact``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, StlUnit, Strict, Target, run_chapter

SHORT_HELP = "Where two hot molds touch"


def press_contact(
    context: typer.Context,
    male: Annotated[str, typer.Option(metavar="MALE.stl", help="Surface of the male mold.")],
    female: Annotated[str, typer.Option(metavar="FEMALE.stl", help="Surface of the female mold.")],
    foam: Annotated[str, typer.Option(metavar="FOAM.toml", help="The sandwich: foam and fabric layers.")],
    axis: Annotated[str, typer.Option(metavar="AXIS", help="Closing axis: x, y or z.")] = "z",
    gap: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="Axial clearance at the datum, cold.")
    ] = None,
    force: Annotated[
        str | None, typer.Option(metavar="FORCE", help="Closing force; the position is solved.")
    ] = None,
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Uniform temperature of both molds.")
    ] = None,
    male_heat: Annotated[
        str | None, typer.Option(metavar="HEAT.json", help="The male mold's temperature.")
    ] = None,
    female_heat: Annotated[
        str | None, typer.Option(metavar="HEAT.json", help="The female mold's temperature.")
    ] = None,
    drape: Annotated[
        str | None, typer.Option(metavar="DRAPE.json", help="Fabric thickness from hf drape.")
    ] = None,
    mounted: Annotated[
        str,
        typer.Option(
            metavar="HOW", help="Mounting faces are held flat, or free to warp with the heat: flat or free."
        ),
    ] = "flat",
    zero: Annotated[
        str,
        typer.Option(
            metavar="WHEN", help="Whether --gap was set cold or again on the hot molds: cold or hot."
        ),
    ] = "cold",
    floating: Annotated[
        bool,
        typer.Option("--float", help="The female hangs on a joint in its mounting face and finds its tilt."),
    ] = False,
    force_at: Annotated[
        str | None, typer.Option(metavar="L,L", help="Where the joint sits across the axis, as 10mm,0mm.")
    ] = None,
    frame_stiffness: Annotated[
        str | None, typer.Option(metavar="STIFFNESS", help="The press frame yields, as 50kN/mm.")
    ] = None,
    tilt: Annotated[
        str | None,
        typer.Option(
            metavar="ANGLE,ANGLE",
            help="The female stands tilted about the two axes across the closing axis, as 0.05deg,0deg.",
        ),
    ] = None,
    strokes: Annotated[int, typer.Option(metavar="N", help="Points of the force-stroke curve.")] = 21,
    min_spotted: Annotated[
        float | None,
        typer.Option(metavar="PERCENT", help="Exit 1 where less of the molding surface touches."),
    ] = None,
    design_gap: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH", help="Also write the male that leaves this hot gap everywhere, as STL."
        ),
    ] = None,
    facets: Annotated[
        str,
        typer.Option(
            metavar="KIND", help="STL facets stand for a smooth surface, or are flat: smooth or flat."
        ),
    ] = "smooth",
    stl_unit: StlUnit = "mm",
    output: Target = "-",
    strict: Strict = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Press two hot molds on the fabric-foam-fabric sandwich: where do they touch, and how hard.

    \b
    Example:
      hf press-contact --male molds/cup-male.stl --female molds/cup-female.stl --axis z \\
         --foam specimens/foam.toml --gap 3mm --temperature 200degC -o press.json
    """
    run_chapter(context)
