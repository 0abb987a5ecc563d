"""The extended press: a foam.toml with refitted constants and the found terms, and the command that presses it."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.extended_mold import relocate
from hyperfab.chapters.close_loop.finalise import Extension
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.inputs import ALUMINIUM
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.documents.foam import in_full
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output
from hyperfab.io.toml_io import dump_toml, load_toml
from hyperfab.io.units import quantity
from hyperfab.loop.catalogue.press import softened
from hyperfab.loop.engine import Finding
from hyperfab.loop.press import PressProblem
from hyperfab.loop.press_reading import Frame

#: Where the new sandwich is written.
FOAM = ".model.foam.toml"
#: Where a set law is written that goes with the strain.
SET = ".model.set.csv"
#: A law of set that holds from the first moment on, at any temperature: its coldest row [degC], and its dwell [s].
_COLDEST, _AT_ONCE = -200.0, 1e-6
#: How far apart [K] laws are written at most where softening is not linear in temperature.
_SOFTENING_STEP = 20.0


@dataclass
class _Draft:
    """A press on its way to the extended one.

    case, foam  what the found terms are written into: the command's words, and foam.toml as people wrote it
    told        the press as it was given, and ``problem`` what was fitted to its readings
    force       [N] that the extended press closes with, at the end of the longest hold
    stem        of the names of ``files`` that foam.toml reads, by suffix
    notes       what neither has a key for
    """

    case: PressCase
    foam: dict[str, Any]
    told: PressResult
    problem: PressProblem
    force: float
    stem: str
    files: dict[str, bytes] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def extend(
    job: Job, out: Output, case: PressCase, told: PressResult, problem: PressProblem, found: Finding
) -> Extension:
    """Return the case of the extended press, and the files it reads."""
    foam = in_full(copy.deepcopy(dict(load_toml(job.inputs.read(case.foam), case.foam))))
    relocate(foam, (os.path.dirname(case.foam), str(out.path("").parent)))
    fit = found.after.fit
    force = problem.force_at(fit.x[: fit.own], fit.terms, _longest(problem))
    draft = _Draft(case, foam, told, problem, force, out.path("").name)
    own = problem.as_stated(fit.x[: fit.own])
    foam["thickness"] = f"{quantity(foam['thickness'], 'length') * own['foam.thickness']!r} mm"
    if case.gap is not None:
        draft.case = replace(draft.case, gap=max(case.gap + own.get("gap", 0.0), 0.0))
    if case.force is not None:
        draft.case = replace(draft.case, force=case.force * own.get("force", 1.0))
    for name, (form, values) in fit.terms.items():
        WRITERS[name](draft, problem.effect(name).form(form).named(values))
    _stiffen(foam, own["foam.compression"])
    draft.files[FOAM] = dump_toml(foam)
    case = replace(draft.case, foam=str(out.path(FOAM)), design_gap=None)
    return Extension(case, draft.files, draft.notes)


def _tilt(draft: _Draft, at: Mapping[str, float]) -> None:
    """Write the tilt about the drawing's axes, in place of what the case has of it."""
    case, section = draft.case, draft.foam.setdefault("press", {})
    before = section.get("tilt", {})
    if case.tilt is not None:
        across = (axis for axis in "xyz" if axis != case.axis)
        before = {axis: f"{angle!r} deg" for axis, angle in zip(across, case.tilt, strict=True)}
    section["tilt"] = _along_axes(draft, before, (at["tilt_x_deg"], at["tilt_y_deg"]), "angle", "deg")
    draft.case = replace(case, tilt=None)


def _offset(draft: _Draft, at: Mapping[str, float]) -> None:
    """Add to how far the female is mounted off the axis, along the drawing's axes."""
    section = draft.foam.setdefault("press", {})
    shift = (at["offset_x_mm"], at["offset_y_mm"])
    section["offset"] = _along_axes(draft, section.get("offset", {}), shift, "length", "mm")


def _along_axes(
    draft: _Draft, before: Mapping[str, str], more: tuple[float, float], kind: str, unit: str
) -> dict[str, str]:
    """Return what is told along the drawing's axes across the closing axis, with ``more`` along the frame's added."""
    frame = draft.told.frame
    return {
        axis: f"{quantity(before.get(axis, f'0 {unit}'), kind) + float(by)!r} {unit}"
        for axis, by in zip("xyz", frame.outward(np.array([*more, 0.0])), strict=True)
        if axis != frame.axis
    }


