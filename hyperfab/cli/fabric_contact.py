"""``hf fabric-contact``: its options and its help."""

from __future__ import annotations

from typing import Annotated

import typer

from hyperfab.cli.shared import Debug, Quiet, StlUnit, Target, run_chapter

SHORT_HELP = "A sphere, or any punch (STL), pushed into a clamped sheet"


def fabric_contact(
    context: typer.Context,
    material: Annotated[
        str, typer.Argument(metavar="FABRIC.json", help="Material document of hf fit, or -.")
    ],
    against: Annotated[
        str | None, typer.Option(metavar="OTHER.json", help="Material to compare with (case B).")
    ] = None,
    shape: Annotated[
        str,
        typer.Option(
            metavar="SHAPE",
            help="Outline of the sheet: disc, square, or a file (flat STL or mesh, CSV of x, y).",
        ),
    ] = "disc",
    size: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH",
            help="Diameter or side of the undeformed sheet, 200mm; longer side of an outline from a file.",
        ),
    ] = None,
    thickness: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Thickness; the material's own where it has one, else 1mm."),
    ] = None,
    sphere_radius: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="Radius of the rigid sphere, 40mm where not given.")
    ] = None,
    punch: Annotated[
        str | None,
        typer.Option(metavar="PUNCH.stl", help="A surface in place of the sphere, its top at depth 0."),
    ] = None,
    depth: Annotated[
        str, typer.Option(metavar="LENGTH", help="How far the sphere or the punch is pushed in.")
    ] = "60mm",
    prestretch: Annotated[
        float, typer.Option(metavar="S", help="The rim is held at S times its undeformed place.")
    ] = 1.0,
    rim_slip: Annotated[
        str | None,
        typer.Option(metavar="MM2/N", help="The rim creeps inward by this times the tension, as 0.5mm^2/N."),
    ] = None,
    friction: Annotated[str | None, typer.Option(metavar="MU", help="Coulomb coefficient, or stick.")] = None,
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Of the fabric, where the material document knows of it.")
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(metavar="N", help="Load steps shown, 8 where not given; halved where needed."),
    ] = None,
    mesh_size: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Edge length of the elements; finer at the edge of contact."),
    ] = None,
    element: Annotated[
        str, typer.Option(metavar="P1|P2", help="Straight elements of constant strain, or curved ones.")
    ] = "P2",
    tolerance: Annotated[
        float, typer.Option(metavar="R", help="Relative error of the force, for which elements are refined.")
    ] = 1e-4,
    stl_unit: StlUnit = "mm",
    output: Target = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Push a rigid sphere or punch into a clamped sheet: nonlinear membrane finite elements.

    \b
    Example:
      hf fabric-contact fabric.json --shape disc --size 200mm --thickness 1mm \\
         --sphere-radius 40mm --depth 60mm -o contact.json
    """
    run_chapter(context)
