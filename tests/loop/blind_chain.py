"""Blind trials of a whole chain, one truth upstream off: ``python -m loop.blind_chain [seeds] [first]`` (from tests/).

The commands make fabric, drape, heat and press with other numbers in one document; what is read of that is a film in
the press, or markers on the sheet. The trace has the documents as they were, and the readings.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hyperfab.cases.drape import DrapeCase
from hyperfab.cases.like import earlier
from hyperfab.cases.options import read
from hyperfab.cases.press import PressCase
from hyperfab.cases.registry import case_class
from hyperfab.chapters.close_loop.drape import Forward, pose_sheet, read_markers
from hyperfab.chapters.close_loop.press import read_press
from hyperfab.chapters.close_loop.upstream import Traced, follow
from hyperfab.chapters.close_loop.upstream_drape import DrapeChain
from hyperfab.chapters.close_loop.upstream_press import PressChain
from hyperfab.chapters.job import Job
from hyperfab.chapters.rerun import rerun
from hyperfab.console import Console
from hyperfab.documents.base import read_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.io.json_io import dump_json
from hyperfab.io.layout import layout
from hyperfab.io.stl_write import stl_bytes
from hyperfab.io.vtu_read import read_vtu
from hyperfab.loop.drape import Draped, drape_problem
from hyperfab.loop.upstream import STATED, Readings
from hyperfab.samples import cup

WARP = {"C10_MPa": 0.06, "C20_MPa": 0.022, "C30_MPa": 0.017}
WEFT = {"C10_MPa": 0.045, "C20_MPa": 0.013, "C30_MPa": 0.0087}
FOAM = """format = "hyperfab.foam/1"
thickness = "{thickness} mm"
fabric = {{ above = "fabric.json", below = "fabric.json" }}
expansion = {{ male = "23.6e-6 1/K", female = "23.6e-6 1/K" }}
[press]
tilt = {{ x = "{tilt_x} deg", y = "{tilt_y} deg" }}
offset = {{ x = "{shift_x} mm", y = "{shift_y} mm" }}
[[compression]]
law = "plateau"
plateau = "{plateau} MPa"
modulus = "{modulus} MPa"
densification = "0.01 MPa"
temperature = "20 degC"
[[compression]]
law = "plateau"
plateau = "{hot} MPa"
modulus = "{hotter} MPa"
densification = "0.007 MPa"
temperature = "200 degC"
"""
#: A block of metal in a room, held by its heater and its film: not the press's mold, which takes its mean.
MOLD = """format = "hyperfab.mold/1"
[material.aluminium]
density = "2702 kg/m^3"
conductivity = "237 W/m/K"
specific_heat = "903 J/kg/K"
[[part]]
name = "block"
material = "aluminium"
box = {{ origin = ["400 mm", "0 mm", "0 mm"], size = ["200 mm", "160 mm", "60 mm"] }}
[[heater]]
on = "block.z-"
power = "{power} W"
[[convection]]
on = "exposed"
h = "{h} W/m^2/K"
ambient = "{room} degC"
[run]
until = "3000 s"
start = "{room} degC"
mesh_size = "40 mm"
tolerance = "0.05 K"
"""
PRESS = ("--male", "male.stl", "--female", "female.stl", "--foam", "foam.toml", "--male-heat", "heat.json",
         "--female-heat", "heat.json", "--drape", "drape.json", "--strokes", "2")  # fmt: skip
DRAPE = ("fabric.json", "--mold", "male.stl", "--grid", "25x25", "--size", "190mm", "--depth", "35mm")
GAP = 2.8
LAYOUT = layout((), None, None)


@dataclass(frozen=True)
class Truth:
    """What is off, by document: of the fabric, factors on constants by way, and its thickness [mm]; numbers of the mold
    and of the sandwich; words of the drape."""

    chapter: str = ""
    what: str = ""
    warp: Mapping[str, float] = field(default_factory=dict)
    weft: Mapping[str, float] = field(default_factory=dict)
    mold: Mapping[str, float] = field(default_factory=dict)
    foam: Mapping[str, float] = field(default_factory=dict)
    thick: float = 0.5
    drape: tuple[str, ...] = ()


def fabric(truth: Truth) -> bytes:
    """Return the fabric's document."""
    ways = {
        way: {"parameters": {name: value * factors.get(name, 1.0) for name, value in known.items()}}
        for way, known, factors in (("warp", WARP, truth.warp), ("weft", WEFT, truth.weft))
    }
    plain = {"format": "hyperfab.material/1", "model": "yeoh-3", "parameters": ways["warp"]["parameters"],
             "directions": ways, "thickness_mm": truth.thick}  # fmt: skip
    return json.dumps(plain).encode()


