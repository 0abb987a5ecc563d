"""The neighbours of a heated mold, for how sure its figures are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.chapters.mold_heat.result import efficiency_of, energy_of, probes_of
from hyperfab.chapters.uncertainty.carry import Answer, Changes, Figures, Nearby
from hyperfab.chapters.uncertainty.sources import Entry, Film, Number, Origins
from hyperfab.documents.mold import MoldDocument
from hyperfab.numerics.trend import Trend
from hyperfab.thermal.contact import Contact
from hyperfab.thermal.convection import Convection
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.history import History, Target
from hyperfab.thermal.nearby import Change, Neighbourhood
from hyperfab.thermal.projected import why_not
from hyperfab.thermal.trail import Lift

#: Which condition an entry of the mold document speaks of, and where its flow goes with the number.
_FLOWS = {
    ("heater", "power"): Heater, ("heater", "flux"): Heater, ("convection", "h"): Convection, ("contact", "h"): Contact
}  # fmt: skip


#: So many runs that are drawn must be as parabolas through those before say, till these stand for the rest; by how much
#: of their standard deviation figures may be off then.
CHECKED, CLOSE = 5, 0.05
#: Temperatures are no sharper than this part of what a step may be off by.
_SHARP = 0.1


@dataclass
class Beside(Nearby):
    """What the figures become beside a run: on the states it went through, with the steps it took.

    Extremes over a surface jump from node to node. The temperatures themselves do not, nor do times and energies: many
    runs are parabolas between a few.
    """

    # The basis and the steps of time are the same for all: differences may be small.
    samples, step = 200, 0.25

    problem: Problem
    origins: Origins
    reads: Sequence[_Number]
    near: Neighbourhood
    value: Figures
    tolerance: float

    def __post_init__(self) -> None:
        self._trend = Trend()
        self._checked = 0
        self._known: list[Figures] = []
        self._names: list[str] = []
        work = self.problem.work_surface
        self._even = None if work is None else _Even.of(work, self.near.lift)
        # What the basis leaves out is the same for all: they count from the run itself.
        self._off: Figures = {}
        base = self.at({})
        self._off = {name: self.value[name] - value for name, value in base.figures.items() if name in self.value}

    def blur(self, name: str) -> float:
        """Return below which difference [K] two temperatures are one, 0 for other figures."""
        return _SHARP * self.tolerance if name.startswith(("work_surface", "probes")) else 0.0

    def at(self, changes: Changes) -> Answer:
        amounts = self.origins.amounts(changes)
        guess = self._trend.at(amounts)
        if guess is None or self._checked < CHECKED:
            smooth, coordinates = self._run(changes, amounts, guess)
        else:
            smooth, coordinates = self._split(guess)
        found = {name: value + self._off.get(name, 0.0) for name, value in self._figures(smooth, coordinates).items()}
        field = self.near.lift.nodal(coordinates)
        return Answer(found, {"temperature_degC": field[: self.problem.mesh.solid]})

    def _run(self, changes: Changes, amounts: Array, guess: Array | None) -> tuple[Figures, Array]:
        """Return the figures of a run that go smoothly, and where it ends; judge what was guessed of it."""
        history = self.near.run(self._change(changes))
        smooth, coordinates = _smooth(self.problem, history), history.states[-1].coordinates
        figures = self._figures(smooth, coordinates)
        self._names = self._names or list(smooth)
        if guess is not None:
            self._check(guess, figures)
        elif list(smooth) == self._names:
            self._known.append(figures)
            self._trend.add(amounts, np.concatenate([list(smooth.values()), coordinates]))
        return smooth, coordinates

    def _split(self, guess: Array) -> tuple[Figures, Array]:
        count = len(self._names)
        return dict(zip(self._names, map(float, guess[:count]), strict=True)), guess[count:]

    def _figures(self, smooth: Figures, coordinates: Array) -> Figures:
        return smooth if self._even is None else {**smooth, **self._even.figures(coordinates)}

    def _check(self, guess: Array, figures: Figures) -> None:
        """Count a run that is as was guessed; one that is not puts an end to guessing."""
        for name, value in self._figures(*self._split(guess)).items():
            close = max(CLOSE * float(np.std([one[name] for one in self._known])), self.blur(name))
            if not abs(value - figures.get(name, np.inf)) <= close:
                self._trend = Trend()  # known again after as many runs more, if ever
                self._known, self._checked = [], 0
                return
        self._checked += 1

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
    near = Neighbourhood(model, history, target, stops, units)
    return Beside(problem, origins, known, near, value, document.run.tolerance)


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


@dataclass(frozen=True)
class _Even:
    """How the work surface reads from coordinates: at its nodes, and its mean."""

    nodes: Lift
    mean: tuple[Array, float]

    @staticmethod
    def of(work: FacetOperator, lift: Lift) -> _Even:
        return _Even(lift.part(np.unique(work.nodes)), lift.sensor(work.load(1.0) / work.area))

    def figures(self, coordinates: Array) -> Figures:
        """Return mean, least, greatest and spread."""
        nodal = self.nodes.nodal(coordinates)
        least, greatest = float(nodal.min()), float(nodal.max())
        return {
            "work_surface.mean_degC": self.mean[1] + float(self.mean[0] @ coordinates),
            "work_surface.min_degC": least,
            "work_surface.max_degC": greatest,
            "work_surface.spread_K": greatest - least,
        }


def _smooth(problem: Problem, history: History) -> Figures:
    """Return all figures but those of the work surface."""
    energy = energy_of(history)
    found = {f"energy.{name}": getattr(energy, name) for name in ("supplied_J", "lost_J", "stored_J")}
    if history.reached_time is not None:
        found["warmup_time_s"] = history.reached_time
    for name, probe in probes_of(problem, history).items():
        found |= {f"probes.{name}.final_degC": probe.final_degC, f"probes.{name}.max_degC": probe.max_degC}
    share = efficiency_of(energy)
    if share is not None:
        found["efficiency"] = share
    return {name: float(value) for name, value in found.items() if value is not None and np.isfinite(value)}
