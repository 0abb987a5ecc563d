"""Documents upstream as unsure as one that is at fault may be: by what they state, else by what is taken for it."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.softening import widths
from hyperfab.chapters.fabric import ORTHOTROPIC
from hyperfab.chapters.press_contact.laws import USUAL_POISSON
from hyperfab.chapters.uncertainty.changed import Place, inside
from hyperfab.chapters.uncertainty.sources import Entry, Origin, of_document, read_as, together
from hyperfab.documents.foam import FoamDocument, in_full
from hyperfab.io.inputs import Inputs
from hyperfab.io.units import quantity
from hyperfab.materials.orthotropic import LINEAR

#: Quantities of a mold that are off by a share of themselves, by their section; those that are off by kelvins.
_SHARES = {
    "material": ("conductivity", "specific_heat"),
    "heater": ("power", "flux"),
    "convection": ("h",),
    "contact": ("h",),
}
_KELVINS = {
    "convection": ("ambient",),
    "radiation": ("ambient",),
    "temperature": ("value",),
    "run": ("start",),
}
#: What a thermocouple that a mold is held by, or a room, is off by [K].
_ROOM = 3.0
#: What a press is mounted off by [deg, mm].
_TILT, _OFFSET = 0.1, 0.2
#: What the Poisson's ratio of a foam is off by.
_POISSON = 0.1
#: What a sheet is mounted off by in stretch.
STRETCH_SD = 0.01
#: Constants of a law of the foam that are stresses.
_STRESSES = ("plateau", "modulus", "densification", "mu")
#: How the constants of one law err together: as much of their variance is its stiffness.
TOGETHER = 0.5


def unsure_mold(plain: Any, share: float) -> Any:
    """Return a mold's plain document in which what states no tolerance has one: ``share`` of itself, or kelvins.

    >>> unsure_mold({"convection": [{"on": "exposed", "h": "12 W/m^2/K", "ambient": "25 degC +- 1 K"}]}, 0.1)
    {'convection': [{'on': 'exposed', 'h': '12 W/m^2/K +- 10 %', 'ambient': '25 degC +- 1 K'}]}
    """
    found = copy.deepcopy(plain)
    for known, size in ((_SHARES, f"{100.0 * share:g} %"), (_KELVINS, f"{_ROOM:g} K")):
        for section, keys in known.items():
            given = found.get(section, {})
            for entry in given if isinstance(given, list) else given.values() if section == "material" else [given]:
                for key in keys:
                    text = entry.get(key)
                    if isinstance(text, str) and "+-" not in text and "±" not in text:
                        entry[key] = f"{text} +- {size}"
    return found


def unsure_fabric(plain: Any, share: float) -> Any:
    """Return a material's plain document whose constants are off by ``share`` of themselves beside what it states.

    Half of it is the law's stiffness, as constants of one law err together.
    """
    found = copy.deepcopy(plain)
    # An extended model tells its constants and effects as one: what it states of them holds.
    if found.get("joint_uncertainty") is not None:
        return found
    for place in _laws(found):
        constants = place["parameters"]
        order = [name for name, value in constants.items() if isinstance(value, float) and value != 0.0]
        if found["model"] == ORTHOTROPIC:
            order = [name for name in order if name in LINEAR]
        values = share * np.array([constants[name] for name in order]) * widths(found["model"], constants, order)
        covariance: Array = TOGETHER * np.outer(values, values) + (1.0 - TOGETHER) * np.diag(values**2)
        fit = place.setdefault("fit", {"E2": 0.0, "relative_rms": 0.0, "nrmse": 0.0, "points": 1})
        own = fit.get("uncertainty") or {}
        if own.get("covariance") is not None:
            at = [own["order"].index(name) for name in order]
            covariance = covariance + np.array(own["covariance"])[np.ix_(at, at)]
        fit["uncertainty"] = {
            "order": order,
            "covariance": covariance.tolist(),
            "specimens": own.get("specimens", 1),
            "degrees_of_freedom": 0,
            "source": "stated",
        }
    return found


def _laws(plain: Any) -> Iterator[Any]:
    """Yield what has constants: the document, or its directions; and those at each temperature."""
    # Directions of a whole sheet's law are that law again.
    ways = {} if plain["model"] == ORTHOTROPIC else plain.get("directions") or {}
    for part in ways.values() if {"warp", "weft"} <= set(ways) else [plain]:
        yield part
        yield from part.get("temperatures") or []


def mounted(plain: Any, case: PressCase) -> Any:
    """Return a sandwich's plain document with a place for all that may be off, the tilt of the case in it."""
    found = in_full(copy.deepcopy(plain))
    laws = _compressions(found)
    for _, law in laws:
        law.setdefault("factor", 1.0)
    ratios = found.get("poisson", {})
    found["poisson"] = ratios = dict(ratios) if isinstance(ratios, dict) else {"foam": ratios}
    if case.drape is not None and not any(law.get("law") == "hyperfoam" or "material" in law for _, law in laws):
        ratios.setdefault("foam", USUAL_POISSON)
    section = found.setdefault("press", {})
    across = [axis for axis in "xyz" if axis != case.axis]
    if not case.floating:
        tilt = section.setdefault("tilt", {})
        for axis, angle in zip(across, case.tilt or (None, None), strict=True):
            tilt[axis] = tilt.get(axis, "0 deg") if angle is None else f"{float(angle)!r} deg"
    offset = section.setdefault("offset", {})
    for axis in across:
        offset.setdefault(axis, "0 mm")
    return found