def mold(truth: Truth) -> bytes:
    """Return the mold's document."""
    return MOLD.format(**{"power": 420.0, "h": 26.0, "room": 25.0, **truth.mold}).encode()


def foam(truth: Truth) -> bytes:
    """Return the sandwich's document."""
    known = {"thickness": 3.6, "plateau": 0.006, "modulus": 0.08, "soft": 0.55, "stiffness": 1.0,
             **dict.fromkeys(("tilt_x", "tilt_y", "shift_x", "shift_y"), 0.0), **truth.foam}  # fmt: skip
    soft = known.pop("soft")
    known["plateau"] *= known["stiffness"]
    known["modulus"] *= known.pop("stiffness")
    return FOAM.format(hot=soft * known["plateau"], hotter=soft * known["modulus"], **known).encode()


def molds() -> dict[str, bytes]:
    """Return both molds' surfaces."""
    made = (("male", cup.male_cup(24, 25)), ("female", cup.female_cup(25, 24)))
    return {f"{name}.stl": stl_bytes(solid.vertices, solid.faces) for name, solid in made}


def chain(truth: Truth, known: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return all files of a chain by name; of ``known`` files of another chain those that are the same hold."""
    files = dict(known) | {"fabric.json": fabric(truth), "mold.toml": mold(truth), "foam.toml": foam(truth)}
    drape = options(("drape", *DRAPE), truth.drape)
    steps = [(("mold-heat", "mold.toml"), "heat.json", files["mold.toml"] != known.get("mold.toml"))]
    steps += [(drape, "drape.json", files["fabric.json"] != known.get("fabric.json") or bool(truth.drape))]
    steps += [(("press-contact", *PRESS, "--gap", f"{GAP}mm"), "press.json", truth.what not in ON_THE_SHEET)]
    for words, target, anew in steps:
        if anew:
            made = rerun(read(case_class(words[0]), list(words[1:])), target, files)
            files[target] = dump_json(made.document)
            files |= {target.replace(".json", suffix): data for suffix, data in made.siblings.items()}
    return files


def options(words: tuple[str, ...], more: tuple[str, ...]) -> tuple[str, ...]:
    """Return words with options replaced or added."""
    found = list(words)
    for name, value in zip(more[::2], more[1::2], strict=True):
        if name in found:
            found[found.index(name) + 1] = value
        else:
            found += [name, value]
    return tuple(found)


def film(files: Mapping[str, bytes], rng: np.random.Generator, noise: float, count: int = 100) -> bytes:
    """Return a pressure film at places of the male, as a file; ``noise`` is a share of the largest pressure."""
    grid = read_vtu(files["press.vtu"], "press.vtu")
    pressure = np.nan_to_num(grid.point_data["pressure_MPa"])
    at = rng.choice(np.flatnonzero(pressure > 0.0), count, replace=False)
    value = pressure[at] + noise * pressure.max() * rng.standard_normal(count)
    rows = [",".join(f"{v:.6g}" for v in (*grid.points[k], p)) for k, p in zip(at, value, strict=True)]
    return ("\n".join(["x [mm],y [mm],z [mm],pressure [MPa]", *rows]) + "\n").encode()


def off(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a factor that is off by between ``low`` and ``high``, either way."""
    return 1.0 + float(rng.uniform(low, high) * rng.choice([-1.0, 1.0]))


def _spread(rng: np.random.Generator, size: float, names: tuple[str, str]) -> dict[str, float]:
    way = rng.uniform(0.0, 2.0 * np.pi)
    return {names[0]: float(size * np.cos(way)), names[1]: float(size * np.sin(way))}


#: What may be off in the press's chain: the chapter, and what of it.
DRAWN: dict[str, tuple[str, Callable[[np.random.Generator], dict[str, Any]]]] = {
    "fabric thickness": ("fabric", lambda r: {"thick": 0.5 * off(r, 0.1, 0.3)}),
    "film coefficient": ("temperature", lambda r: {"mold": {"h": 26.0 * off(r, 0.12, 0.3)}}),
    "power": ("temperature", lambda r: {"mold": {"power": 420.0 * off(r, 0.1, 0.2)}}),
    "stiffness": ("foam", lambda r: {"foam": {"stiffness": off(r, 0.12, 0.3)}}),
    "thickness": ("foam", lambda r: {"foam": {"thickness": 3.6 * off(r, 0.03, 0.08)}}),
    "plateau": ("foam", lambda r: {"foam": {"plateau": 0.006 * off(r, 0.2, 0.4)}}),
    "tilt": ("mounting", lambda r: {"foam": _spread(r, float(r.uniform(0.05, 0.2)), ("tilt_x", "tilt_y"))}),
    "shift": ("mounting", lambda r: {"foam": _spread(r, float(r.uniform(0.1, 0.4)), ("shift_x", "shift_y"))}),
    "stretched sheet": ("sheet", lambda r: {"drape": ("--prestretch", f"{1.0 + r.uniform(0.03, 0.06):.4f}")}),
}


def markers(files: Mapping[str, bytes], rng: np.random.Generator, noise: float, count: int = 80) -> bytes:
    """Return markers on the draped sheet at its nodes, as a file; ``noise`` in mm."""
    grid = read_vtu(files["drape.vtu"], "drape.vtu")
    side = round(len(grid.points) ** 0.5)
    size = 190.0
    flat = np.linspace(-0.5 * size, 0.5 * size, side)
    # Nodes are counted along y first or along x first: what lies at the rim tells.
    x0, y0 = (one.ravel() for one in np.meshgrid(flat, flat, indexing="ij"))
    if abs(grid.points[1, 0] - grid.points[0, 0]) > abs(grid.points[1, 1] - grid.points[0, 1]):
        x0, y0 = y0, x0
    inner = np.flatnonzero(np.maximum(np.abs(x0), np.abs(y0)) < 0.49 * size)
    at = rng.choice(inner, count, replace=False)
    place = grid.points[at] + noise * rng.standard_normal((count, 3))
    rows = [",".join(f"{v:.6g}" for v in (x0[k], y0[k], *p)) for k, p in zip(at, place, strict=True)]
    return ("\n".join(["x0 [mm],y0 [mm],x [mm],y [mm],z [mm]", *rows]) + "\n").encode()


#: What may be off where only markers on the sheet are read.
ON_THE_SHEET: dict[str, tuple[str, Callable[[np.random.Generator], dict[str, Any]]]] = {
    "weft": ("fabric", lambda r: {"weft": dict.fromkeys(WEFT, off(r, 0.15, 0.35))}),
    "warp": ("fabric", lambda r: {"warp": dict.fromkeys(WARP, off(r, 0.15, 0.35))}),
    "mounted taut": ("mounting", lambda r: {"drape": ("--prestretch", f"{1.0 + r.uniform(0.01, 0.04):.4f}")}),
    "depth": (
        "mounting",
        lambda r: {"drape": ("--depth", f"{35.0 + r.choice([-1, 1]) * r.uniform(0.3, 0.6):.3f}mm")},
    ),
    "friction": ("friction", lambda r: {"drape": ("--friction", f"{r.uniform(0.08, 0.3):.3f}")}),
}


class Tracing:
    """The chain as its documents have it, in the present folder, and what traces readings in it."""

    def __init__(self) -> None:
        self.files = chain(Truth(), molds())
        for name, data in self.files.items():
            Path(name).write_bytes(data)
        self.job = Job("close-loop", [], Console(True))

    def case(self, cls: Any, name: str) -> Any:
        """Return the case that a document was made by."""
        return earlier(cls, json.loads(self.files[name]), name).case

    @cached_property
    def press(self) -> PressChain:
        """The press and the documents behind it."""
        return PressChain(self.job, self.case(PressCase, "press.json"), 0.1)

    @cached_property
    def drape(self) -> tuple[Forward, Draped]:
        """The drape, and what stands for it."""
        case = self.case(DrapeCase, "drape.json")
        forward = Forward(self.job, case, read_document(self.job.inputs, "fabric.json", MaterialDocument))
        return forward, pose_sheet(forward, lambda share: None)

    def of_film(self, what: str, seed: int, noise: float = 0.02) -> Traced:
        """Trace a film that was read where something is off."""
        files = chain(drawn(what, seed), self.files)
        Path("film.csv").write_bytes(film(files, np.random.default_rng([seed, 77, len(what)]), noise))
        [one] = read_press(self.job, "film.csv", LAYOUT, Counter())
        peak = np.nanmax(read_vtu(files["press.vtu"], "press.vtu").point_data["pressure_MPa"])
        sd = np.full(len(one.values), noise * peak)
        places = one.places
        assert places is not None
        return follow(self.press, [one], Readings(one.values, sd, places, np.zeros(len(sd))))[0]

    def of_markers(self, what: str, seed: int, noise: float = 0.05) -> Traced:
        """Trace markers on the sheet where something is off; ``noise`` in mm."""
        files = chain(replace(drawn(what, seed), drape=drawn(what, seed).drape or ("--depth", "35mm")), self.files)
        Path("markers.csv").write_bytes(markers(files, np.random.default_rng([seed, 77, len(what)]), noise))
        [one] = read_markers(self.job, "markers.csv", LAYOUT, Counter())
        forward, draped = self.drape
        problem = drape_problem(draped, [one])
        places = np.concatenate([np.tile(part.flat, (3, 1)) for part in problem.files])
        kind = np.concatenate([np.repeat([0, 1, 2], len(part.flat)) for part in problem.files])
        rows = Readings(problem.measured[: len(places)], np.full(len(places), noise), places, kind)
        return follow(DrapeChain(forward, problem, 0.1), problem.files, rows)[0]


def drawn(what: str, seed: int) -> Truth:
    """Return a truth in which one thing is off; ``what`` "none": nothing."""
    if what == "none":
        return Truth()
    chapter, make = {**DRAWN, **ON_THE_SHEET}[what]
    return Truth(chapter=chapter, what=what, **make(np.random.default_rng([seed, len(what)])))


def main(seeds: int, first: int = 0) -> None:
    """Trace every truth of so many seeds, and twice as many chains that are right; print what came out, and counts."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        tracing = Tracing()
        counts: dict[str, int] = {}
        for where, truths, trace in (
            ("film", DRAWN, tracing.of_film),
            ("markers", ON_THE_SHEET, tracing.of_markers),
        ):
            for seed in range(first, first + seeds):
                for what in [*truths, "none"]:
                    found = trace(what, seed)
                    chapter = truths[what][0] if what in truths else ""
                    out = outcome(chapter, found)
                    counts[out] = counts.get(out, 0) + 1
                    shares = {name: round(p, 3) for name, p in found.trace.probability.items() if p >= 0.001}
                    print(f"{where:8s} {what:17s} {chapter:12s} {out:12s} {shares}", flush=True)
        print(counts)
        os.chdir("/")


def outcome(chapter: str, found: Traced) -> str:
    """Return whether the chapter that is off was named: alone, in the set, not, or another; of none, rightly or not."""
    named = found.trace.suspects
    if not chapter:
        return "none" if found.verdict == STATED else "false name"
    if found.verdict == "chapter":
        return "alone" if named == (chapter,) else "wrong alone"
    return "in the set" if chapter in named and found.verdict == "ambiguous" else "not named"


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:] or ["3"]))
