"""The extended mold: the document as people wrote it, with refitted constants and the found terms."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.toml_io import dump_toml
from hyperfab.loop.fitting import Fit
from hyperfab.loop.heat import HeatProblem
from hyperfab.thermal.settings import air_drift
from hyperfab.thermal.tables import Table

_UNEVEN = "{}, for which a mold document has no key; the extended model has the mean throughout"
#: What of a joint or a base differs over its face.
_OVER_A_FACE = ("from_middle", "along_x", "along_y")
#: Losses of power that ride on the temperature, and what they are called.
_RIDING = {
    "lost_per_K": "lost_share_per_K",
    "lost_per_K2": "lost_share_per_K2",
    "back_W_K": "back_W_K",
    "wire_per_K": "resistance_per_K",
}
#: How far above the ambient [K] a film coefficient that rides on it is tabulated.
_ABOVE = np.concatenate([np.geomspace(0.5, 20.0, 60), np.linspace(20.0, 400.0, 191)[1:]])
#: What a step of the extended mold may err by, as a share of the readings' noise.
_STEP = 0.05
_FILES = ("table", "stl", "schedule", "document")
#: Endings of the tables an extended mold may have beside it.
TABLES = (
    *(f".{what}-*.csv" for what in ("film", "power", "conductivity", "specific-heat")),
    ".bench.csv",
    ".joint.csv",
    ".ambient.csv",
    ".ambient-*.csv",
)


def extend(
    data: Mapping[str, Any],
    document: MoldDocument,
    problem: HeatProblem,
    fit: Fit,
    stem: str,
    folders: tuple[str, str],
    noise_K: float = np.inf,
) -> tuple[dict[str, bytes], list[str]]:
    """Return the files of the extended mold by suffix, and what of it ``hf mold-heat`` cannot obey.

    ``stem`` is the output's, for the names of tables; ``folders`` are that of the document and that of the
    output: names of other files are counted from the latter; ``noise_K`` is that of the readings, within which the
    extended mold is to be what the loop predicts.
    """
    mold = copy.deepcopy(dict(data))
    relocate(mold, folders)
    wider = _Wider(mold, document, problem, fit, stem)
    wider.films()
    wider.materials()
    wider.heaters()
    wider.starts()
    wider.surroundings()
    wider.joints()
    wider.radiation()
    wider.base()
    wider.probes()
    wider.steps(noise_K)
    return {**wider.files, ".model.toml": dump_toml(mold)}, wider.notes


def relocate(node: Any, folders: tuple[str, str]) -> None:
    """Count the names of files from the new document's folder, the second; they were counted from the first."""
    if isinstance(node, dict):
        for key, value in node.items():
            is_file = isinstance(value, str) and (key in _FILES or value.endswith(".json"))
            if is_file and not os.path.isabs(value):
                node[key] = os.path.relpath(os.path.join(folders[0], value), folders[1] or ".")
            else:
                relocate(value, folders)
    elif isinstance(node, list):
        for item in node:
            relocate(item, folders)


