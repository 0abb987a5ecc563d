"""``hf export``: a material document as the card of a finite-element program."""

from __future__ import annotations

from hyperfab import __version__
from hyperfab.cases.about import ExportCase
from hyperfab.chapters.fabric import ORTHOTROPIC, FabricDocument, read_fabric_document
from hyperfab.chapters.job import Job
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import UsageError
from hyperfab.io.output import check_place, write_single
from hyperfab.materials.effects.elastic_law import EACH_WAY, Richer
from hyperfab.materials.export import Format, NoCard, Settings, format_called, formats
from hyperfab.materials.export.card import is_of_I1, poisson
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.material import Material
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.stability import stable_ranges

#: The stretch at which it is told what a card lacks.
_SHOWN = 1.1
#: What a document's law may be.
Law = Material | Orthotropic | Hyperfoam


def run(job: Job, case: ExportCase) -> int:
    """Write the card; UsageError where the solver has no such law, with the laws it has."""
    chosen = format_called(case.to)
    if job.target != "-":
        check_place(job.target)
    direction = case.direction
    fabric = read_fabric_document(job, case.document, case.temperature)
    source = fabric.document
    sheet = source.model == ORTHOTROPIC
    if source.directions and direction is None and not sheet:
        own = [way for way, one in source.directions.items() if one.parameters == source.parameters]
        job.console.warn(
            f"the material has directions ({', '.join(source.directions)}); the card has the constants of "
            + (" and ".join(own) or f'all together; --direction "{next(iter(source.directions))}" writes those of one')
        )
    # A sheet has warp and weft, whether or not the document says again what each is.
    told = direction is None or direction in (source.directions or ())
    turned = sheet and not told and direction in ("warp", "weft")
    if not (source.directions or told or turned):
        raise UsageError(f"--direction {direction}: {case.document} has no directions")
    law = _law(fabric, None if turned else direction, chosen)
    _warn(job, fabric, law, direction)
    fabric.used_at(job)
    job.judge_ranges()
    if isinstance(law, Orthotropic) and turned and direction == "weft":
        law = law.turned()
    bulk = case.bulk_modulus if case.bulk_modulus is not None else source.bulk_modulus_MPa
    _check_volume(job, case, source, law, bulk)
    settings = Settings(
        name=case.name,
        bulk_modulus=bulk,
        density=case.density * 1e-12,
        comments=_comments(fabric, law, direction),
    )
    try:
        card = chosen.card(law, settings)
    except NoCard as error:
        out = "" if isinstance(law, Material) else f"; {_way_out(law, settings)}"
        raise UsageError(f"--to {case.to}: {error}{out}") from None
    write_single(job.target, card.encode(), job.inputs)
    return 0


def _law(fabric: FabricDocument, direction: str | None, chosen: Format) -> Law:
    """Return the law of the card: with the terms of ``elastic-law`` where the solver can hold it so, else as its
    constants alone tell it."""
    # Of a law whose added terms differ each way no card stands for both.
    told = direction is not None or not any(str(one.get("form")).endswith(EACH_WAY) for _, one in fabric.added)
    law = fabric.law(direction)
    if isinstance(law, Material) and fabric.added and told and chosen.curve is not None:
        whole = fabric.material(direction, anisotropic=False)
        if is_of_I1(whole):
            return whole
    return law


def _has_terms(law: Law) -> bool:
    """Whether a law has the terms of ``elastic-law``."""
    return isinstance(law, Material) and isinstance(law.law, Richer)


