"""``hf export``: a material document as the card of a finite-element program."""

from __future__ import annotations

from hyperfab import __version__
from hyperfab.chapters.job import Job
from hyperfab.documents.base import read_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError, UsageError
from hyperfab.io.output import check_place, write_single
from hyperfab.io.units import quantity
from hyperfab.materials import bind
from hyperfab.materials.export import NoCard, Settings, format_called

#: Name of the material in the card where none is given; solvers take letters, digits and underscores.
_NAME = "fabric"


def run(
    job: Job,
    *,
    document: str,
    to: str,
    direction: str | None = None,
    temperature: str | None = None,
    bulk_modulus: str | None = None,
    density: str = "1000 kg/m^3",
    name: str = _NAME,
    output: str = "-",
) -> int:
    """Write the card; UsageError where the solver has no such law, with the laws it has."""
    chosen = format_called(to)
    if output != "-":
        check_place(output)
    if not name.isascii() or not name.replace("_", "").isalnum():
        raise UsageError(f"--name {name}: letters, digits and underscores only, as lycra_warp")
    degrees = None if temperature is None else quantity(temperature, "temperature", option="--temperature")
    bulk = None if bulk_modulus is None else quantity(bulk_modulus, "stress", option="--bulk-modulus")
    mass = quantity(density, "density", option="--density") * 1e-12
    if (bulk is not None and not bulk > 0.0) or not mass > 0.0:
        raise UsageError("--bulk-modulus and --density: values above zero are needed")
    source = read_document(job.inputs, document, MaterialDocument)
    if source.directions and direction is None:
        ways = ", ".join(source.directions)
        job.console.warn(f"the material has directions ({ways}); the card has the constants of both together")
    if direction is not None and not source.directions:
        raise UsageError(f"--direction {direction}: {document} has no directions")
    _warn(job, source, direction)
    try:
        material = bind(source.model, source.constants(direction, degrees))
    except InputError as error:
        raise InputError(error.message, file=document, key=error.key, remedy=error.remedy) from None
    settings = Settings(
        name=name,
        bulk_modulus=bulk if bulk is not None else source.bulk_modulus_MPa,
        density=mass,
        comments=_comments(source, direction, degrees),
    )
    try:
        card = chosen.card(material, settings)
    except NoCard as error:
        raise UsageError(f"--to {to}: {error}; fit one of these") from None
    write_single(output, card.encode(), job.inputs)
    return 0


def _warn(job: Job, source: MaterialDocument, direction: str | None) -> None:
    """Say what the card cannot say."""
    stable = (
        source.directions[direction].stable if source.directions and direction in source.directions else None
    )
    if (source.stable if stable is None else stable) is False:
        job.console.warn("the constants are not Drucker-stable over the tests; the solver may stop there")
    if source.thickness_nominal:
        job.console.warn(
            "the constants are per width (a thickness of 1 mm was taken): give the sheet 1 mm in the solver"
        )
    if source.effects:
        names = ", ".join(str(effect.get("id", "?")) for effect in source.effects)
        job.console.warn(f"the card has the elastic law alone, without the effects {names}")


def _comments(source: MaterialDocument, direction: str | None, degrees: float | None) -> list[str]:
    """Return what a reader of the card should know, a line each."""
    lines = [f"hyperfab {__version__}: {source.model}; units N, mm, MPa, t, s"]
    shown = degrees if degrees is not None else source.temperature_degC
    at = [direction] if direction else []
    at += [f"{shown:g} degC"] if shown is not None else []
    if at:
        lines.append(f"constants of {', '.join(at)}")
    fit = source.fit
    if direction is not None and source.directions:
        fit = source.directions[direction].fit
    if fit is not None:
        lines.append(f"relative rms {fit.relative_rms:.4g} over {fit.points} readings")
    part = source.directions[direction] if direction is not None and source.directions else source
    for mode, stable in (part.stability or {}).items():
        if stable.first_unstable_stretch is not None:
            lines.append(f"{mode}: unstable from stretch {stable.first_unstable_stretch:.4g}")
    return lines