def of_sandwich(inputs: Inputs, name: str, share: float, stretched: bool) -> Iterator[tuple[str, Origin]]:
    """Yield what foam.toml may be off by, as ``mounted`` has it, each with its chapter: what it states, and of what it
    states no tolerance what is taken for it; where a drape has ``stretched`` the foam how much that thins it, too."""
    document, plain = read_as(inputs, name, FoamDocument)
    taken = set()
    for one in of_document(document, plain, name):
        taken |= {number.name for number in one.numbers}
        chapter = str(getattr(one.numbers[0], "place", ("",))[0])
        yield {"press": "mounting", "expansion": "temperature"}.get(chapter, "foam"), one

    def entry(place: Place, kind: str, unit: str) -> Entry:
        return Entry(name, place, float(quantity(inside(plain, place), kind)), unit)

    layers = [key for key in ("above", "below") if is_length(plain.get("fabric", {}).get(key))]
    alike = [
        [entry(("thickness",), "length", "mm")],
        # Laws of one foam at several temperatures err alike, as do two layers of one fabric.
        *([entry(at, "stress", "MPa") for at in places] for places in _stresses(plain)),
        [entry(("fabric", key), "length", "mm") for key in layers],
    ]
    for numbers in alike:
        left = [one for one in numbers if one.name not in taken]
        if left:
            yield "foam", together(left, share * np.array([one.value for one in left]))
    yield "foam", together([Entry(name, (*place, "factor"), 1.0) for place, _ in _compressions(plain)], share)
    ratio = plain["poisson"].get("foam")
    if stretched and isinstance(ratio, int | float):
        walls = (min(float(ratio), 0.0), 0.5)
        yield "foam", together([Entry(name, ("poisson", "foam"), float(ratio), walls=walls)], _POISSON)
    for key, kind, unit, sd in (("tilt", "angle", "deg", _TILT), ("offset", "length", "mm", _OFFSET)):
        for axis in plain["press"].get(key, {}):
            number = entry(("press", key, axis), kind, unit)
            if number.name not in taken:
                yield "mounting", together([number], sd)


def _compressions(plain: Any) -> list[tuple[Place, Any]]:
    """Return the laws of the foam, each with its place."""
    given = plain["compression"]
    if isinstance(given, list):
        return [(("compression", k), one) for k, one in enumerate(given)]
    return [(("compression",), given)]


def _stresses(plain: Any) -> list[list[Place]]:
    """Return the places of the constants of the foam's laws that are stresses, the same of all laws together."""
    alike: dict[Place, list[Place]] = {}
    for place, law in _compressions(plain):
        for key in (one for one in _STRESSES if one in law):
            many = isinstance(law[key], list)
            terms: list[Place] = [(key, k) for k in range(len(law[key]))] if many else [(key,)]
            for at in terms:
                alike.setdefault(at, []).append((*place, *at))
    return list(alike.values())


def is_length(text: object) -> bool:
    """Whether a layer of fabric is told by its thickness, not by its document."""
    return isinstance(text, str) and not text.endswith(".json")
