"""The fabric of ``hf drape``: spring laws along warp and weft from a material document."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.drape import DrapeCase
from hyperfab.chapters.drape.curves import read_curve
from hyperfab.chapters.fabric import read_fabric_document
from hyperfab.chapters.fabric_contact.fabric import Fabric as SheetFabric
from hyperfab.chapters.fabric_contact.fabric import sheet_of
from hyperfab.chapters.job import Job
from hyperfab.cloth import SpringLaw
from hyperfab.cloth.law import Pulled, spring_law
from hyperfab.documents.drape import SpringUse
from hyperfab.errors import InputError, UsageError
from hyperfab.materials.orthotropic.specimen import Along

#: What a law straight from a test is called.
MEASURED = "measured"
#: Thickness in mm where nothing states one.
USUAL_THICKNESS = 1.0


@dataclass(frozen=True)
class Fabric:
    """Laws of the springs along warp and weft, and the sheet's thickness in mm.

    By direction: ``models`` says what the law is, ``tested`` how far the tests behind it went, ``fails`` the stretch
    at which a specimen failed, ``sources`` the files behind it. ``temperature`` [degC] is the
    laws', where known, ``held_at`` that of the constants where they were not tested there. ``whole`` is the law of the
    sheet as a membrane, where that is asked for.
    """

    models: tuple[str, str]
    warp: SpringLaw
    weft: SpringLaw
    thickness: float
    tested: tuple[float | None, float | None]
    fails: tuple[float | None, float | None] = (None, None)
    sources: tuple[str, str] = ("", "")
    temperature: float | None = None
    held_at: float | None = None
    whole: SheetFabric | None = None


def read_fabric(job: Job, case: DrapeCase) -> Fabric:
    """Read a material document, or the tests ``warp`` and ``weft`` in its place or in place of one direction.

    The thickness that was asked for goes before what the files state; the temperature is for the document's laws.
    """
    if case.temperature is not None and (case.warp is not None or case.weft is not None):
        raise UsageError(
            f"--temperature {case.temperature:g}degC: a test with --warp or --weft has its own temperature; fit "
            "the tests of several temperatures with hf fit"
        )
    name, warp, weft, given = case.material, case.warp, case.weft, case.thickness
    curves = [
        None if file is None else read_curve(job, option, file, angle, given)
        for option, file, angle in (("--warp", warp, 0.0), ("--weft", weft, 90.0))
    ]
    if name is None:
        for option, curve in zip(("--weft", "--warp"), curves, strict=True):
            if curve is None:
                other = "--warp" if option == "--weft" else "--weft"
                job.console.note(f"no {other}: the curve of {option} is taken for both directions")
        curves = [curve or next(c for c in curves if c is not None) for curve in curves]
        fabric = None
    else:
        fabric = _of_document(job, name, case)
    known = [curve.thickness for curve in curves if curve is not None and curve.thickness is not None]
    if given is None and known and max(known) > 1.02 * min(known):
        raise InputError(
            f"is {max(known):g} mm thick, the other test {min(known):g} mm",
            file=warp if curves[0] is not None and curves[0].thickness == max(known) else weft,
            key="thickness",
            remedy="give --thickness",
        )
    stated = fabric.thickness if fabric is not None and np.isfinite(fabric.thickness) else None
    thick = given or stated or (float(np.mean(known)) if known else None)
    if thick is None:
        thick = USUAL_THICKNESS
        job.console.note(f"{name or warp or weft} states no thickness: 1 mm is taken (--thickness sets it)")
    for curve, file in zip(curves, (warp, weft), strict=True):
        if curve is not None and curve.per_width and thick != USUAL_THICKNESS:
            raise InputError(
                f"is force per width, and the sheet is {thick:g} mm thick",
                file=file or warp or weft,
                key="thickness",
                remedy="give --thickness",
            )
    models, laws = [], []
    tested: list[float | None] = []
    fails: list[float | None] = []
    for k, curve in enumerate(curves):
        if curve is not None:
            models.append(MEASURED)
            laws.append(curve.law)
            tested.append(curve.tested)
            fails.append(curve.fails_at)
        elif fabric is not None:
            models.append(fabric.models[k])
            laws.append((fabric.warp, fabric.weft)[k])
            tested.append(fabric.tested[k])
            fails.append(None)
    files = (warp or name or weft or "", weft or name or warp or "")
    return Fabric(
        (models[0], models[1]), laws[0], laws[1], thick, (tested[0], tested[1]), (fails[0], fails[1]), files,
        None if fabric is None else fabric.temperature, None if fabric is None else fabric.held_at,
        None if fabric is None else fabric.whole,
    )  # fmt: skip


def _of_document(job: Job, name: str, case: DrapeCase) -> Fabric:
    """The fabric of a material document; thickness not a number where it states none."""
    read = read_fabric_document(job, name, case.temperature)
    read.used_at(job)
    document = read.document
    untold = [
        str(effect.get("id", "?"))
        for effect in document.effects or []
        if not effect.get("told_by") and effect.get("id") not in ("elastic-law", "thermal-softening")
    ]
    if untold and case.sheet == "net":
        job.console.warn(
            f"{name}: the springs do not act on {', '.join(untold)}: they answer as on a first, slow pull"
        )
    laws, tested = [], []
    for direction in ("warp", "weft"):
        own = (document.directions or {}).get(direction)
        key = "parameters" if own is None else f"directions.{direction}.parameters"
        whole = read.sheet()
        if whole is not None:
            law: Pulled = Along(whole, 0.0 if direction == "warp" else 90.0)
        else:
            law = read.material(direction if own is not None else None)
        laws.append(_law(law, name, key))
        known = document.tested_stretch(direction, "uniaxial")
        tested.append(None if known is None else known[1])
    thick = np.nan if document.thickness_mm is None else document.thickness_mm
    return Fabric(
        (document.model, document.model), laws[0], laws[1], thick, (tested[0], tested[1]),
        sources=(name, name), temperature=read.temperature, held_at=read.held_at,
        whole=sheet_of(read) if case.sheet == "membrane" else None,
    )  # fmt: skip


def _law(material: Pulled, name: str, key: str) -> SpringLaw:
    try:
        return spring_law(material)
    except ValueError as error:
        raise InputError(
            str(error), file=name, key=key, remedy="fit the fabric again with --stable"
        ) from None


def _end(model: str, law: SpringLaw, largest: float) -> float | None:
    """Where a law of constants ends (its chains lock), where springs pass it; a measured one is extrapolated."""
    passed = model != MEASURED and law.softens is None and largest > law.largest_stretch
    return law.largest_stretch if passed else None


def use_of(fabric: Fabric, stretch_warp: Array, stretch_weft: Array) -> tuple[SpringUse, SpringUse]:
    """How far each law was used, and whether it was tested and rising there.

    A membrane is not judged by the curves of its springs, but by the margin of its own law.
    """
    uses, springs = [], fabric.whole is None
    for model, law, stretch, tested, fails in zip(
        fabric.models,
        (fabric.warp, fabric.weft),
        (stretch_warp, stretch_weft),
        fabric.tested,
        fabric.fails,
        strict=True,
    ):
        largest = float(stretch.max())
        uses.append(
            SpringUse(
                model=model,
                stretch_max=largest,
                tested_stretch_max=tested,
                beyond_tested=None
                if tested is None
                else int(np.count_nonzero(stretch > tested * (1.0 + 1e-9))),
                softens_at=law.softens
                if springs and law.softens is not None and largest > law.softens
                else None,
                ends_at=_end(model, law, largest) if springs else None,
                fails_at=fails if fails is not None and largest > fails else None,
            )
        )
    return uses[0], uses[1]


def note_ranges(job: Job, fabric: Fabric, stretch_warp: Array, stretch_weft: Array) -> None:
    """Note where the law of each direction was used; springs below 1 are slack, and ask it nothing."""
    for way, source, tested, stretch in zip(
        ("warp", "weft"), fabric.sources, fabric.tested, (stretch_warp, stretch_weft), strict=True
    ):
        known = None if tested is None else (1.0, tested)
        met = np.maximum(stretch, 1.0)
        job.ranges.used("stretch", met, known=known, source=source, direction=way, then="extrapolated")