@dataclass
class _Wider:
    """A mold's plain document on its way to the extended one.

    document   what was given, read
    stem       of the names of tables
    fitted     own constants and terms, as the problem takes them
    own        the refitted constants, by name
    amounts    what the found terms add, by its place in the reduced mold's settings
    files      tables beside it, by suffix
    notes      what the document has no key for
    """

    mold: dict[str, Any]
    document: MoldDocument
    problem: HeatProblem
    fit: Fit
    stem: str
    files: dict[str, bytes] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Keep what was found, the mold as it was reduced, and the faces as they were given."""
        fit = self.fit
        self.fitted = fit.x[: fit.own], fit.terms
        self.own = self.problem.as_stated(fit.x[: fit.own])
        # A term at its null is not there: the document stays the one that was given.
        terms = {name: term for name, term in fit.terms.items() if tuple(term[1]) != fit.forms[name].null}
        self.amounts = self.problem.amounts(terms)
        self.reduced = self.problem.runs[0].mold
        self.faces = {"convection": self.reduced.films, "radiation": self.reduced.radiators}
        self.given = {kind: copy.deepcopy(self.mold.get(kind, [])) for kind in self.faces}

    def table(self, suffix: str, first: str, second: str, x: Array, y: Array) -> str:
        """Add a table beside the mold; return the name it is written under."""
        self.files[suffix] = _csv(first, second, x, y)
        return f"{self.stem}{suffix}"

    def at(self, place: str) -> float:
        """Return what is added at a place."""
        return self.amounts.get(place, 0.0)

    @property
    def moves(self) -> bool:
        """Whether the ambient was found to change with time."""
        return any(name.startswith("ambient_") and name != "ambient_period_s" and v for name, v in self.amounts.items())

    def films(self) -> None:
        """Scale the film coefficients; one that rides on the temperature difference in another way is a table."""
        exponent = self.at("exponent")
        for index, section in enumerate(self.document.convection):
            factor, film = self.own.get(f"convection.{index}.h", 1.0), self.reduced.films[index].film
            if exponent == 0.0 and isinstance(section.h, float):
                self.mold["convection"][index]["h"] = f"{section.h * factor!r} W/m^2/K"
            elif factor != 1.0 or exponent != 0.0:
                air = float(self.reduced.films[index].ambient.y[0]) + self.own.get("ambient", 0.0)
                at = np.unique(np.concatenate([film.x, air + _ABOVE]))
                h = factor * film(at) * (np.maximum(np.abs(at - air), 0.5) / 30.0) ** exponent
                name = self.table(f".film-{index}.csv", "temperature [degC]", "h [W/m^2/K]", at, h)
                self.mold["convection"][index]["h"] = {"table": name}

        still = all(one.ambient.is_constant for one in self.reduced.films)
        if exponent and (self.moves or not still):
            self.notes.append(
                "convection-law: a film's table is over the temperature of the face; it is of the ambient at the start"
            )

    def materials(self) -> None:
        """Scale conductivities and specific heats, and let them change with temperature."""
        for key, stuff in self.document.material.items():
            for what, place, unit in (
                ("conductivity", "conductivity", "W/m/K"),
                ("specific_heat", "capacity", "J/kg/K"),
            ):
                value, factor = getattr(stuff, what), self.own.get(f"material.{key}.{what}", 1.0)
                rate, bend = self.at(f"{place}_per_K"), self.at(f"{place}_per_K2")
                if rate == bend == 0.0:
                    if isinstance(value, float):
                        self.mold["material"][key][what] = f"{value * factor!r} {unit}"
                        continue
                    if factor == 1.0:
                        continue
                zero, plain = self.reduced.reference_degC, self.problem.tables[f"{key}.{what}"]
                beside = np.array([zero - 50.0, zero]) if bend == 0.0 else np.arange(zero - 50.0, zero + 490.0, 10.0)
                at = np.unique(np.concatenate([plain.x, beside, [zero + 500.0]]))
                scaled = factor * plain(at) * np.maximum(1.0 + (rate + bend * (at - zero)) * (at - zero), 0.05)
                suffix, head = f".{what.replace('_', '-')}-{key}.csv", f"{what.replace('_', ' ')} [{unit}]"
                name = self.table(suffix, "temperature [degC]", head, at, scaled)
                self.mold["material"][key][what] = {"table": name}

    def heaters(self) -> None:
        """Scale the powers; what rides on the temperature is the power that reached the mold in this run."""
        riding = {key: self.amounts[key] for key in _RIDING if key in self.amounts}
        reached = self.problem.given_off(*self.fitted) if riding else ()
        for index, heater in enumerate(self.document.heater):
            factor = self.own.get(f"heater.{index}.power", 1.0) * (1.0 - self.at("lost"))
            read = heater.control is None and index in self.problem.read
            own = self.mold["heater"][index]
            if riding and heater.control is None:
                power = reached[index]
                own.pop("power", None)
                own.pop("flux", None)
                times, first = np.unique([float(f"{time:.9g}") for time in power.x], return_index=True)
                self._schedule(index, times, np.maximum(power.y[first], 0.0))
            elif factor == 1.0 and not read:
                continue
            elif heater.schedule is not None or read:
                own.pop("flux", None)
                table: Table = self.reduced.heaters[index][1]
                self._schedule(index, table.x, factor * table.y)
            elif heater.power is not None:
                own["power"] = f"{heater.power * factor!r} W"
            elif heater.flux is not None:
                own["flux"] = f"{heater.flux * factor!r} W/m^2"
        if riding:
            told = ", ".join(f"{_RIDING[key]} {value:.3g}" for key, value in riding.items())
            self.notes.append(
                f"power-loss: a mold document has no key for what rides on the temperature ({told}); the extended "
                "model has the power that reached the mold in this run as its schedule"
            )

    def _schedule(self, index: int, times: Array, power: Array) -> None:
        """Write the power [W] of a heater over time [s]."""
        name = self.table(f".power-{index}.csv", "time [s]", "power [W]", times, power)
        self.mold["heater"][index]["schedule"] = name

    def starts(self) -> None:
        """Write the temperatures at the start."""
        begin, later = self.document.run.start, self.own.get("run.start", 0.0)
        if not isinstance(begin, float):
            if later:
                self.notes.append(f"run.start: the field it starts from was {later:.3g} K warmer, which is not written")
            return
        self.mold["run"]["start"] = f"{begin + later!r} degC"
        for index, part in enumerate(self.document.part):
            warmer = self.own.get(f"part.{part.name}.start", 0.0)
            if warmer != 0.0 or part.start is not None:
                own = begin if part.start is None else part.start
                self.mold["part"][index]["start"] = f"{own + later + warmer!r} degC"

    def surroundings(self) -> None:
        """Write the ambient of the document's faces as it was found, and as it changes with time."""
        for kind, faces in self.faces.items():
            for index in range(len(faces)):
                self.mold[kind][index]["ambient"] = self.ambient(kind, index)

    def ambient(self, kind: str, index: int, more: float = 0.0) -> Any:
        """Return the ambient of a face of the document as it was found, and ``more`` [K] warmer."""
        given, air = getattr(self.document, kind)[index].ambient, self.faces[kind][index].ambient
        warmer = self.own.get("ambient", 0.0) + more
        if not self.moves:
            if isinstance(given, float):
                return f"{given + warmer!r} degC"
            if warmer == 0.0:
                return self.given[kind][index]["ambient"]
        times = air.x
        if self.moves:
            clock = self.problem.runs[0].times
            times = np.union1d(air.x, np.linspace(min(0.0, float(clock[0])), float(clock[-1]), 101))
        rise = air_drift(self.at, times)
        table = _csv("time [s]", "temperature [degC]", times, air(times) + warmer + rise)
        # Faces in the same air share a table.
        same = (name for name, content in self.files.items() if content == table)
        count = sum(name.startswith(".ambient") for name in self.files)
        name = next(same, f".ambient-{count + 1}.csv" if count else ".ambient.csv")
        self.files[name] = table
        return {"table": f"{self.stem}{name}"}

    def joints(self) -> None:
        """Write the conductance of joints: of the document's, and of those that conduct perfectly in it.

        One that changes with their temperature is written as it was in this run.
        """
        pairs = self.problem.pairs
        for index, contact in enumerate(self.document.contact):
            h = contact.h * self.own.get(f"contact.{index}.h", 1.0)
            h /= 1.0 + self.at(f"resistance.{len(pairs) + index}") * h
            self.mold["contact"][index]["h"] = f"{h!r} W/m^2/K"
        opened = [self.amounts.get(f"resistance.{k}") for k in range(len(pairs))]
        best, own = 1.0, {}
        if any(self.at(f"joint_{way}") for way in ("per_K", "closes", "tightens")):
            over = self.problem.joint_share(*self.fitted)
            best = float(np.max(over.y))
            own = {"schedule": self.table(".joint.csv", "time [s]", "contact [-]", over.x, over.y / best)}
        if self.at("joint_per_K"):
            self.notes.append(
                f"contact-resistance: the joint conducts {100.0 * self.at('joint_per_K'):.3g} % better a kelvin, for "
                "which a mold document has no key; the extended model has its conductance in this run as its schedule"
            )
        for pair, resistance in zip(pairs, opened, strict=True):
            if resistance is not None:
                h = best / max(resistance, 1e-7)
                self.mold.setdefault("contact", []).append({"between": list(pair), "h": f"{h!r} W/m^2/K", **own})
        if any(self.at(f"joint_{way}") for way in _OVER_A_FACE):
            self.notes.append(_UNEVEN.format("contact-resistance: the joint is better in places"))

    def radiation(self) -> None:
        """Let the faces that have a film radiate, to surroundings as warm as their air or not."""
        if "emissivity" not in self.amounts:
            return
        warmer = self.at("surroundings_K")
        around = [self.ambient("convection", index, warmer) for index in range(len(self.reduced.films))]
        for one in [around[k] for k in range(len(around)) if around[k] not in around[:k]]:
            faces = [f for f, other in zip(self.mold["convection"], around, strict=False) if other == one]
            places = [place for section in faces for place in _listed(section["on"])]
            self.mold.setdefault("radiation", []).append(
                {"on": places, "emissivity": self.amounts["emissivity"], "ambient": one}
            )

    def base(self) -> None:
        """Give the faces the mold stands on a film, to a bench that is as warm as it was in this run."""
        if "bench" not in self.amounts:
            return
        first = next((kind for kind, faces in self.faces.items() if faces), None)
        air = self.reduced.reference_degC + self.own.get("ambient", 0.0)
        ambient = f"{air!r} degC" if first is None else self.ambient(first, 0)
        if self.at("bench_share"):
            warm = self.problem.bench_degC(*self.fitted)
            ambient = {"table": self.table(".bench.csv", "time [s]", "temperature [degC]", warm.x, warm.y)}
            self.notes.append(
                f"base-conduction: the bench takes on {100.0 * self.at('bench_share'):.3g} % of the base's warmth "
                f"within {self.at('bench_s'):.3g} s, for which a mold document has no key; the extended model has "
                "the bench as warm as it was in this run"
            )
        places = _uncovered(self.mold, self.problem.base)
        self.mold.setdefault("convection", []).append(
            {"on": places, "h": f"{self.amounts['bench']!r} W/m^2/K", "ambient": ambient}
        )
        if any(self.at(f"bench_{way}") for way in _OVER_A_FACE):
            self.notes.append(_UNEVEN.format("base-conduction: more leaves in places"))

    def steps(self, noise_K: float) -> None:
        """Let no step of the run err by more than is small beside the noise: what steps err by adds up."""
        if _STEP * noise_K < self.document.run.tolerance:
            self.mold["run"]["tolerance"] = f"{_STEP * noise_K:.2g} K"

    def probes(self) -> None:
        """Write how late the probes follow."""
        if "lag_s" not in self.amounts:
            return
        numbers = {name: k for k, name in enumerate(self.problem.names)}
        for probe, known in zip(self.mold["probe"], self.document.probe, strict=True):
            own = self.at(f"lag_s.{numbers.get(known.name, 0)}")
            probe["lag"] = f"{max(known.lag + self.amounts['lag_s'] + own, 0.0)!r} s"
            if "second_lag_s" in self.amounts:
                probe["second_lag"] = f"{known.second_lag + self.amounts['second_lag_s']!r} s"


def _uncovered(mold: dict[str, Any], places: Sequence[str | tuple[int, int]]) -> list[Any]:
    """Take ``places`` that get a film out of the insulated ones, and return them as the document writes them."""
    sections = [_listed(section["on"]) for section in mold.get("insulated", [])]
    found = [place if isinstance(place, str) else sections[place[0]][place[1]] for place in places]
    kept = []
    for number, on in enumerate(sections):
        rest = [place for index, place in enumerate(on) if (number, index) not in places]
        if rest:
            kept.append({**mold["insulated"][number], "on": rest})
    if sections:
        mold["insulated"] = kept
        if not kept:
            del mold["insulated"]
    return found


def _listed(places: Any) -> list[Any]:
    return list(places) if isinstance(places, list) else [places]


def _csv(first: str, second: str, x: Array, y: Array) -> bytes:
    return csv_bytes([first, second], list(zip(x, y, strict=True)), digits=9)
