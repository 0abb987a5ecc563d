"""``hf drape``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, StlUnit, Target, run_chapter

SHORT_HELP = "Fabric relaxed onto a mold (STL)"


def drape(
    context: typer.Context,
    material: Annotated[
        str | None,
        typer.Argument(metavar="FABRIC.json", help="Material document of hf fit, or -; or --warp, --weft."),
    ] = None,
    *,
    mold: Annotated[
        list[str],
        typer.Option(metavar="MOLD.stl", help="Surface of the mold; repeated for several in one frame."),
    ],
    grid: Annotated[str, typer.Option(metavar="NxM", help="Nodes along x (warp) and y (weft).")] = "100x100",
    size: Annotated[str, typer.Option(metavar="LxL", help="The flat sheet, as 220mmx220mm.")] = "220mmx220mm",
    depth: Annotated[str, typer.Option(metavar="LENGTH", help="How far the mold is pushed up.")] = "60mm",
    states: Annotated[
        int | None, typer.Option(metavar="N", help="Also the sheet at N equal depths up to --depth.")
    ] = None,
    depths: Annotated[
        str | None, typer.Option(metavar="L,L,...", help="In place of --depth: several, as 20mm,40mm,60mm.")
    ] = None,
    warp: Annotated[
        str | None,
        typer.Option(metavar="TEST.csv", help="Uniaxial test taken as the warp's law as it stands."),
    ] = None,
    weft: Annotated[
        str | None,
        typer.Option(metavar="TEST.csv", help="Uniaxial test taken as the weft's law as it stands."),
    ] = None,
    thickness: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Thickness; the material's own where it has one, else 1mm."),
    ] = None,
    clamp: Annotated[
        str, typer.Option(metavar="EDGES", help="Clamped edges: edges (all four), or some of x-,x+,y-,y+.")
    ] = "edges",
    slide: Annotated[
        str | None, typer.Option(metavar="EDGES", help="Edges held down but free to slide along their line.")
    ] = None,
    blank_holder: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[EDGES=]F/L",
            help="Clamped edges give way where pulled by more, as 0.5N/mm or y-,y+=0.5N/mm.",
        ),
    ] = None,
    friction: Annotated[
        str | None, typer.Option(metavar="MU", help="Coulomb friction on the mold, as 0.3.")
    ] = None,
    load_steps: Annotated[
        int | None, typer.Option(metavar="N", help="Steps of the mold's way with friction; 20 if not given.")
    ] = None,
    prestretch: Annotated[
        str, typer.Option(metavar="S[xS]", help="Stretch along warp x weft in which the sheet is mounted.")
    ] = "1",
    mass: Annotated[
        str | None, typer.Option(metavar="MASS/AREA", help="Fabric's mass per area: lets its weight act.")
    ] = None,
    shear_modulus: Annotated[
        str | None, typer.Option(metavar="STRESS", help="Springs on the diagonals, of this shear modulus.")
    ] = None,
    shear_law: Annotated[
        str | None,
        typer.Option(metavar="BIAS.csv", help="Springs on the diagonals, of a test cut at 45 deg."),
    ] = None,
    max_stretch: Annotated[
        float | None, typer.Option(metavar="S", help="Exit 1 where a spring is stretched further.")
    ] = None,
    solver: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="newton; to compare: dynamic (a slow second opinion), relaxation (the report's own).",
        ),
    ] = "newton",
    steps: Annotated[
        int | None,
        typer.Option(metavar="N", help="Steps of the relaxation (400), of the dynamic (100000)."),
    ] = None,
    divisor: Annotated[float, typer.Option(metavar="C", help="Constant c of the relaxation's step.")] = 40.0,
    tolerance: Annotated[
        float, typer.Option(metavar="R", help="Largest nodal residual over the largest spring force.")
    ] = 1e-6,
    stl_unit: StlUnit = "mm",
    output: Target = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Relax an orthotropic grid of tension-only springs onto a mold (STL).

    \b
    Example:
      hf drape fabric.json --mold molds/cup-male.stl --grid 100x100 \\
         --size 220mmx220mm --depth 60mm -o drape.json
    """
    run_chapter(context)
