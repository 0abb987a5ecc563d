"""The names, options and help of ``hf``. Each command is a few lines and imports its chapter inside."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from hyperfab import __version__
from hyperfab.console import Console, run_guarded
from hyperfab.errors import OutputError

if TYPE_CHECKING:
    from hyperfab.chapters.job import Job

app = typer.Typer(
    name="hf",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Target = Annotated[
    str,
    typer.Option(
        "--output", "-o", metavar="NAME.json", help="Where the document goes; - is standard output."
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only warnings and errors on standard error.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of a defect.")]
StlUnit = Annotated[
    str, typer.Option(metavar="UNIT", help="Unit of the numbers in STL files: mm, cm, m or inch.")
]


@app.callback(invoke_without_command=True)
def hf(
    version: Annotated[bool, typer.Option("--version", help="Show the version and stop.")] = False,
) -> None:
    """Simulate how stretch fabrics are tested, stretched, heated and pressed into shape.

    Each command reads files and writes one JSON document, with fields, curves and pictures beside it.
    A later command takes the document of an earlier one; - reads it from standard input.
    """
    if version:
        print(f"hf {__version__}")
        raise typer.Exit


@app.command(short_help="Constants of a law from fabric tests")
def fit(
    context: typer.Context,
    uniaxial: Annotated[
        list[str], typer.Option(metavar="CSV", help="Uniaxial test; repeat for more files.")
    ] = [],  # noqa: B006
    shear: Annotated[list[str], typer.Option(metavar="CSV", help="Planar shear (planar tension) test.")] = [],  # noqa: B006
    biaxial: Annotated[
        list[str], typer.Option(metavar="CSV", help="Equibiaxial or general biaxial test.")
    ] = [],  # noqa: B006
    volumetric: Annotated[list[str], typer.Option(metavar="CSV", help="Volumetric test.")] = [],  # noqa: B006
    model: Annotated[str, typer.Option(metavar="NAME", help="A strain-energy law, or all.")] = "all",
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
    accept: Annotated[float, typer.Option(metavar="R", help="Largest relative rms that is accepted.")] = 0.30,
    thickness: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="Thickness of the fabric, as 0.6mm.")
    ] = None,
    decimal: Annotated[
        str | None, typer.Option(metavar="MARK", help="Decimal mark of the files: . or ,")
    ] = None,
    output: Target = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Identify the constants of a strain-energy law from fabric tests (CSV).

    \b
    Example:
      hf fit --uniaxial specimens/treloar-1944/uniaxial.csv \\
             --biaxial specimens/treloar-1944/biaxial.csv --model yeoh-3 -o fabric.json
    """
    options = _given(context, "context", "output", "quiet", "debug")

    def action(job: Job) -> int:
        from hyperfab.chapters import fit as chapter

        return chapter.run(job, **options, output=output)

    _run(context, quiet, debug, action)


@app.command("fabric-contact", short_help="A sphere pushed into a clamped sheet")
def fabric_contact(
    context: typer.Context,
    material: Annotated[
        str, typer.Argument(metavar="FABRIC.json", help="Material document of hf fit, or -.")
    ],
    against: Annotated[
        str | None, typer.Option(metavar="OTHER.json", help="Material to compare with (case B).")
    ] = None,
    shape: Annotated[
        str, typer.Option(metavar="SHAPE", help="Outline of the sheet: disc or square.")
    ] = "disc",
    size: Annotated[
        str, typer.Option(metavar="LENGTH", help="Diameter or side of the undeformed sheet.")
    ] = "200mm",
    thickness: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Thickness; the material's own where it has one, else 1mm."),
    ] = None,
    sphere_radius: Annotated[
        str, typer.Option(metavar="LENGTH", help="Radius of the rigid sphere.")
    ] = "40mm",
    depth: Annotated[str, typer.Option(metavar="LENGTH", help="How far the sphere is pushed in.")] = "60mm",
    prestretch: Annotated[
        float, typer.Option(metavar="S", help="The rim is held at S times its undeformed place.")
    ] = 1.0,
    friction: Annotated[str | None, typer.Option(metavar="MU", help="Coulomb coefficient, or stick.")] = None,
    steps: Annotated[
        int | None, typer.Option(metavar="N", help="Load steps; adaptive where not given.")
    ] = None,
    mesh_size: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="Edge length of the elements.")
    ] = None,
    output: Target = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Push a rigid sphere into a clamped sheet: nonlinear membrane finite elements.

    \b
    Example:
      hf fabric-contact fabric.json --shape disc --size 200mm --thickness 1mm \\
         --sphere-radius 40mm --depth 60mm -o contact.json
    """
    options = _given(context, "context", "output", "quiet", "debug")

    def action(job: Job) -> int:
        from hyperfab.chapters import fabric_contact as chapter

        return chapter.run(job, **options, output=output)

    _run(context, quiet, debug, action)


@app.command(short_help="Fabric relaxed onto a mold (STL)")
def drape(
    context: typer.Context,
    material: Annotated[
        str, typer.Argument(metavar="FABRIC.json", help="Material document of hf fit, or -.")
    ],
    mold: Annotated[str, typer.Option(metavar="MOLD.stl", help="Surface of the mold.")],
    grid: Annotated[str, typer.Option(metavar="NxM", help="Nodes along x (warp) and y (weft).")] = "100x100",
    size: Annotated[str, typer.Option(metavar="LxL", help="The flat sheet, as 220mmx220mm.")] = "220mmx220mm",
    depth: Annotated[str, typer.Option(metavar="LENGTH", help="How far the mold is pushed up.")] = "60mm",
    thickness: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Thickness; the material's own where it has one, else 1mm."),
    ] = None,
    clamp: Annotated[
        str, typer.Option(metavar="EDGES", help="Clamped edges: edges (all four), or some of x-,x+,y-,y+.")
    ] = "edges",
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
    options = _given(context, "context", "output", "quiet", "debug")

    def action(job: Job) -> int:
        from hyperfab.chapters import drape as chapter

        return chapter.run(job, **options, output=output)

    _run(context, quiet, debug, action)


@app.command("mold-heat", short_help="Warm-up of a heated mold")
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
    options = _given(context, "context", "output", "quiet", "debug")

    def action(job: Job) -> int:
        from hyperfab.chapters import mold_heat as chapter

        return chapter.run(job, **options, output=output)

    _run(context, quiet, debug, action)


@app.command("press-contact", short_help="Where two hot molds touch")
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
    stl_unit: StlUnit = "mm",
    output: Target = "-",
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Press two hot molds on the fabric-foam-fabric sandwich: where do they touch, and how hard.

    \b
    Example:
      hf press-contact --male molds/cup-male.stl --female molds/cup-female.stl --axis z \\
         --foam specimens/foam.toml --gap 3mm --temperature 200degC -o press.json
    """
    options = _given(context, "context", "output", "quiet", "debug")

    def action(job: Job) -> int:
        from hyperfab.chapters import press_contact as chapter

        return chapter.run(job, **options, output=output)

    _run(context, quiet, debug, action)


