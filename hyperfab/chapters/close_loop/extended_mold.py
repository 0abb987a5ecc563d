"""The extended mold: the document as people wrote it, with refitted constants and the found terms."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import tomli_w

from hyperfab.documents.mold import MoldDocument
from hyperfab.io.csv_write import csv_bytes
from hyperfab.loop.fitting import Fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.problem import Array
from hyperfab.thermal.tables import Table

_UNEVEN = "{}, for which a mold document has no key; the extended model has the mean throughout"
_FILES = ("table", "stl", "schedule", "document")
#: Endings of the tables an extended mold may have beside it.
TABLES = (
    *(f".{what}-*.csv" for what in ("film", "power", "conductivity", "specific-heat")),
    ".ambient.csv",
    ".sky.csv",
)


def extend(
    data: Mapping[str, Any],
    document: MoldDocument,
    problem: HeatProblem,
    fit: Fit,
    stem: str,
    folders: tuple[str, str],
) -> tuple[dict[str, bytes], list[str]]:
    """Return the files of the extended mold by suffix, and what of it ``hf mold-heat`` cannot obey.

    ``stem`` is the output's, for the names of tables; ``folders`` are that of the document and that of the
    output: names of other files are counted from the latter.
    """
    mold = copy.deepcopy(dict(data))
    _relocate(mold, folders)
    files: dict[str, bytes] = {}
    factors = dict(zip((constant.name for constant in problem.own), (float(v) for v in fit.x), strict=False))
    # A term at its null is not there: the document stays the one that was given.
    terms = {name: {c.name: float(v) for c, v in zip(fit.forms[name].constants, values, strict=True)}
             for name, (_, values) in fit.terms.items()
             if tuple(values) != fit.forms[name].null}  # fmt: skip
    _scale(mold, document, problem, factors, terms, files)
    if set(terms.get("power-loss", {})) - {"lost_share"}:
        _heat_as_given_off(mold, document, problem.given_off(fit.x[: fit.own], fit.terms), files)
    notes = _add(mold, document, problem, terms, files, factors.get("ambient", 0.0))
    _named(mold, stem)
    files[".model.toml"] = tomli_w.dumps(mold).encode()
    return files, notes


def _named(node: Any, stem: str) -> None:
    """Give the new tables the name they are written under: a suffix after the output's stem."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in list(items):
        if key in _FILES and isinstance(value, str) and value.startswith(".") and value.count("/") == 0:
            node[key] = f"{stem}{value}"
        else:
            _named(value, stem)


def _relocate(node: Any, folders: tuple[str, str]) -> None:
    """Count the names of files from the new document's folder."""
    if isinstance(node, dict):
        for key, value in node.items():
            if key in _FILES and isinstance(value, str) and not os.path.isabs(value):
                node[key] = os.path.relpath(os.path.join(folders[0], value), folders[1] or ".")
            else:
                _relocate(value, folders)
    elif isinstance(node, list):
        for item in node:
            _relocate(item, folders)