def _shrink(draft: _Draft, at: Mapping[str, float]) -> None:
    """Write the share of the thickness that is lost, the document's and then the found one of the rest."""
    section = dict(draft.foam.get("shrinkage", {}))
    lost = 1.0 - (1.0 - draft.told.model.foam.lost) * (1.0 - at["amount"])
    slow = at.get("time_s")
    if slow is None and "time" in section:
        dwell, time = quantity(section["dwell"], "time"), quantity(section["time"], "time")
        lost /= -float(np.expm1(-dwell / time))
    if slow is not None:
        section |= {"time": f"{slow!r} s", "dwell": _dwell(draft, "shrinkage", "relaxation")}
    draft.foam["shrinkage"] = {**section, "amount": min(lost, 0.9)}


def _longest(problem: PressProblem) -> float:
    """Return the longest time [s] that was read, a minute where none was."""
    return max((float(np.max(one.time_s)) for one in problem.files if one.time_s is not None), default=60.0)


def _dwell(draft: _Draft, *sections: str) -> str:
    """Return how long the press stays closed, as the first of the ``sections`` that tells, else as long as was read."""
    told = (draft.foam.get(name, {}).get("dwell") for name in sections)
    return next((one for one in told if one), f"{_longest(draft.problem)!r} s")


def _vary(draft: _Draft, at: Mapping[str, float]) -> None:
    """Add to the terms of the thickness, which the document names by the drawing's axes."""
    one, other = (axis for axis in "xyz" if axis != draft.told.frame.axis)
    section = draft.foam.setdefault("variation", {})
    for name, coefficient in at.items():
        term = one * name.count("x") + other * name.count("y")
        section[term] = float(section.get(term, 0.0)) + coefficient


def _give_way(draft: _Draft, at: Mapping[str, float]) -> None:
    """Write how the fabrics give way across."""
    soft = at["compliance_1_MPa"]
    if soft > 0.0:
        draft.foam["fabric"]["compression"] = (
            {"law": "hyperfoam", "mu": [f"{0.5 / soft!r} MPa"], "alpha": [-at["stiffening"]], "nu": [0.0]}
            if "stiffening" in at
            else {"law": "linear", "modulus": f"{1.0 / soft!r} MPa"}
        )


def _soften(draft: _Draft, at: Mapping[str, float]) -> None:
    """Write the foam's law at the temperature it holds at, at those met, and between them."""
    holds, setting = draft.problem.foam.law_degC, draft.problem.setting
    assert holds is not None
    given = draft.foam["compression"]
    law = dict(given[0] if isinstance(given, list) else given)
    met = {setting.temperature, holds}
    met |= {one.temperature for one in draft.problem.files if one.temperature is not None}
    between = np.arange(min(met), max(met), _SOFTENING_STEP)
    factor = float(law.get("factor", 1.0))
    draft.foam["compression"] = [
        {**law, "factor": factor * softened(one - holds, at), "temperature": f"{one!r} degC"}
        for one in sorted(met | set(between.tolist()))
    ]


def _set(draft: _Draft, at: Mapping[str, float]) -> None:
    """Write the share of the strain that stays: in place of ``recovery`` where the document has that."""
    foam, told = draft.foam, draft.told
    back, more = told.model.foam.recovery, at.get("share_more", 0.0)
    given = told.model.files.document.set
    share = at["share"] + (1.0 - back if back is not None else given if isinstance(given, float) else 0.0)
    least = min(max(share, 0.0), 1.0)
    if "shrinkage" in foam:
        foam["shrinkage"].pop("recovery", None)
    if more == 0.0 and back is not None:
        foam.setdefault("shrinkage", {})["recovery"] = 1.0 - least
        return
    foam["set"] = least
    if more != 0.0:
        # Straight between no strain and a whole one, but for where nothing or all of it stays.
        bends = [round((end - share) / more, 6) for end in (0.0, 1.0)]
        strains = sorted({0.0, 1.0, *(bend for bend in bends if 0.0 < bend < 1.0)})
        rows = [(_COLDEST, _AT_ONCE, strain, min(max(share + more * strain, 0.0), 1.0)) for strain in strains]
        draft.files[SET] = csv_bytes(["temperature [degC]", "dwell [s]", "strain [-]", "set [-]"], rows)
        foam["set"] = {"table": draft.stem + SET}
    if draft.case.dwell is None:
        draft.notes.append("set: hf press-contact tells the formed thickness with --dwell")