@app.command(short_help="The sample specimens and molds")
def sample(
    context: typer.Context,
    folder: Annotated[str, typer.Argument(metavar="DIR", help="Folder that receives specimens/ and molds/.")],
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that differ.")] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write the sample specimens and molds.

    \b
    Example:
      hf sample .
    """

    def action(job: Job) -> int:
        from hyperfab.chapters import sample as chapter

        return chapter.run(folder, force=force, console=job.console)

    _run(context, quiet, debug, action)


@app.command(short_help="JSON Schema of a document kind")
def schema(
    context: typer.Context,
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="material, contact, drape, mold, heat, foam or press.")
    ],
    debug: Debug = False,
) -> None:
    """Print the JSON Schema of a kind of document.

    \b
    Example:
      hf schema material
    """

    def action(job: Job) -> int:
        from hyperfab.chapters import schema as chapter

        return chapter.run(kind)

    _run(context, False, debug, action)


@app.command(short_help="One screen about a set of documents")
def summary(
    context: typer.Context,
    documents: Annotated[list[str], typer.Argument(metavar="DOCUMENT...", help="Documents of any kind.")],
    debug: Debug = False,
) -> None:
    """Print what documents say, a few lines each, and where their pictures are.

    \b
    Example:
      hf summary fabric.json contact.json drape.json
    """

    def action(job: Job) -> int:
        from hyperfab.chapters import summary as chapter

        return chapter.run(job, documents)

    _run(context, False, debug, action)


def _given(context: typer.Context, *without: str) -> dict[str, object]:
    """Return the command's options by name, without those that every command has."""
    return {name: value for name, value in context.params.items() if name not in without}


def _arguments(context: typer.Context) -> list[str]:
    """Return the arguments as the user gave them, in the order of the help page, without the output's name."""
    words: list[str] = []
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if source is None or source.name != "COMMANDLINE" or name in ("output", "quiet", "debug"):
            continue
        value = context.params[name]
        for item in value if isinstance(value, (list, tuple)) else [value]:
            if parameter.param_type_name == "option":
                words.append(max(parameter.opts, key=len))
            if not isinstance(item, bool):
                words.append(str(item))
    return words


def _run(context: typer.Context, quiet: bool, debug: bool, action: Callable[[Job], int]) -> None:
    """Run a command inside the guard that turns every ending into its exit status."""

    def guarded() -> int:
        from hyperfab.chapters.job import Job

        return action(Job(context.command.name or "hf", _arguments(context), Console(quiet)))

    raise typer.Exit(run_guarded(guarded, debug))


def main() -> None:
    """Entry point of ``hf``: exits with the statuses that README.md lists."""
    try:
        app(prog_name="hf")
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 0
    except OSError as error:
        # Help and usage are printed by typer, which lets a full disk through.
        print(f"hf: output: {error.strerror or error}", file=sys.stderr)
        status = OutputError.exit_status
    status = _flush(status)
    if status == OutputError.exit_status:
        # The interpreter would try to flush standard output once more, and print a traceback.
        os._exit(status)
    sys.exit(status)


def _flush(status: int) -> int:
    try:
        sys.stdout.flush()
    except OSError as error:
        print(f"hf: output: standard output: {error.strerror or error}", file=sys.stderr)
        return OutputError.exit_status
    return status
