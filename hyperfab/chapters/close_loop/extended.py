"""A material document in the catalogue's terms, as the loop reads it; and the extended model: an ordinary document with
one physical term more."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.close_loop.softening import nearest, soften
from hyperfab.chapters.fabric import ORTHOTROPIC, FabricDocument
from hyperfab.chapters.look import tested_by
from hyperfab.curve import TestCurve
from hyperfab.documents.material import Direction, MaterialDocument
from hyperfab.errors import InputError
from hyperfab.loop.fabric import FabricProblem
from hyperfab.loop.fitting import Fit
from hyperfab.loop.problem import Constant, Form, fixed
from hyperfab.materials.effects import anisotropy, compressibility, elastic_law, load_offset, rate
from hyperfab.materials.effects.anisotropy import REST
from hyperfab.materials.effects.fabric import AT_A_TEMPERATURE
from hyperfab.materials.effects.path import uniaxial_pull
from hyperfab.materials.effects.threads import GROUND
from hyperfab.materials.law import Law
from hyperfab.materials.orthotropic import ABSENT
from hyperfab.materials.orthotropic.determined import sought_by
from hyperfab.materials.registry import law as law_called

#: Forms that have no prediction where the tests state no times.
_NEEDS_TIMES: Mapping[str, Container[str]] = {"rate": rate.FORMS, "load-offset": load_offset.IN_TIME}
#: Effects that constants of the law tell, where the document says that they do.
_IN_THE_LAW = ("anisotropy", "elastic-law")
#: What documents mean that were written before a constant was: a set did not contract the strip.
UNSAID = {"contraction": 0.0}
#: The laws that may be the ground of one energy of the whole sheet.
_GROUNDS = ("yeoh-1", "yeoh-2", "yeoh-3", "yeoh-3-lni2")
#: What says how the threads are that a constant gives their stiffness.
_PART_OF = {
    "k2_warp": "k1_warp_MPa",
    "k2_weft": "k1_weft_MPa",
    "k2_bias": "k1_bias_MPa",
    "bias_deg": "k1_bias_MPa",
}
#: A test cut within this angle [deg] of warp or weft is a test of it.
_ALONG = 1.0


def in_terms(document: MaterialDocument, name: str, tests: Sequence[TestCurve]) -> MaterialDocument:
    """Return a document of one energy of the whole sheet as one that has its ground's law and the rest as effects.

    Constants at which nothing is there are left out, and stay so, unless those behind the document left them open and
    these ``tests`` tell them. Other documents are returned as they are.
    """
    sheet = FabricDocument(document, name).sheet()
    if sheet is None or any("ground" in item for item in document.effects or []):
        return document
    has = {key for key, value in sheet.parameters.items() if value != ABSENT[key]}
    law = next(law for law in map(law_called, _GROUNDS) if set(law.names) >= has & GROUND)
    ground = {key: sheet.parameters[key] for key in law.names}
    told = has | ({one.constant for one in document.undetermined or []} & {*sought_by(tests)[0]})
    own = [key for key in REST.names if _PART_OF.get(key, key) in told]
    found = document.model_copy()
    records: list[dict[str, Any]] = []
    if own:
        threads = {key: sheet.parameters[key] for key in own}
        record = {"id": "anisotropy", "form": "sheet", "parameters": threads, "told_by": REST.told_by}
        records.append({**record, "ground": ground, "law": law.name})
    else:  # a ground alone is the same along warp and weft
        found.model, found.parameters, found.directions = law.name, ground, None
    if "nu" in has:
        records.append({"id": "compressibility", "form": "uniform", "parameters": {"nu": sheet.parameters["nu"]}})
    found.effects = records + (document.effects or [])
    return found


def held_terms(
    document: MaterialDocument, name: str, entries: Mapping[str, Any], timed: bool
) -> dict[str, tuple[str, tuple[Constant, ...]]]:
    """Return the terms a document already has: effect id -> form and constants, found in the catalogue ``entries``.

    ``timed``: whether the tests state their times.
    """
    found: dict[str, tuple[str, tuple[Constant, ...]]] = {}
    for index, item in enumerate(document.effects or []):
        key = f"effects.{index}"
        kind, form_name, values = item.get("id"), item.get("form"), item.get("parameters")
        # No term is added twice to what the law's constants tell.
        if kind in _IN_THE_LAW and item.get("told_by") and "ground" not in item:
            continue
        effect = entries.get(str(kind))
        form = None if effect is None else next((f for f in effect.forms if f.name == form_name), None)
        if not timed and form_name in _NEEDS_TIMES.get(str(kind), ()):
            raise InputError(
                f"the effect {kind!r} of form {form_name!r} cannot be computed: not every test states its times",
                file=name,
                key=key,
                remedy="give every test a column time [s] or its rate [1/s], or take the effect out of the model",
            )
        if effect is None or form is None or not isinstance(values, Mapping):
            raise InputError(
                f"unknown effect {kind!r} of form {form_name!r}",
                file=name,
                key=key,
                remedy="remove it, or see docs/close-loop.md",
            )
        constants, values = [], {**UNSAID, **values}
        away = _stays_away(str(kind), form.name, values)
        for constant in form.constants:
            if constant.name in away:
                constants.append(fixed(f"{kind} {constant.name}", ABSENT[constant.name]))
                continue
            if constant.name not in values and constant not in form.each[1:]:
                raise InputError("is missing", file=name, key=f"{key}.parameters.{constant.name}")
            value = float(values.get(constant.name, _usual(form, values)))
            low, high = min(constant.low, value), max(constant.high, value)
            if effect.not_sought or constant.low == constant.high:
                low = high = value  # these data say nothing of it, or it is no unknown
            constants.append(Constant(f"{kind} {constant.name}", value, low, high, constant.scale))
        found[str(kind)] = (form.name, tuple(constants))
    return found


def _stays_away(kind: str, form: str, given: Container[str]) -> frozenset[str]:
    """Return the constants that a term has not among those ``given`` since nothing is there."""
    rest = kind == "anisotropy" and anisotropy.FORMS[form] is REST
    return frozenset(name for name in REST.names if rest and name not in given)


def _usual(form: Form, values: Mapping[str, Any]) -> float:
    """Return what a specimen has more than the first, in the mean of those told, for one that is not."""
    more = [float(values[constant.name]) for constant in form.each[1:] if constant.name in values]
    return sum(more) / (len(more) + 1)


def extend(document: MaterialDocument, problem: FabricProblem, fit: Fit, law: Law) -> MaterialDocument:
    """Return the document with refitted constants and the terms of ``fit``."""
    ground, across, had = problem.of_own(np.asarray(fit.x[: fit.own]))
    result = document.refitted()
    terms = fit.terms
    form, values = {**had, **terms}.get("anisotropy", ("", np.empty(0)))
    how = anisotropy.form_of({**had, **terms})
    whole = how is not None and how.whole
    # The keys of the document that tell an effect to every command.
    told_by = {} if how is None else {"anisotropy": how.told_by}
    if not whole:
        # One law of the whole sheet has no constants at each temperature: there the effect tells them itself.
        told_by["thermal-softening"] = "temperatures"
    records = _refitted(document, problem, had) + [
        {
            "id": name,
            "form": form,
            "parameters": problem.effect(name).form(form).named(values),
            **({"reference_degC": problem.fabric.reference_degC} if name in AT_A_TEMPERATURE else {}),
            **({"told_by": told_by[name]} if name in told_by else {}),
        }
        for name, (form, values) in terms.items()
    ]
    warp = dict(zip(law.names, map(float, ground), strict=True))
    weft = None if across is None else dict(zip(law.names, map(float, across), strict=True))
    own = dict(warp)
    if how is not None and not whole:
        warp, weft = (
            _along_and_across(law, warp, form, values, problem) if how.nearly else (warp, how.weft(law, warp, values))
        )
    for record in records:
        if record["id"] == "anisotropy" and how is not None and how.nearly:
            # The loop goes on from the ground and the term itself.
            record["ground"] = own
        added = elastic_law.FORMS.get(record["form"]) if record["id"] == "elastic-law" else None
        if added is not None and law.name in added.richer:
            result.model, more = added.richer[law.name], record["parameters"]
            warp, own = _richer(warp, more), _richer(own, more)
            weft = None if weft is None else _richer(weft, more)
            record["told_by"] = "model"
    if how is not None and whole:
        [sheet] = [record for record in records if record["id"] == "anisotropy"]
        # The loop goes on from the ground's own law; the other commands take the whole sheet's.
        sheet["law"] = law.name if set(own) == set(law.names) else result.model
        # None of the ground's is below zero: the fit leaves them there to rounding.
        warp = {name: max(value, 0.0) for name, value in how.constants(law_called(sheet["law"]), own, values).items()}
        result.model = ORTHOTROPIC
        for record in records:
            nu = _poisson_of(record)
            if nu is not None:
                warp["nu"] = nu
                record["told_by"] = how.told_by
    result.parameters = warp
    result.temperatures = None
    result.directions = None
    tests = _axes(problem, problem.fabric.strained({**had, **terms}, ground, across))
    result.tested = tested_by(tests)
    if weft is not None:
        # A test that states no direction is taken as pulled along the warp.
        square = [test for test in tests if abs(test.angle_deg - 90.0) <= _ALONG]
        along = [test for test in tests if not abs((test.angle_deg + 90.0) % 180.0 - 90.0) > _ALONG]
        result.directions = {
            "warp": Direction(parameters=warp, tested=tested_by(along)),
            "weft": Direction(parameters=weft, tested=tested_by(square)),
        }
    if "thermal-softening" in terms and whole:
        result.temperature_degC = problem.fabric.reference_degC
    elif "thermal-softening" in terms:
        known = problem.fabric.path.temperature_degC
        met = known[np.isfinite(known)]
        form, softening = terms["thermal-softening"]
        soften(result, list(softening), problem.fabric.reference_degC, met, form)
    result.effects = records or None
    return result


def _axes(problem: FabricProblem, stretch: Array) -> list[TestCurve]:
    """Return the tests with the ``stretch`` of their specimens, without the second one: of a general biaxial test each
    axis is a test already."""
    ends = np.cumsum([len(test.stretch) for test in problem.tests])[:-1]
    parts = zip(problem.tests, np.split(stretch, ends), strict=True)
    return [replace(test, stretch=part, stretch2=None) for test, part in parts]


def _refitted(
    document: MaterialDocument, problem: FabricProblem, had: Mapping[str, tuple[str, Array]]
) -> list[dict[str, Any]]:
    """Return the terms the document had, with their constants refitted."""
    found = [dict(item) for item in document.effects or []]
    for name, (form, values) in had.items():
        record = next(item for item in found if item.get("id") == name)
        own = problem.effect(name).form(form).named(values)
        away = _stays_away(name, form, record["parameters"])
        record["parameters"] = {key: value for key, value in own.items() if key not in away}
    return found


def _poisson_of(record: Mapping[str, Any]) -> float | None:
    """Return Poisson's ratio of a sheet's ground, None of a term that is not told by one."""
    if record["id"] != "compressibility":
        return None
    return compressibility.FORMS[record["form"]].poisson(np.array(list(record["parameters"].values())))


def _along_and_across(
    law: Law, ground: Mapping[str, float], form: str, values: Array, problem: FabricProblem
) -> tuple[dict[str, float], dict[str, float]]:
    """Return constants of the law for warp and weft that come nearest to the law with fibres, over the data's reach."""
    reach = np.linspace(1.0, float(np.max(problem.fabric.path.stretch)), 41)[1:]
    terms = {"anisotropy": (form, values)}
    warp, weft = (nearest(law, uniaxial_pull(reach, angle), ground, terms) for angle in (0.0, 90.0))
    return warp, weft


def _richer(own: Mapping[str, float], added: Mapping[str, float]) -> dict[str, float]:
    """Return the constants of the law that the terms of ``own`` and those ``added`` make together."""
    return {name: own.get(name, 0.0) + added.get(name, 0.0) for name in dict.fromkeys((*own, *added))}
