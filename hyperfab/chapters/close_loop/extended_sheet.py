"""The extended sheet: a fabric, or laws of threads, with refitted constants, and the command that presses it, or
drapes it, with the terms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.contact import STICK, ContactCase
from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.place import applied
from hyperfab.chapters.close_loop.finalise import Extension
from hyperfab.chapters.close_loop.softening import scaled_material, soften
from hyperfab.chapters.close_loop.sure import mark
from hyperfab.chapters.fabric_contact.setup import SPHERE
from hyperfab.chapters.molds import PlacedMold
from hyperfab.cloth import Sheet
from hyperfab.cloth.law import SpringLaw
from hyperfab.documents.base import Document
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output
from hyperfab.io.stl_write import stl_bytes
from hyperfab.loop.contact import ContactProblem
from hyperfab.loop.drape import DrapeProblem
from hyperfab.loop.engine import Finding

#: Where the refitted fabric is written, and the tests that are taken as laws.
FABRIC = ".model.fabric.json"
THREADS = (".model.warp.csv", ".model.weft.csv")
#: Where a mold of another size is written.
SIZED = ".model.sized.stl"
#: Where in the set-up of a test, and of a drape, the emulator's settings are added.
PRESSED = {
    "prestretch": ("prestretch",),
    "friction": ("friction_coefficient",),
    "slip": ("rim_slip_mm2_N",),
    "sphere": ("sphere_radius_mm",),
}
DRAPED = {
    "prestretch": ("prestretch.0", "prestretch.1"),
    "weft more": ("prestretch.1",),
    "friction": ("friction",),
    "shear": ("shear_modulus_MPa",),
    "mass": ("mass_g_m2",),
    "aside x": ("offset_mm.0",),
    "aside y": ("offset_mm.1",),
}


def contact_applied(case: ContactCase, amounts: Mapping[str, float]) -> ContactCase:
    """Return the case with amounts of the emulator's settings added; where nodes stick there is no coefficient."""
    if case.friction == STICK:
        amounts = {**amounts, "friction": 0.0}
    elif amounts.get("friction", 0.0) < 0.0:
        # Down to none, less what rounding leaves.
        amounts = {**amounts, "friction": max(amounts["friction"], -float(case.friction))}
    if amounts.get("sphere", 0.0):
        case = replace(case, sphere_radius=case.sphere_radius or SPHERE)
    if amounts.get("frame", 0.0):
        case = replace(case, frame_stiffness=1.0 / (case.yields + amounts["frame"]))
    return applied(case, amounts, PRESSED)


def drape_applied(case: DrapeCase, amounts: Mapping[str, float]) -> DrapeCase:
    """Return the case with amounts of the emulator's settings added; a modulus takes the place of a measured law."""
    at = "depth_mm" if case.depths is None else f"depths_mm.{int(np.argmax(case.depths))}"
    if amounts.get("shear", 0.0):
        case = replace(case, shear_law=None)
    return applied(case, amounts, {**DRAPED, "depth": (at,)})


def extend_contact(
    out: Output, case: ContactCase, material: MaterialDocument, problem: ContactProblem, found: Finding
) -> Extension:
    """Return the case of the extended sheet, and the fabric it reads."""
    fit = found.after.fit
    factors = {name: float(v) for name, v in zip(problem.sheet.names, fit.x, strict=False)}
    fabric = scaled_material(material, factors)
    notes: list[str] = []
    amounts, added = problem.amounts(fit.terms), problem.added(fit.terms)
    if amounts.pop("hold", 0.0) > 0.0:
        own = np.asarray(fit.x[: fit.own - 1])
        slip = float(problem.sheet.slips(own, added, 1.0)[-1]) + problem.sheet.slip
        amounts["slip"] = slip / problem.sheet.scale(own) - problem.sheet.slip
        notes.append("rim-slip: a clamp that holds at first is written as the spring that gives as much at the end")
    larger = replace(contact_applied(case, amounts), material=str(out.path(FABRIC)), against=None)
    if "thermal-softening" in fit.terms:
        _soften(fabric, problem, *fit.terms["thermal-softening"])
        larger = replace(larger, temperature=float(np.median(_met(problem))))
    mark(fabric.effects or [], found)
    return Extension(larger, {FABRIC: fabric}, notes)


def _soften(fabric: MaterialDocument, problem: ContactProblem, form: str, values: Array) -> None:
    """Write the softening at the temperatures met, and the effect that it stands for."""
    soften(fabric, list(values), problem.reference_degC, _met(problem), form)
    record = {
        "id": "thermal-softening",
        "form": form,
        "parameters": problem.effect("thermal-softening").form(form).named(values),
        "reference_degC": problem.reference_degC,
        "told_by": "temperatures",
    }
    fabric.effects = [*(fabric.effects or []), record]


def _met(problem: ContactProblem) -> Array:
    """Return the temperatures at which was measured."""
    return np.concatenate([one.temperature for one in problem.files if one.temperature is not None])


def extend_drape(
    out: Output,
    case: DrapeCase,
    material: MaterialDocument | None,
    sheet: Sheet,
    placed: Callable[[Mapping[str, float]], PlacedMold],
    problem: DrapeProblem,
    found: Finding,
) -> Extension:
    """Return the case of the extended drape, and the fabric and the mold it reads; ``placed`` tells the mold by what is
    added."""
    fit = found.after.fit
    own = {one.name: float(v) for one, v in zip(problem.own, fit.x, strict=False)}
    amounts = problem.amounts(fit.terms)
    larger = drape_applied(case, {"depth": own["depth"], **amounts})
    notes, files = [], dict[str, bytes | Document]()
    if "mold-size" in fit.terms:
        larger, files[SIZED] = sized(larger, str(out.path(SIZED)), placed(amounts))
    if "shear-stiffness" in fit.terms and case.shear_law is not None:
        notes.append("shear-stiffness: a modulus takes the place of the measured law of shear")
    if material is None:
        laws = (_thread(sheet.warp, own["warp"]), _thread(sheet.weft, own["weft"]))
        warp, weft = (str(out.path(suffix)) for suffix in THREADS)
        larger = replace(larger, warp=warp, weft=weft, thickness=sheet.thickness)
        return Extension(larger, files | dict(zip(THREADS, laws, strict=True)), notes)
    fabric = scaled_material(material, {name: own[name] for name in problem.draped.names})
    return Extension(replace(larger, material=str(out.path(FABRIC))), files | {FABRIC: fabric}, notes)


def sized(case: DrapeCase, name: str, placed: PlacedMold) -> tuple[DrapeCase, bytes]:
    """Return the case on a mold of that name, and the mold as an STL."""
    data = stl_bytes(placed.surface.vertices, placed.surface.faces)
    return replace(case, mold=(name,), axis="z", stl_unit="mm"), data


def _thread(law: SpringLaw, factor: float) -> bytes:
    """Return a measured law with its stress times ``factor``, as a uniaxial test."""
    rows = list(zip(law.knots - 1.0, factor * law.pieces[:, 1], strict=True))
    return csv_bytes(["strain [-]", "stress [MPa]"], rows)
