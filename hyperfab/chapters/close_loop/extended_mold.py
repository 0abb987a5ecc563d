"""The extended mold: the document as people wrote it, with refitted constants and the found terms."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import tomli_w

from hyperfab.documents.mold import MoldDocument
from hyperfab.loop.fitting import Fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.loop.problem import Array
from hyperfab.thermal.tables import Table

_FILES = ("table", "stl", "schedule", "document")


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
    terms = {name: {c.name: float(v) for c, v in zip(fit.forms[name].constants, values, strict=True)}
             for name, (_, values) in fit.terms.items()}  # fmt: skip
    _scale(mold, document, problem, factors, terms, files)
    notes = _add(mold, document, problem, terms, files)
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
    reduced = problem.runs[0][0]
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
        for what, unit, rate in (
            ("conductivity", "W/m/K", drift.get("conductivity_per_K", 0.0)),
            ("specific_heat", "J/kg/K", drift.get("specific_heat_per_K", 0.0)),
        ):
            value = getattr(stuff, what)
            factor = factors.get(f"material.{key}.{what}", 1.0)
            if not isinstance(value, float):
                continue
            if rate == 0.0:
                mold["material"][key][what] = f"{value * factor!r} {unit}"
                continue
            zero = reduced.reference_degC
            at = np.array([zero - 50.0, zero, zero + 500.0])
            scaled = value * factor * np.maximum(1.0 + rate * (at - zero), 0.05)
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
    for index, contact in enumerate(document.contact):
        factor = factors.get(f"contact.{index}.h", 1.0)
        mold["contact"][index]["h"] = f"{contact.h * factor!r} W/m^2/K"


def _add(
    mold: dict[str, Any],
    document: MoldDocument,
    problem: HeatProblem,
    terms: Mapping[str, Mapping[str, float]],
    files: dict[str, bytes],
) -> list[str]:
    """Add the terms to the document; return what it has no key for."""
    notes = []
    cooled = document.convection[0] if document.convection else None
    ambient = mold["convection"][0]["ambient"] if cooled is not None else "25.0 degC"
    for name, values in terms.items():
        if name == "radiation":
            places = [place for section in mold["convection"] for place in _listed(section["on"])]
            mold.setdefault("radiation", []).append(
                {"on": places, "emissivity": values["emissivity"], "ambient": ambient}
            )
        elif name == "contact-resistance":
            h = 1.0 / max(values["resistance_m2K_W"], 1e-7)
            for pair in problem.pairs:
                mold.setdefault("contact", []).append({"between": list(pair), "h": f"{h!r} W/m^2/K"})
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
        elif name == "ambient-drift":
            times = problem.runs[0][1]
            at = np.linspace(0.0, float(times[-1]), 41)
            rise = values["drift_K_s"] * at + values.get("drift_K_s2", 0.0) * at**2
            rise = rise + values.get("drift_K_s3", 0.0) * at**3
            base = (
                problem.runs[0][0].films[0].ambient(at)
                if problem.runs[0][0].films
                else np.full_like(at, 25.0)
            )
            files[".ambient.csv"] = _csv("time [s]", "temperature [degC]", at, base + rise)
            for kind in ("convection", "radiation"):
                for section in mold.get(kind, []):
                    section["ambient"] = {"table": ".ambient.csv"}
        elif name == "power-loss" and "lost_share_per_K" in values:
            notes.append(
                f"power-loss: the share {values['lost_share_per_K']:.3g} lost per kelvin has no key in a mold "
                "document; only the constant share is in the extended model"
            )
    return notes


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
    rows = [f"{first},{second}", *(f"{float(a):.9g},{float(b):.9g}" for a, b in zip(x, y, strict=True))]
    return ("\n".join(rows) + "\n").encode()