def _yield(draft: _Draft, at: Mapping[str, float]) -> None:
    """Let the frame yield by the model's own and what was found."""
    total = draft.problem.setting.compliance + 1e-3 * at.get("compliance_mm_kN", 0.0)
    if at.get("play_mm", 0.0) > 0.0:
        # The document has a spring: one that opens as far at the force the press closes with.
        frame = Frame(total, at["play_mm"], at["taken_up_N"])
        total = float(frame.opens(draft.force)) / draft.force
        draft.notes.append(
            f"frame-compliance: the document has a frame of one stiffness, that at {draft.force:.3g} N is written; "
            f"below, the frame opens further, by play of {at['play_mm']:.3g} mm"
        )
    if total > 0.0:
        draft.case = replace(draft.case, frame_stiffness=1.0 / total)


def _stiffen(foam: dict[str, Any], factor: float) -> None:
    """Multiply what the sandwich answers to a closing: the stresses of all its laws."""
    given = foam["compression"]
    fabric = foam.get("fabric", {}).get("compression")
    for law in [*(given if isinstance(given, list) else [given]), *([fabric] if fabric else [])]:
        law["factor"] = factor * law.get("factor", 1.0)


def _relax(draft: _Draft, at: Mapping[str, float]) -> None:
    """Write the document's relaxation and beside it the one that was found, of what that leaves of the pressure."""
    foam = draft.foam
    given = dict(foam.get("relaxation", {}))
    share = given.get("share", 0.0)
    shares = [*share] if isinstance(share, list) else [share] if share else []
    times = given.get("time", "1 s")
    times = [*times] if isinstance(times, list) else [times] * len(shares)
    dwell = _dwell(draft, "relaxation", "shrinkage")
    seconds = quantity(dwell, "time")
    lasting = [s * -float(np.expm1(-seconds / quantity(t, "time"))) for s, t in zip(shares, times, strict=True)]
    faded, slow = at["share"], at.get("time_s")
    if slow is None or "power" in at:
        if slow is not None:
            # A stretched exponential has no key: what has faded by the end of the dwell.
            faded *= -float(np.expm1(-((seconds / slow) ** at["power"])))
        # Long over by the end of the dwell.
        slow = seconds / 40.0
    faded *= 1.0 - sum(lasting)
    foam["relaxation"] = (
        {"share": [*shares, faded], "time": [*times, f"{slow!r} s"], "dwell": dwell}
        if shares
        else {"share": faded, "time": f"{slow!r} s", "dwell": dwell}
    )


def _grow(draft: _Draft, at: Mapping[str, float]) -> None:
    """Let both molds have the strain that was found, by their coefficients at the temperature they have."""
    foam, told = draft.foam, draft.told
    # A table of it would be read at the temperature that the molds' growth is told by.
    if isinstance(foam.get("shrinkage", {}).get("amount"), dict):
        _shrink(draft, {"amount": 0.0})
    more = (at["strain"], at["strain"] + at.get("female_more", 0.0))
    section = dict(foam.get("expansion", {}))
    uneven = not all(grown.even for grown in told.model.grown)
    if uneven:
        draft.notes.append(
            "thermal-expansion: the fields of temperature give way to even growth by their means and what was found"
        )
    warm = told.model.grown[0].temperature
    if abs(warm - told.reference) < 1.0 or abs(warm - told.model.grown[1].temperature) > 1e-6 or uneven:
        coefficient = float(np.interp(told.reference, *ALUMINIUM))
        warm = told.reference + (told.model.grown[0].strain + more[0]) / coefficient
        draft.case = replace(draft.case, temperature=warm, male_heat=None, female_heat=None)
    for side, grown, extra in zip(("male", "female"), told.model.grown, more, strict=True):
        value = (grown.strain + extra) / (warm - told.reference)
        if value < 0.0:
            draft.notes.append(f"thermal-expansion: the {side} mold would shrink; its coefficient is taken as 0")
        section[side] = f"{max(value, 0.0)!r} 1/K"
    foam["expansion"] = section


#: What writes the constants of an entry, by their names, into the extended press.
WRITERS: Mapping[str, Callable[[_Draft, Mapping[str, float]], None]] = {
    "fabric-compression": _give_way,
    "foam-relaxation": _relax,
    "foam-shrinkage": _shrink,
    "foam-softening": _soften,
    "frame-compliance": _yield,
    "lateral-shift": _offset,
    "set": _set,
    "thermal-expansion": _grow,
    "thickness-variation": _vary,
    "tilt": _tilt,
}
