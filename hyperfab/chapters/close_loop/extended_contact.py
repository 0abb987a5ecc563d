"""The extended sheet: a material document with refitted constants, and the command that presses it with the terms."""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.chapters.close_loop.closing import Extension
from hyperfab.chapters.close_loop.recall import Recalled, reworded
from hyperfab.chapters.close_loop.softer import scaled_material
from hyperfab.documents.contact import ContactDocument
from hyperfab.documents.material import AtTemperature, MaterialDocument
from hyperfab.io.json_io import dump_json
from hyperfab.io.output import Output
from hyperfab.loop.contact import ContactProblem, effects_of
from hyperfab.loop.engine import Finding
from hyperfab.materials.effects.thermal_softening import factor
from hyperfab.materials.registry import bind

#: Where the refitted fabric is written.
FABRIC = ".model.fabric.json"


def extend(
    out: Output,
    recalled: Recalled,
    material: MaterialDocument,
    problem: ContactProblem,
    found: Finding,
    document: ContactDocument,
) -> Extension:
    """Return the command of the extended sheet, and the fabric it reads."""
    fit = found.after.fit
    factors = {name: float(v) for name, v in zip(problem.sheet.names, fit.x, strict=False)}
    fabric = refitted(material, factors)
    terms = {key: [float(v) for v in values] for key, (_, values) in fit.terms.items()}
    words: dict[str, str | None] = {"--against": None}
    notes: list[str] = []
    if "pretension" in terms:
        words["--prestretch"] = repr(document.setup.prestretch + terms["pretension"][0])
    if "friction" in terms:
        given = recalled.options.get("friction")
        words["--friction"] = repr(terms["friction"][0] + (float(given) if given else 0.0))
    if "rim-slip" in terms:
        slip = terms["rim-slip"][0]
        if len(terms["rim-slip"]) > 1:
            own = np.asarray(fit.x[: fit.own - 1])
            slip = float(problem.sheet.slips(own, effects_of(fit.terms), 1.0)[-1]) + problem.rim_slip
            slip = slip / problem.sheet.scale(own) - problem.rim_slip
            notes.append(
                "rim-slip: a clamp that holds at first is written as the spring that gives as much at the end"
            )
        words["--rim-slip"] = f"{problem.rim_slip + slip!r}mm^2/N"
    if "thermal-softening" in terms:
        _soften(fabric, problem, terms["thermal-softening"])
        met = np.concatenate([one.temperature for one in problem.files if one.temperature is not None])
        words["--temperature"] = f"{float(np.median(met))!r}degC"
    renamed = [
        str(out.path(FABRIC)) if word == recalled.options["material"] else word for word in recalled.words
    ]
    return Extension(reworded(renamed, words), {FABRIC: dump_json(fabric.to_json())}, notes)


def refitted(material: MaterialDocument, factors: dict[str, float]) -> MaterialDocument:
    """Return the fabric with other constants, and without the figures of the fit that no longer hold."""
    fabric = scaled_material(material, factors)
    for stale in ("fit", "stability", "stability_plane", "stable", "accepted", "models", "warnings", "objective",
                  "fit_on", "preparation", "left_out", "replicates"):  # fmt: skip
        setattr(fabric, stale, None)
    for direction in (fabric.directions or {}).values():
        direction.fit = direction.stability = direction.stability_plane = direction.stable = None
    fabric.files, fabric.provenance = [], None
    return fabric


def _soften(fabric: MaterialDocument, problem: ContactProblem, values: list[float]) -> None:
    """Write the softening as constants at each temperature met, which later commands interpolate."""
    met = np.concatenate([one.temperature for one in problem.files if one.temperature is not None])
    degrees = sorted({problem.reference_degC, *(float(v) for v in np.unique(np.round(2.0 * met) / 2.0))})
    linear = bind(fabric.model, fabric.parameters).law.linear
    place: Any
    for place in (fabric, *(fabric.directions or {}).values()):
        base = place.parameters
        place.temperatures = [
            AtTemperature(
                temperature_degC=one,
                parameters={
                    key: value
                    * (
                        float(factor(np.array(one), problem.reference_degC, *values))
                        if key in linear
                        else 1.0
                    )
                    for key, value in base.items()
                },
            )
            for one in degrees
        ]
    fabric.temperature_degC = problem.reference_degC
    form = "curved" if len(values) > 1 else "exponential"
    names = ("softening_1_K", "softening_1_K2")
    fabric.effects = [
        *(fabric.effects or []),
        {
            "id": "thermal-softening",
            "form": form,
            "parameters": dict(zip(names, values, strict=False)),
            "reference_degC": problem.reference_degC,
            "told_by": "temperatures",
        },
    ]