def _scale(
    mold: dict[str, Any],
    document: MoldDocument,
    problem: HeatProblem,
    factors: Mapping[str, float],
    terms: Mapping[str, Mapping[str, float]],
    files: dict[str, bytes],
) -> None:
    reduced = problem.runs[0].mold
    exponent = terms.get("convection-law", {}).get("exponent", 0.0)
    for index, section in enumerate(document.convection):
        factor = factors.get(f"convection.{index}.h", 1.0)
        film = reduced.films[index].film
        if exponent == 0.0 and isinstance(section.h, float):
            mold["convection"][index]["h"] = f"{section.h * factor!r} W/m^2/K"
        elif factor != 1.0 or exponent != 0.0:
            air = float(reduced.films[index].ambient.y[0])
            above = np.array([0.5, 2.0, 5.0, 10.0, 20.0, 40.0, 70.0, 100.0, 150.0, 200.0, 300.0, 400.0])
            at = np.unique(np.concatenate([film.x, air + above]))
            h = factor * film(at) * (np.maximum(np.abs(at - air), 0.5) / 30.0) ** exponent
            name = f".film-{index}.csv"
            files[name] = _csv("temperature [degC]", "h [W/m^2/K]", at, h)
            mold["convection"][index]["h"] = {"table": name}
    drift = terms.get("property-drift", {})
    for key, stuff in document.material.items():
        for what, unit in (("conductivity", "W/m/K"), ("specific_heat", "J/kg/K")):
            value = getattr(stuff, what)
            factor = factors.get(f"material.{key}.{what}", 1.0)
            rate, bend = drift.get(f"{what}_per_K", 0.0), drift.get(f"{what}_per_K2", 0.0)
            if rate == bend == 0.0:
                if isinstance(value, float):
                    mold["material"][key][what] = f"{value * factor!r} {unit}"
                    continue
                if factor == 1.0:
                    continue
            zero, plain = reduced.reference_degC, problem.tables[f"{key}.{what}"]
            beside = (
                np.array([zero - 50.0, zero]) if bend == 0.0 else np.arange(zero - 50.0, zero + 490.0, 10.0)
            )
            at = np.unique(np.concatenate([plain.x, beside, [zero + 500.0]]))
            scaled = factor * plain(at) * np.maximum(1.0 + (rate + bend * (at - zero)) * (at - zero), 0.05)
            name = f".{what.replace('_', '-')}-{key}.csv"
            column = {"conductivity": "conductivity", "specific_heat": "specific heat"}[what]
            files[name] = _csv("temperature [degC]", f"{column} [{unit}]", at, scaled)
            mold["material"][key][what] = {"table": name}
    share = 1.0 - terms.get("power-loss", {}).get("lost_share", 0.0)
    for index, heater in enumerate(document.heater):
        factor = factors.get(f"heater.{index}.power", 1.0) * share
        if factor == 1.0:
            continue
        if heater.schedule is not None:
            table: Table = reduced.heaters[index][1]
            name = f".power-{index}.csv"
            files[name] = _csv("time [s]", "power [W]", table.x, factor * table.y)
            mold["heater"][index]["schedule"] = name
        elif heater.power is not None:
            mold["heater"][index]["power"] = f"{heater.power * factor!r} W"
        elif heater.flux is not None:
            mold["heater"][index]["flux"] = f"{heater.flux * factor!r} W/m^2"
    if isinstance(document.run.start, float):
        mold["run"]["start"] = f"{document.run.start + factors.get('run.start', 0.0)!r} degC"
        for index, part in enumerate(document.part):
            warmer = factors.get(f"part.{part.name}.start", 0.0)
            if warmer != 0.0 or part.start is not None:
                begin = document.run.start if part.start is None else part.start
                begin += factors.get("run.start", 0.0) + warmer
                mold["part"][index]["start"] = f"{begin!r} degC"
    for kind in ("convection", "radiation"):
        for index, cooled in enumerate(getattr(document, kind)):
            if isinstance(cooled.ambient, float):
                mold[kind][index]["ambient"] = f"{cooled.ambient + factors.get('ambient', 0.0)!r} degC"
    added = _added(terms.get("contact-resistance", {}), problem)
    for index, contact in enumerate(document.contact):
        h = contact.h * factors.get(f"contact.{index}.h", 1.0)
        mold["contact"][index]["h"] = f"{h / (1.0 + added[1][index] * h)!r} W/m^2/K"


def _heat_as_given_off(
    mold: dict[str, Any], document: MoldDocument, powers: Sequence[Table], files: dict[str, bytes]
) -> None:
    """Write the power that reached the mold in this run as the heaters' schedules; a thermostat keeps its rating."""
    for index, (heater, power) in enumerate(zip(document.heater, powers, strict=True)):
        if heater.control is not None:
            continue
        for key in ("power", "flux"):
            mold["heater"][index].pop(key, None)
        at, first = np.unique([float(f"{time:.9g}") for time in power.x], return_index=True)
        files[f".power-{index}.csv"] = _csv("time [s]", "power [W]", at, np.maximum(power.y[first], 0.0))
        mold["heater"][index]["schedule"] = f".power-{index}.csv"


def _added(values: Mapping[str, float], problem: HeatProblem) -> tuple[list[float], list[float]]:
    """Return the resistances [m^2 K/W] of joints without one in the document, and those added to its joints'."""
    new, old = len(problem.pairs), len(problem.joints)
    one = values.get("resistance_m2K_W")
    if one is not None:
        return [one] * new, [0.0 if new else one] * old
    each = [values.get(f"resistance_{k}_m2K_W", 0.0) for k in range(1, new + old + 1)]
    return each[:new], each[new:]


