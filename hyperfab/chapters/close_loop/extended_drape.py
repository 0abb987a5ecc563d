"""The extended drape: a fabric, or laws of threads, with refitted constants, and the command that drapes it with the
terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.place import applied
from hyperfab.chapters.close_loop.extended_contact import FABRIC
from hyperfab.chapters.close_loop.finalise import Extension
from hyperfab.chapters.close_loop.softening import scaled_material
from hyperfab.cloth import Sheet
from hyperfab.cloth.law import SpringLaw
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.loop.drape import DrapeProblem
from hyperfab.loop.engine import Finding

#: Where the tests that are taken as laws are written.
THREADS = (".model.warp.csv", ".model.weft.csv")
#: Where in the set-up of a drape the emulator's settings are added.
PLACES = {
    "prestretch": ("prestretch.0", "prestretch.1"),
    "weft more": ("prestretch.1",),
    "friction": ("friction",),
    "shear": ("shear_modulus_MPa",),
    "mass": ("mass_g_m2",),
}


def drape_applied(case: DrapeCase, amounts: Mapping[str, float]) -> DrapeCase:
    """Return the case with amounts of the emulator's settings added; a modulus takes the place of a measured law."""
    at = "depth_mm" if case.depths is None else f"depths_mm.{int(np.argmax(case.depths))}"
    if amounts.get("shear", 0.0):
        case = replace(case, shear_law=None)
    return applied(case, amounts, {**PLACES, "depth": (at,)})


def extend(
    out: Output,
    case: DrapeCase,
    material: MaterialDocument | None,
    sheet: Sheet,
    problem: DrapeProblem,
    found: Finding,
) -> Extension:
    """Return the case of the extended drape, and the fabric it reads."""
    fit = found.after.fit
    own = {one.name: float(v) for one, v in zip(problem.own, fit.x, strict=False)}
    larger = drape_applied(case, {"depth": own["depth"], **problem.amounts(fit.terms)})
    notes = []
    if "shear-stiffness" in fit.terms and case.shear_law is not None:
        notes.append("shear-stiffness: a modulus takes the place of the measured law of shear")
    if material is None:
        laws = (_thread(sheet.warp, own["warp"]), _thread(sheet.weft, own["weft"]))
        warp, weft = (str(out.path(suffix)) for suffix in THREADS)
        larger = replace(larger, warp=warp, weft=weft, thickness=sheet.thickness)
        return Extension(larger, dict(zip(THREADS, laws, strict=True)), notes)
    fabric = scaled_material(material, {name: own[name] for name in problem.draped.names})
    return Extension(
        replace(larger, material=str(out.path(FABRIC))), {FABRIC: dump_json(fabric.to_json())}, notes
    )


def _thread(law: SpringLaw, factor: float) -> bytes:
    """Return a measured law with its stress times ``factor``, as a uniaxial test."""
    rows = list(zip(law.knots - 1.0, factor * law.pieces[:, 1], strict=True))
    return csv_bytes(["strain [-]", "stress [MPa]"], rows)
