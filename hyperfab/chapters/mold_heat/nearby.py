"""The neighbours of a heated mold, for how sure its figures are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.chapters.mold_heat.result import shown
from hyperfab.chapters.uncertainty.carry import Answer, Changes, Figures, Nearby
from hyperfab.chapters.uncertainty.sources import Entry, Film, Number, Origins
from hyperfab.documents.mold import MoldDocument
from hyperfab.thermal.condition import Contact, Convection, Heater, Radiation
from hyperfab.thermal.course import Course
from hyperfab.thermal.history import History
from hyperfab.thermal.projected import why_not
from hyperfab.thermal.reduced import ReducedMold, reduce
from hyperfab.thermal.settings import Settings
from hyperfab.thermal.trail import examples

#: Which condition an entry of the mold document speaks of, and which factor its number is.
_FLOWS = {
    ("heater", "power"): (Heater, "power"),
    ("heater", "flux"): (Heater, "power"),
    ("convection", "h"): (Convection, "film"),
    ("contact", "h"): (Contact, "joint"),
}
#: Steps to as long as the run took, and points of the curves of probes.
STEPS, POINTS = 20, 200
#: How long runs to a target are followed, over what the run took: most that are drawn, and what has the target at all.
LONGER = (1.25, 3.0)
#: Temperatures are no sharper than this part of what a step may be off by.
_SHARP = 0.1


@dataclass
class Beside(Nearby):
    """What the figures become beside a run: on the mold reduced to the states it went through and to what it answers.

    It ends at the target where it ``stops`` there, else at ``end`` [s].
    """

    # The basis and the steps of time are the same for all: differences may be small.
    samples, step = 200, 0.25

    problem: Problem
    origins: Origins
    reads: Sequence[_Number]
    mold: ReducedMold
    target: float | None
    stops: bool
    end: float
    value: Figures
    tolerance: float

    def __post_init__(self) -> None:
        # What the basis leaves out is the same for all: they count from the run itself.
        self._off: Figures = {}
        base = self.at({})
        self._off = {name: self.value[name] - value for name, value in base.figures.items() if name in self.value}

    def blur(self, name: str) -> float:
        """Return below which difference [K] two temperatures are one, 0 for other figures."""
        return _SHARP * self.tolerance if name.startswith(("work_surface", "probes")) else 0.0

    def at(self, changes: Changes) -> Answer:
        settings = self.mold.plain()
        for number, by in zip(self.reads, self.origins.amounts(changes), strict=True):
            number.add(settings, float(by))
        course, reached = self._course(settings)
        end = reached if self.stops and reached is not None else float(course.grid[-1])
        field = self.mold.basis @ course.at(np.array([end]))[0]
        supplied, stored = self._energy(settings, course, end)
        found = {"energy.supplied_J": supplied, "energy.lost_J": supplied - stored, "energy.stored_J": stored}
        if reached is not None:
            found["warmup_time_s"] = reached
            supplied, stored = self._energy(settings, course, reached)
        if supplied > 0.0:
            found["efficiency"] = stored / supplied
        times = np.union1d(course.grid[course.grid < end], np.linspace(0.0, end, POINTS))
        for name, probe in shown(self.problem, times, course.at(times) @ self.mold.probes.T).items():
            found |= {f"probes.{name}.final_degC": probe.final_degC, f"probes.{name}.max_degC": probe.max_degC}
        if self.problem.work_surface is not None:
            even = self.problem.work_surface.evenness(field)
            found |= {"work_surface.mean_degC": even.mean, "work_surface.spread_K": even.spread}
            found |= {"work_surface.min_degC": even.least, "work_surface.max_degC": even.greatest}
        found = {name: value + self._off.get(name, 0.0) for name, value in found.items()}
        return Answer(found, {"temperature_degC": field[: self.problem.mesh.solid]})

    def _course(self, settings: Settings) -> tuple[Course, float | None]:
        """Return a run, and when it reaches the target."""
        work = self.problem.work_surface
        for longer in LONGER if self.stops else (1.0,):
            grid = self.mold.grid(0.0, longer * self.end, round(longer * STEPS))
            course = next(self.mold.courses(grid, settings))
            if self.target is None or work is None:
                break
            reached = course.when(work.mean_weights @ self.mold.basis, self.target)
            if reached is not None:
                return course, reached
        return course, None

    def _energy(self, settings: Settings, course: Course, end: float) -> tuple[float, float]:
        """Return what is supplied and what is stored up to a time [J]."""
        heaters = zip(settings.power[0], self.mold.heaters, strict=True)
        supplied = sum(factor * float(table.integral(np.array(end))) for factor, (_, table) in heaters)
        risen = self.mold.stored(course.at(np.array([end]))[0] - course.states[0])
        return float(supplied), float(settings.capacity[0, self.mold.materials] @ risen)


@dataclass(frozen=True)
class _Number:
    """A number of the mold document: which ``kind`` of settings it moves, and of what ``keys``.

    These are factors on its ``value``, or what it is off by where there is none.
    """

    kind: str
    keys: tuple[int, ...]
    value: float | None = None

    def add(self, settings: Settings, by: float) -> None:
        """Change it by so much."""
        of_run = getattr(settings, self.kind)[0]
        for key in self.keys:
            of_run[key] = of_run[key] + by if self.value is None else of_run[key] * (1.0 + by / self.value)


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
    films = [one for one in model.conditions if isinstance(one, Convection)]
    tables = [number.table for number in origins.numbers if isinstance(number, Film)]
    unsure = [k for k, one in enumerate(films) if any(one.film is table for table in tables)]
    began = [k for k, part in enumerate(document.part) if part.start is not None]
    reads = [_read(number, document, problem, unsure, began) for number in origins.numbers]
    known = [one for one in reads if one is not None]
    if len(known) < len(reads):
        return None
    stops = document.run.until is None
    if stops and history.reached is None:
        return None
    sensors = np.array(list(problem.probes.values())).reshape(-1, model.size)
    end = history.states[-1].time
    mold = reduce(
        model, sensors, history.states[0].temperature, end, None, corners=problem.corners, groups=[[k] for k in began],
        absent=[Convection(one.name, one.facets, one.film.spread, one.ambient) for one in (films[k] for k in unsure)],
        states=examples(history.states)[1:],
    )  # fmt: skip
    return Beside(problem, origins, known, mold, document.run.target, stops, end, value, document.run.tolerance)


def _read(
    number: Number, document: MoldDocument, problem: Problem, unsure: Sequence[int], began: Sequence[int]
) -> _Number | None:
    """Return what a number of the document changes; None for those that have no short way.

    ``unsure`` are the films that come once more with their standard deviations, ``began`` the parts with own starts.
    """
    conditions = problem.model.conditions
    films = [one for one in conditions if isinstance(one, Convection)]
    if isinstance(number, Film):
        return _Number("film", tuple(len(films) + k for k, at in enumerate(unsure) if films[at].film is number.table))
    if not isinstance(number, Entry) or number.value == 0.0:
        return None
    place, value = number.place, number.value
    if place == ("run", "start"):
        return _Number("start_K", (0,))
    kind, which, key = (*place, None, None)[:3]
    if kind == "part" and key == "start":
        return _Number("start_K", (1 + began.index(int(str(which))),))
    if kind == "material":
        kinds = {"conductivity": "conductivity", "specific_heat": "capacity", "density": "capacity"}
        names = list(dict.fromkeys(material.name for material in problem.model.materials))
        used = (names.index(str(which)),) if which in names else ()
        return _Number(kinds[str(key)], used, value) if key in kinds else None
    condition, setting = _FLOWS.get((str(kind), str(key)), (Radiation if kind == "radiation" else Convection, ""))
    if not setting and (key != "ambient" or kind not in ("convection", "radiation")):
        return None
    if sum(isinstance(one, condition) for one in conditions) != len(getattr(document, str(kind))):
        return None
    at = int(str(which))
    if setting:
        return _Number(setting, (at,), value)
    if kind == "radiation":
        return _Number("ambient_K", (len(films) + len(unsure) + at,))
    return _Number("ambient_K", (at, *(len(films) + k for k, film in enumerate(unsure) if film == at)))