def _add(
    mold: dict[str, Any],
    document: MoldDocument,
    problem: HeatProblem,
    terms: Mapping[str, Mapping[str, float]],
    files: dict[str, bytes],
    warmer: float,
) -> list[str]:
    """Add the terms to the document; return what it has no key for; the ambient was found to be ``warmer`` [K]."""
    notes = []
    cooled = document.convection[0] if document.convection else None
    ambient = mold["convection"][0]["ambient"] if cooled is not None else "25.0 degC"
    for name, values in terms.items():
        if name == "radiation":
            places = [place for section in mold["convection"] for place in _listed(section["on"])]
            sky = _warmer(ambient, values.get("surroundings_K", 0.0), problem, files)
            mold.setdefault("radiation", []).append(
                {"on": places, "emissivity": values["emissivity"], "ambient": sky}
            )
        elif name == "contact-resistance":
            for pair, resistance in zip(problem.pairs, _added(values, problem)[0], strict=True):
                h = 1.0 / max(resistance, 1e-7)
                mold.setdefault("contact", []).append({"between": list(pair), "h": f"{h!r} W/m^2/K"})
            if "closing_per_K" in values:
                notes.append(
                    f"contact-resistance: the joint conducts {100.0 * values['closing_per_K']:.3g} % better a kelvin, "
                    "for which a mold document has no key; the extended model has its conductance at the start"
                )
            elif "from_middle" in values:
                notes.append(_UNEVEN.format("contact-resistance: the joint is better in places"))
        elif name == "sensor-lag":
            numbers = {name: k for k, name in enumerate(problem.names, start=1)}
            for probe in mold["probe"]:
                own = values.get(f"of_probe_{numbers.get(probe['name'], 1)}_s", 0.0)
                probe["lag"] = f"{max(problem.lag_s + values['lag_s'] + own, 0.0)!r} s"
            if values.get("second_lag_s", 0.0) > 0.0:
                notes.append(
                    f"sensor-lag: the second lag of {values['second_lag_s']:.3g} s has no key in a mold document; "
                    "only the first is in the extended model"
                )
        elif name == "base-conduction":
            places = list(problem.base)
            _uncover(mold, places)
            mold.setdefault("convection", []).append(
                {"on": places, "h": f"{values['h_W_m2K']!r} W/m^2/K", "ambient": ambient}
            )
            if "bench_share" in values:
                notes.append(
                    f"base-conduction: the bench takes on {100.0 * values['bench_share']:.3g} % of the base's warmth "
                    f"within {values['bench_s']:.3g} s, for which a mold document has no key; the extended model has "
                    "a bench as cold as the ambient"
                )
            elif "from_middle" in values:
                notes.append(_UNEVEN.format("base-conduction: more leaves in places"))
        elif name == "ambient-drift":
            times = problem.runs[0].times
            at = np.linspace(0.0, float(times[-1]), 101)
            slope, bend, twist = (values.get(f"drift_K_s{power}", 0.0) for power in ("", "2", "3"))
            rise = slope * at + bend * at**2 + twist * at**3
            base = (
                problem.runs[0].mold.films[0].ambient(at)
                if problem.runs[0].mold.films
                else np.full_like(at, 25.0)
            )
            files[".ambient.csv"] = _csv("time [s]", "temperature [degC]", at, base + warmer + rise)
            for kind in ("convection", "radiation"):
                for section in mold.get(kind, []):
                    section["ambient"] = {"table": ".ambient.csv"}
        elif name == "power-loss" and set(values) - {"lost_share"}:
            told = ", ".join(f"{key} {value:.3g}" for key, value in values.items() if key != "lost_share")
            notes.append(
                f"power-loss: a mold document has no key for what rides on the temperature ({told}); the extended "
                "model has the power that reached the mold in this run as its schedule"
            )
    return notes


def _warmer(ambient: Any, kelvin: float, problem: HeatProblem, files: dict[str, bytes]) -> Any:
    """Return an ambient that many kelvin warmer."""
    if kelvin == 0.0:
        return ambient
    if isinstance(ambient, str):
        return f"{float(ambient.split()[0]) + kelvin!r} degC"
    air = problem.runs[0].mold.films[0].ambient
    files[".sky.csv"] = _csv("time [s]", "temperature [degC]", air.x, air.y + kelvin)
    return {"table": ".sky.csv"}


def _uncover(mold: dict[str, Any], places: list[str]) -> None:
    """Take faces that get a film out of the insulated ones."""
    kept = []
    for section in mold.get("insulated", []):
        rest = [place for place in _listed(section["on"]) if place not in places]
        if rest:
            kept.append({**section, "on": rest})
    if "insulated" in mold:
        mold["insulated"] = kept
        if not kept:
            del mold["insulated"]


def _listed(places: Any) -> list[Any]:
    return list(places) if isinstance(places, list) else [places]


def _csv(first: str, second: str, x: Array, y: Array) -> bytes:
    return csv_bytes([first, second], list(zip(x, y, strict=True)), digits=9)
