"""The extended press: a foam.toml with refitted constants and the found terms, and the command that presses it."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.finalise import Extension
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.inputs import ALUMINIUM
from hyperfab.chapters.press_contact.result import Told
from hyperfab.io.output import Output
from hyperfab.io.toml_io import load_toml
from hyperfab.io.units import quantity
from hyperfab.loop.engine import Finding
from hyperfab.loop.press import PressProblem
from hyperfab.loop.press_reading import VARIATION

#: Where the new sandwich is written.
FOAM = ".model.foam.toml"


def extend(
    job: Job, out: Output, case: PressCase, told: Told, problem: PressProblem, found: Finding
) -> Extension:
    """Return the case of the extended press, and the files it reads."""
    name = case.foam
    foam = copy.deepcopy(dict(load_toml(job.inputs.read(name), name)))
    fit = found.after.fit
    own = {one.name: float(v) for one, v in zip(problem.own, fit.x, strict=False)}
    amounts = problem.amounts(fit.terms)
    files: dict[str, bytes] = {}
    _relocate(foam, os.path.dirname(name), str(out.path("").parent))
    _stiffen(foam, own["foam.compression"])
    thickness = quantity(foam["thickness"], "length") * own["foam.thickness"]
    foam["thickness"] = f"{thickness!r} mm"
    if case.gap is not None:
        case = replace(case, gap=max(case.gap + own.get("gap", 0.0), 0.0))
    if case.force is not None:
        case = replace(case, force=case.force * own.get("force", 1.0))
    notes: list[str] = []
    if "tilt_deg.x" in amounts:
        case = _tilt(case, foam, told, amounts)
    # A table of it would be read at the temperature that the molds' growth is told by.
    by_table = isinstance(foam.get("shrinkage", {}).get("amount"), dict)
    if "foam.lost" in amounts or (by_table and "strain.male" in amounts):
        _shrink(foam, told, amounts.get("foam.lost", 0.0))
    if "relaxation.share" in amounts:
        foam["relaxation"] = _relaxation(foam, amounts, problem)
    _vary(foam, told, amounts)
    if "strain.male" in amounts:
        more = amounts["strain.male"], amounts["strain.female"]
        case = _hot(case, foam, told, more, notes)
    if "compliance_mm_kN" in amounts:
        total = problem.setting.compliance + 1e-3 * amounts["compliance_mm_kN"]
        case = replace(case, frame_stiffness=1.0 / total)
    files[FOAM] = tomli_w.dumps(foam).encode()
    return Extension(replace(case, foam=str(out.path(FOAM)), design_gap=None), files, notes)


def _tilt(case: PressCase, foam: dict[str, Any], told: Told, amounts: Mapping[str, float]) -> PressCase:
    """Write the tilt about the drawing's axes, in place of what the case has of it."""
    turned = told.frame.outward(np.array([amounts["tilt_deg.x"], amounts["tilt_deg.y"], 0.0]))
    before = foam.setdefault("press", {}).get("tilt", {})
    if case.tilt is not None:
        across = (axis for axis in "xyz" if axis != case.axis)
        before = {axis: f"{angle!r} deg" for axis, angle in zip(across, case.tilt, strict=True)}
    foam["press"]["tilt"] = {
        axis: f"{quantity(before.get(axis, '0 deg'), 'angle') + float(angle)!r} deg"
        for axis, angle in zip("xyz", turned, strict=True)
        if axis != told.frame.axis
    }
    return replace(case, tilt=None)


def _shrink(foam: dict[str, Any], told: Told, amount: float) -> None:
    """Write the share of the thickness that is lost, the document's and then ``amount`` of the rest."""
    section = dict(foam.get("shrinkage", {}))
    lost = 1.0 - (1.0 - told.foam.lost) * (1.0 - amount)
    if "time" in section:
        dwell, time = quantity(section["dwell"], "time"), quantity(section["time"], "time")
        lost /= -float(np.expm1(-dwell / time))
    foam["shrinkage"] = {**section, "amount": min(lost, 0.9)}


