"""The extended model: an ordinary material document with one physical term more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hyperfab.chapters.close_loop.softer import soften
from hyperfab.chapters.tested import tested_by
from hyperfab.documents.material import Direction, MaterialDocument
from hyperfab.errors import InputError
from hyperfab.loop.fabric import FabricProblem, FabricTest
from hyperfab.loop.fitting import Fit
from hyperfab.loop.problem import Array, Constant
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import MODE_NAMES, uniaxial_pull
from hyperfab.materials.identification.design import Problem as LawProblem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.rows import Curve, Rows
from hyperfab.materials.law import Law

#: Effects that the document tells in keys of its own, which every command reads: no term is added twice.
_TOLD_ELSEWHERE = ("anisotropy",)
#: Effects that have no prediction where the tests state no times.
_NEEDS_TIMES = ("rate",)
#: A test cut within this angle [deg] of warp or weft is a test of it.
_ALONG = 1.0


def held_terms(
    document: MaterialDocument, name: str, entries: Mapping[str, Any]
) -> dict[str, tuple[str, tuple[Constant, ...]]]:
    """Return the terms a document already has: effect id -> form and constants, found in the catalogue ``entries``."""
    found: dict[str, tuple[str, tuple[Constant, ...]]] = {}
    for index, item in enumerate(document.effects or []):
        key = f"effects.{index}"
        kind, form_name, values = item.get("id"), item.get("form"), item.get("parameters")
        if kind in _TOLD_ELSEWHERE or item.get("told_by") in ("directions", "model"):
            continue
        effect = entries.get(str(kind))
        form = None if effect is None else next((f for f in effect.forms if f.name == form_name), None)
        if effect is None or form is None or not isinstance(values, Mapping):
            raise InputError(
                f"unknown effect {kind!r} of form {form_name!r}",
                file=name,
                key=key,
                remedy="remove it, or see docs/close-loop.md",
            )
        if kind in _NEEDS_TIMES and effect.not_sought:
            raise InputError(
                f"the effect {kind!r} cannot be computed for these tests: {effect.not_sought}",
                file=name,
                key=key,
                remedy="give every test a column time [s] or its rate [1/s], or take the effect out of the model",
            )
        constants = []
        for constant in form.constants:
            if constant.name not in values:
                raise InputError("is missing", file=name, key=f"{key}.parameters.{constant.name}")
            value = float(values[constant.name])
            low, high = min(constant.low, value), max(constant.high, value)
            if effect.not_sought:
                low = high = value  # these data say nothing of it
            constants.append(Constant(f"{kind} {constant.name}", value, low, high, constant.scale))
        found[str(kind)] = (form.name, tuple(constants))
    return found


def extend(document: MaterialDocument, problem: FabricProblem, fit: Fit, law: Law) -> MaterialDocument:
    """Return the document with refitted constants and the terms of ``fit``."""
    names = law.names
    count = len(names)
    warp = dict(zip(names, (float(v) for v in fit.x[:count]), strict=True))
    weft = (
        dict(zip(names, (float(v) for v in fit.x[count : 2 * count]), strict=True)) if problem.both else None
    )
    result = document.refitted()
    terms = fit.terms
    records = _refitted(document, problem, fit)
    for effect_id, (form, values) in terms.items():
        entry = problem.effect(effect_id).form(form)
        parameters = {c.name: float(v) for c, v in zip(entry.constants, values, strict=True)}
        record: dict[str, Any] = {"id": effect_id, "form": form, "parameters": parameters}
        if effect_id == "anisotropy":
            if form.endswith("fibres"):
                warp, weft = _along_and_across(law, warp, form, values, problem)
            else:
                weft = _weft(law, warp, form, values)
            record["told_by"] = "directions"
            if form == "diagonal":
                record["diagonal_softness"] = float(values[count])
        if effect_id == "thermal-softening":
            record["reference_degC"] = problem.fabric.reference_degC
            record["told_by"] = "temperatures"
        if (
            effect_id == "elastic-law"
            and form == "powers"
            and law.name in ("neo-hookean", "yeoh-1", "yeoh-2")
        ):
            result.model = "yeoh-3"
            warp = _richer(warp, parameters)
            weft = None if weft is None else _richer(weft, parameters)
            record["told_by"] = "model"
        records.append(record)
    result.parameters = warp
    result.temperatures = None
    result.directions = None
    result.tested = tested_by(_curves(problem.tests))
    if weft is not None:
        # A test that states no direction is taken as pulled along the warp.
        across = [test for test in problem.tests if abs(test.angle_deg - 90.0) <= _ALONG]
        along = [test for test in problem.tests if not abs((test.angle_deg + 90.0) % 180.0 - 90.0) > _ALONG]
        result.directions = {
            "warp": Direction(parameters=warp, tested=tested_by(_curves(along))),
            "weft": Direction(parameters=weft, tested=tested_by(_curves(across))),
        }
    if "thermal-softening" in terms:
        known = problem.fabric.path.temperature_degC
        met = known[np.isfinite(known)]
        form, softening = terms["thermal-softening"]
        soften(result, list(softening), problem.fabric.reference_degC, met, form)
    result.effects = records or None
    return result


def _curves(tests: Sequence[FabricTest]) -> list[tuple[str, Array, Array | None]]:
    """Return what ``tested_by`` takes; of a general biaxial test each axis is a curve."""
    return [(MODE_NAMES[test.mode], test.stretch, test.temperature_degC) for test in tests]


def _refitted(document: MaterialDocument, problem: FabricProblem, fit: Fit) -> list[dict[str, Any]]:
    """Return the terms the document had, with their constants refitted."""
    found = [dict(item) for item in document.effects or []]
    at = len(problem.law.names) * (2 if problem.both else 1)
    for name, (_, null) in problem.held.items():
        record = next(item for item in found if item.get("id") == name)
        keys = list(record["parameters"])
        own = [constant.name.removeprefix(f"{name} ") for constant in problem.own[at : at + len(null)]]
        record["parameters"] = {
            **{key: record["parameters"][key] for key in keys},
            **{key: float(value) for key, value in zip(own, fit.x[at : at + len(null)], strict=True)},
        }
        at += len(null)
    return found


def _weft(law: Law, warp: Mapping[str, float], form: str, values: Array) -> dict[str, float]:
    if form == "ratio":
        return law.scaled(warp, float(values[0]))
    return {name: warp[name] + float(value) for name, value in zip(law.names, values, strict=False)}


def _along_and_across(
    law: Law, ground: Mapping[str, float], form: str, values: Array, problem: FabricProblem
) -> tuple[dict[str, float], dict[str, float]]:
    """Return constants of the law for warp and weft that come nearest to the law with fibres, over the data's reach."""
    reach = np.linspace(1.0, float(np.max(problem.fabric.path.stretch)), 41)[1:]
    found = []
    for angle in (0.0, 90.0):
        pull = uniaxial_pull(reach, angle)
        both = Fabric(law, pull).stress(
            np.array([ground[name] for name in law.names]), None, {"anisotropy": (form, values)}
        )
        curve = Curve("uniaxial", reach, both, np.full_like(reach, 1.0 / float(np.max(np.abs(both)))))
        near = fit_law(LawProblem(law, Rows.of([curve])))
        found.append(dict(ground) if near is None else {k: near.material.parameters[k] for k in law.names})
    return found[0], found[1]


def _richer(own: Mapping[str, float], added: Mapping[str, float]) -> dict[str, float]:
    return {name: own.get(name, 0.0) + added.get(name, 0.0) for name in ("C10_MPa", "C20_MPa", "C30_MPa")}
