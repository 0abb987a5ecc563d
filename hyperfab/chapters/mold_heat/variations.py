"""``--variations``: many settings of films, powers and constants at once, on a mold reduced to a few unknowns."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.chapters.mold_heat.result import shown
from hyperfab.documents.heat import Variation, Variations
from hyperfab.documents.mold import MoldDocument
from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.inputs import Inputs
from hyperfab.thermal.course import Course
from hyperfab.thermal.history import History
from hyperfab.thermal.reduced import ReducedMold, reduce
from hyperfab.thermal.settings import Settings
from hyperfab.thermal.trail import examples

#: Columns of the table, each a factor on what the document says.
FACTORS = ("film", "power", "conductivity", "specific heat")
#: Where the run ends at its target, variations are followed this many times as long.
LONGER = 3.0
#: Points of each curve, and steps of each run.
POINTS, STEPS = 600, 400
#: The full run that the reduced mold is checked against errs by this share of the tolerance.
SHARPER = 0.1


@dataclass(frozen=True)
class Asked:
    """The variations of a file: columns of factors (b,) by name."""

    factors: dict[str, Array]

    @property
    def count(self) -> int:
        """Number of variations."""
        return len(next(iter(self.factors.values())))

    def settings(self, mold: ReducedMold) -> Settings:
        """Return them as numbers of a reduced mold."""
        plain = mold.plain(self.count)

        def scaled(values: Array, name: str) -> Array:
            return values * self.factors.get(name, np.ones(self.count))[:, None]

        return replace(
            plain,
            film=scaled(plain.film, "film"),
            power=scaled(plain.power, "power"),
            conductivity=scaled(plain.conductivity, "conductivity"),
            capacity=scaled(plain.capacity, "specific heat"),
        )


def read_variations(inputs: Inputs, file: str, document: MoldDocument, mold: str) -> Asked:
    """Read the table of factors; refuse molds that the reduced one cannot stand for."""
    _refuse_unfit(document, mold)
    table = read_table(inputs.read(file), file, {}, optional=dict.fromkeys(FACTORS, "dimensionless"))
    factors = {name: table[name] for name in FACTORS if name in table}
    if not factors or len(table.lines) == 0:
        raise InputError(
            "has no variation",
            file=file,
            remedy=f"write columns named {', '.join(FACTORS)}: factors on what the mold document says",
        )
    for name, values in factors.items():
        wrong = values < 0.0 if name in ("film", "power") else values <= 0.0
        table.refuse(wrong, "{:g} is no factor", column=name, remedy="1 is what the mold document says")
    return Asked(factors)


def vary(asked: Asked, document: MoldDocument, problem: Problem, history: History, start: Array) -> Variations:
    """Run the variations on the reduced mold, which is checked against ``history``, the full run."""
    end, work = history.states[-1].time, problem.work_surface
    duration = LONGER * end if document.run.until is None else end
    sensors = np.array(list(problem.probes.values())).reshape(-1, problem.model.size)
    states = examples(history.states)[1:]
    conducts = asked.factors.get("conductivity", np.ones(1))
    mold = reduce(
        problem.model, sensors, start, duration, None, corners=problem.corners, states=states,
        conducting=sorted({1.0, float(np.min(conducts)), float(np.max(conducts))}),
    )  # fmt: skip
    times = np.linspace(0.0, duration, POINTS)
    grid = np.union1d(mold.grid(0.0, duration, STEPS), history.states.times)
    rows_found = []
    for i, course in enumerate(mold.courses(grid, asked.settings(mold))):
        one = Variation(factors={name: float(values[i]) for name, values in asked.factors.items()})
        if work is not None:
            if document.run.target is not None:
                one.warmup_time_s = course.when(work.mean_weights @ mold.basis, document.run.target)
            then = course.at(np.array([duration if one.warmup_time_s is None else one.warmup_time_s]))[0]
            even = work.evenness(mold.basis @ then)
            one.work_surface_mean_degC, one.work_surface_spread_K = even.mean, even.spread
        for name, probe in shown(problem, times, course.at(times) @ mold.probes.T).items():
            one.probes_max_degC[name], one.probes_final_degC[name] = probe.max_degC, probe.final_degC
        rows_found.append(one)
    return Variations(
        duration_s=duration,
        unknowns=len(mold.start),
        difference_max_K=_difference(mold, next(mold.courses(grid, mold.plain())), problem, history),
        runs=rows_found,
    )


def variations_csv(found: Variations) -> bytes:
    """Return one row a variation: its factors, then what it does."""
    first = found.runs[0]
    header = [*(f"{name} [-]" for name in first.factors), "warmup_time_s", "work_surface_mean_degC"]
    header += ["work_surface_spread_K"]
    header += [f"{name}_{what}_degC" for what in ("final", "max") for name in first.probes_final_degC]
    rows = [
        [
            *run.factors.values(),
            run.warmup_time_s,
            run.work_surface_mean_degC,
            run.work_surface_spread_K,
            *run.probes_final_degC.values(),
            *run.probes_max_degC.values(),
        ]
        for run in found.runs
    ]
    return csv_bytes(header, rows)


def _refuse_unfit(document: MoldDocument, name: str) -> None:
    """The reduced mold has constant materials, and heaters that follow the clock alone."""
    why: tuple[str, str] | None = None
    for key, stuff in document.material.items():
        if isinstance(stuff.conductivity, TableFile) or isinstance(stuff.specific_heat, TableFile):
            why = (f"material.{key}", "constants that change with temperature")
    if any(heater.control is not None for heater in document.heater):
        why = ("heater", "a thermostat")
    if document.temperature:
        why = ("temperature", "held temperatures")
    if any(contact.fresh is not None for contact in document.contact):
        why = ("contact", "parts that come fresh")
    if document.production is not None:
        why = ("production", "pieces laid in and taken out")
    if document.run.steady:
        why = ("run.steady", "a steady state")
    if why is not None:
        raise InputError(
            f"--variations is not for a mold with {why[1]}",
            file=name,
            key=why[0],
            remedy="use hf sweep, which runs every case in full",
        )


def _difference(mold: ReducedMold, nominal: Course, problem: Problem, history: History) -> float:
    """Return how far the reduced mold is from the full run at any of its steps, at probes and the work surface [K]."""
    nodes = np.zeros(0, dtype=np.int64) if problem.work_surface is None else problem.work_surface.all_nodes
    most = 0.0
    for past, coordinates in zip(history.states, nominal.at(np.array(history.states.times)), strict=True):
        off = mold.basis @ coordinates - past.temperature
        felt = [off @ sensor for sensor in problem.probes.values()]
        most = max(most, float(np.abs([*felt, *off[nodes]]).max(initial=0.0)))
    return most