def _vary(foam: dict[str, Any], told: Told, amounts: Mapping[str, float]) -> None:
    """Add to the terms of the thickness, which the document names by the drawing's axes."""
    one, other = (axis for axis in "xyz" if axis != told.frame.axis)
    for name, coefficient in amounts.items():
        if name.startswith(VARIATION):
            section = foam.setdefault("variation", {})
            term = one * name.count("x") + other * name.count("y")
            section[term] = float(section.get(term, 0.0)) + coefficient


def _stiffen(foam: dict[str, Any], factor: float) -> None:
    """Multiply what the sandwich answers to a closing: the stresses of all its laws."""
    given = foam["compression"]
    fabric = foam.get("fabric", {}).get("compression")
    for law in [*(given if isinstance(given, list) else [given]), *([fabric] if fabric else [])]:
        law["factor"] = factor * law.get("factor", 1.0)


def _relaxation(
    foam: Mapping[str, Any], amounts: Mapping[str, float], problem: PressProblem
) -> dict[str, Any]:
    """Return the document's relaxation and beside it the one that was found, of what that leaves of the pressure."""
    given = dict(foam.get("relaxation", {}))
    share = given.get("share", 0.0)
    shares = [*share] if isinstance(share, list) else [share] if share else []
    times = given.get("time", "1 s")
    times = [*times] if isinstance(times, list) else [times] * len(shares)
    longest = max(
        (float(np.max(one.time_s)) for one in problem.readings if one.time_s is not None), default=60.0
    )
    dwell = given.get("dwell") or foam.get("shrinkage", {}).get("dwell") or f"{longest!r} s"
    seconds = quantity(dwell, "time")
    lasting = [
        s * -float(np.expm1(-seconds / quantity(t, "time"))) for s, t in zip(shares, times, strict=True)
    ]
    faded, slow = amounts["relaxation.share"], amounts.get("relaxation.time_s")
    if slow is None or "relaxation.power" in amounts:
        if slow is not None:
            # A stretched exponential has no key: what has faded by the end of the dwell.
            faded *= -float(np.expm1(-((seconds / slow) ** amounts["relaxation.power"])))
        # Long over by the end of the dwell.
        slow = seconds / 40.0
    faded *= 1.0 - sum(lasting)
    if not shares:
        return {"share": faded, "time": f"{slow!r} s", "dwell": dwell}
    return {"share": [*shares, faded], "time": [*times, f"{slow!r} s"], "dwell": dwell}


def _hot(
    case: PressCase, foam: dict[str, Any], told: Told, more: tuple[float, float], notes: list[str]
) -> PressCase:
    """Let both molds have the strain that was found, by their coefficients at the temperature they have."""
    section = dict(foam.get("expansion", {}))
    if not all(grown.even for grown in told.grown):
        notes.append(
            "thermal-expansion: the fields of temperature give way to even growth by their means and what was found"
        )
    warm = told.grown[0].temperature
    if abs(warm - told.reference) < 1.0 or abs(warm - told.grown[1].temperature) > 1e-6 or notes:
        coefficient = float(np.interp(told.reference, *ALUMINIUM))
        warm = told.reference + (told.grown[0].strain + more[0]) / coefficient
        case = replace(case, temperature=warm, male_heat=None, female_heat=None)
    for side, grown, extra in zip(("male", "female"), told.grown, more, strict=True):
        value = (grown.strain + extra) / (warm - told.reference)
        if value < 0.0:
            notes.append(f"thermal-expansion: the {side} mold would shrink; its coefficient is taken as 0")
        section[side] = f"{max(value, 0.0)!r} 1/K"
    foam["expansion"] = section
    return case


def _relocate(node: Any, old: str, new: str) -> None:
    """Count the names of tables and documents from the new document's folder."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in list(items):
        named = isinstance(value, str) and (key == "table" or value.endswith(".json"))
        if named and not os.path.isabs(value):
            node[key] = os.path.relpath(Path(old) / value, new or ".")
        else:
            _relocate(value, old, new)
