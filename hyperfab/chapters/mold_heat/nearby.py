"""The neighbours of a heated mold, for how sure its figures are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.chapters.mold_heat.result import efficiency_of, energy_of, probes_of
from hyperfab.chapters.uncertainty.carry import Answer, Changes, Figures
from hyperfab.chapters.uncertainty.sources import Entry, Film, Number, Origins
from hyperfab.documents.mold import MoldDocument
from hyperfab.thermal import surface
from hyperfab.thermal.contact import Contact
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.history import History, Target
from hyperfab.thermal.nearby import Change, Neighbourhood
from hyperfab.thermal.projected import why_not

#: Which condition an entry of the mold document speaks of, and where its flow goes with the number.
_FLOWS = {
    ("heater", "power"): Heater, ("heater", "flux"): Heater, ("convection", "h"): Convection, ("contact", "h"): Contact
}  # fmt: skip


@dataclass
class Beside:
    """What the figures become beside a run: on the states it went through, with the steps it took."""

    problem: Problem
    origins: Origins
    reads: Sequence[_Number]
    near: Neighbourhood
    value: Figures

    @property
    def samples(self) -> int:
        """How many are drawn."""
        return 200

    @property
    def step(self) -> float:
        """Of differences, over a standard deviation: the basis and the steps of time are the same for all."""
        return 0.25

    def __post_init__(self) -> None:
        # What the basis leaves out is the same for all: they count from the run itself.
        self._off = Answer({})
        base = self.at({})
        self._off = Answer(
            {name: self.value[name] - value for name, value in base.figures.items() if name in self.value}
        )

    def gradient(self) -> None:
        """Nothing: extremes over nodes and times jump, so they are told by differences."""

    def at(self, changes: Changes) -> Answer:
        """Return figures and the field with numbers changed."""
        history = self.near.run(self._change(changes))
        last = history.states[-1].temperature
        found = {
            name: value + self._off.figures.get(name, 0.0)
            for name, value in _figures(self.problem, history).items()
        }
        return Answer(found, {"temperature_degC": last[: self.problem.mesh.solid]})

    def _change(self, changes: Changes) -> Change:
        """Return what numbers that change, by the number of their source, make another thing."""
        found = Change({}, {}, {}, {}, {}, {})
        place = 0
        for index, one in enumerate(self.origins.found):
            for k in range(len(one.numbers)):
                by = float(changes[index][k]) if index in changes else 0.0
                if by != 0.0:
                    self.reads[place].add(found, by)
                place += 1
        return found


@dataclass(frozen=True)
class _Number:
    """A number of the mold document with its ``value``: which ``kind`` of change it makes, of what ``keys``."""

    kind: str
    keys: tuple[int | str, ...]
    value: float

    def add(self, change: Change, by: float) -> None:
        """Add what it makes when it changes by so much."""
        table = getattr(change, self.kind)
        for key in self.keys:
            if self.kind in ("ambient", "start", "film"):
                table[key] = table.get(key, 0.0) + by
            else:
                table[key] = table.get(key, 1.0) * (1.0 + by / self.value)


def beside(
    case: MoldCase,
    document: MoldDocument,
    problem: Problem,
    history: History,
    value: Figures,
    origins: Origins,
) -> Beside | None:
    """Return the neighbours of a run; None where it switches, is steady, is designed, or has no projection."""
    model = problem.model
    if (
        case.warmup_in is not None
        or case.share_power
        or document.run.steady
        or problem.thermostats
        or problem.renewals
        or problem.pieces is not None
        or history.reduced is not None
        or len(history.states) < 3
        or why_not(model) is not None
    ):
        return None
    reads = [_read(number, document, problem) for number in origins.numbers]
    known = [one for one in reads if one is not None]
    if len(known) < len(reads):
        return None
    target = None
    if document.run.target is not None and problem.work_surface is not None:
        work = problem.work_surface
        target = Target(work.load(1.0) / work.area, document.run.target)
    units = []
    for one in known:
        units.append(Change({}, {}, {}, {}, {}, {}))
        one.add(units[-1], 1.0)
    stops = document.run.until is None
    if stops and history.reached is None:
        return None
    return Beside(problem, origins, known, Neighbourhood(model, history, target, stops, units), value)


def _read(number: Number, document: MoldDocument, problem: Problem) -> _Number | None:
    """Return what a number of the document changes; None for those that have no short way."""
    if isinstance(number, Film):
        films = problem.model.conditions
        at = [k for k, one in enumerate(films) if isinstance(one, Convection) and one.film is number.table]
        return _Number("film", tuple(at), 1.0)
    if not isinstance(number, Entry) or number.value == 0.0:
        return None
    conditions = problem.model.conditions
    place, value = number.place, number.value
    if place == ("run", "start"):
        parts = tuple(k for k, part in enumerate(document.part) if part.start is None)
        return _Number("start", parts, value)
    kind, which, key = (*place, None, None)[:3]
    if kind == "part" and key == "start":
        return _Number("start", (int(str(which)),), value)
    if kind == "material":
        kinds = {"conductivity": "conductivity", "specific_heat": "capacity", "density": "capacity"}
        return _Number(kinds[str(key)], (str(which),), value) if key in kinds else None
    condition = _FLOWS.get((str(kind), str(key)))
    ambient = key == "ambient" and kind in ("convection", "radiation")
    if condition is None and not ambient:
        return None
    names = {Heater: "heater", Convection: "convection", Contact: "contact"}
    mine = [k for k, one in enumerate(conditions) if names.get(type(one), "radiation") == kind]
    if len(mine) != len(getattr(document, str(kind))):
        return None
    return _Number("ambient" if ambient else "flow", (mine[int(str(which))],), value)


def _figures(problem: Problem, history: History) -> Figures:
    energy = energy_of(history)
    found = {f"energy.{name}": getattr(energy, name) for name in ("supplied_J", "lost_J", "stored_J")}
    if history.reached_time is not None:
        found["warmup_time_s"] = history.reached_time
    if problem.work_surface is not None:
        (end,) = surface.of_all(problem.work_surface, [history.states[-1]])
        found |= {
            "work_surface.mean_degC": end.mean,
            "work_surface.min_degC": end.least,
            "work_surface.max_degC": end.greatest,
            "work_surface.spread_K": end.spread,
        }
    for name, probe in probes_of(problem, history).items():
        found |= {f"probes.{name}.final_degC": probe.final_degC, f"probes.{name}.max_degC": probe.max_degC}
    share = efficiency_of(energy)
    if share is not None:
        found["efficiency"] = share
    return {name: float(value) for name, value in found.items() if value is not None and np.isfinite(value)}