def _check_volume(job: Job, case: ExportCase, source: MaterialDocument, law: Law, bulk: float | None) -> None:
    """Refuse a bulk modulus, or say that one is left aside, where the law itself tells how the volume changes.

    Say also where one is so small that what is pulled widens.
    """
    if isinstance(law, Orthotropic):
        return
    if isinstance(law, Material) and float(law.law.contraction(law.theta)) >= 0.5:
        if bulk is not None and (nu := poisson(law, bulk)) < 0.0:
            job.console.warn(
                f"a bulk modulus of {bulk:.4g} MPa is below two thirds of the shear modulus: Poisson's ratio is "
                f"{nu:.2g}, it widens where it is pulled"
            )
        return
    if case.bulk_modulus is not None:
        raise UsageError(f"--bulk-modulus: {source.model} changes its volume by its own nu; leave the option out")
    if source.bulk_modulus_MPa is not None:
        job.console.warn(
            f"{source.model} changes its volume by its own nu; the bulk modulus of the volumetric test is left aside"
        )


def _way_out(law: Orthotropic | Hyperfoam, settings: Settings) -> str:
    """Return what holds a sheet or a foam that one solver cannot: other solvers, else a law of each direction."""
    able = []
    for name in formats():
        try:
            format_called(name).card(law, settings)
        except NoCard:
            continue
        able.append(name)
    if able:
        return f"{' and '.join(able)} can"
    return "none of the solvers can: fit a law of each direction, as --model yeoh-3, and export it with --direction"


def _warn(job: Job, fabric: FabricDocument, law: Law, direction: str | None) -> None:
    """Say what the card of a ``law`` cannot say."""
    source = fabric.document
    stable = source.directions[direction].stable if source.directions and direction in source.directions else None
    if (source.stable if stable is None else stable) is False:
        job.console.warn("the constants are not Drucker-stable over the tests; the solver may stop there")
    if source.thickness_nominal:
        job.console.warn(
            "the constants are per width (a thickness of 1 mm was taken): give the sheet 1 mm in the solver"
        )
    # What stands in the constants themselves is in the card.
    told = {"directions": direction is not None, "model": True, "temperatures": True}
    there = {"thermal-softening", *(["elastic-law"] if _has_terms(law) else [])}
    names = [
        str(effect.get("id", "?"))
        for effect in source.effects or []
        if not (told.get(str(effect.get("told_by")), False) or effect.get("id") in there)
        or effect.get("diagonal_softness")
    ]
    if names:
        less = ""
        if "elastic-law" in names and isinstance(law, Material):
            ratio = float(law.uniaxial(_SHOWN).P / fabric.material(direction).uniaxial(_SHOWN).P)
            less = f": at a stretch of {_SHOWN:g} it bears {ratio:.2g} times the stress"
        job.console.warn(f"the card has the elastic law alone, without the effects {', '.join(names)}{less}")


def _comments(fabric: FabricDocument, law: Law, direction: str | None) -> list[str]:
    """Return what a reader of the card should know, a line each."""
    source, shown = fabric.document, fabric.temperature
    added = " with the terms of elastic-law" if _has_terms(law) else ""
    lines = [f"hyperfab {__version__}: {source.model}{added}; units N, mm, MPa, t, s"]
    at = [direction] if direction else []
    at += [f"{shown:g} degC"] if shown is not None else []
    at += [f"none known there: those of {fabric.held_at:g} degC"] if fabric.held_at is not None else []
    if at:
        lines.append(f"constants of {', '.join(at)}")
    fit = (source.directions or {}).get(direction or "", source).fit
    if fit is not None:
        by = source.accepted_by or "relative_rms"
        lines.append(f"{by.replace('_', ' ')} {getattr(fit, by):.4g} over {fit.points} readings")
    for mode, first in _first_unstable(source, law, direction).items():
        if first is not None:
            lines.append(f"{mode}: unstable from stretch {first:.4g}")
    return lines


def _first_unstable(source: MaterialDocument, law: Law, direction: str | None) -> dict[str, float | None]:
    """Return the stretch of each mode from which the card's own constants are unstable, None where there is none."""
    if isinstance(law, Material):  # at the temperature asked for, of which the document says nothing
        return {mode: one.first_unstable for mode, one in stable_ranges(law).items()}
    part = (source.directions or {}).get(direction or "", source)
    return {mode: one.first_unstable_stretch for mode, one in (part.stability or {}).items()}
