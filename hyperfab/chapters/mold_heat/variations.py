"""``--variations``: many settings of films, powers and constants at once, on a mold reduced to a few unknowns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.documents.heat import Variation, Variations
from hyperfab.documents.mold import MoldDocument
from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.inputs import Inputs
from hyperfab.thermal.history import History
from hyperfab.thermal.reduced import ReducedMold, reduce
from hyperfab.thermal.sensors import as_shown
from hyperfab.thermal.settings import Settings

#: Columns of the table, each a factor on what the document says.
FACTORS = ("film", "power", "conductivity", "specific heat")
#: Where the run ends at its target, variations are followed this many times as long.
LONGER = 3.0
#: Points of each curve, steps of each run, and nodes of the work surface that are watched.
POINTS, STEPS, NODES = 600, 400, 60
#: Time scales of the basis: more than a fit needs, the surface is to be right soon after the start too.
SCALES = (1000.0, 300.0, 100.0, 30.0, 10.0, 3.0)
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
        zero, one = np.zeros(self.count), np.ones(self.count)

        def each(name: str, columns: int) -> Array:
            return np.repeat(self.factors.get(name, one)[:, None], columns, axis=1)

        return Settings(
            film=each("film", len(mold.films)),
            conductivity=each("conductivity", mold.kinds),
            capacity=each("specific heat", mold.kinds),
            power=each("power", len(mold.heaters)),
            joint=np.zeros((self.count, len(mold.joints))) + np.array(mold.conductances),
            opened=np.zeros((self.count, 0)),
            start_K=np.zeros((self.count, len(mold.warmer))),
            ambient_K=zero,
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
    model, names = problem.model, list(problem.probes)
    end = history.states[-1].time
    duration = LONGER * end if document.run.until is None else end
    sensors, watched = list(problem.probes.values()), 0
    if problem.work_surface is not None:
        last = history.states[-1 if history.reached is None else history.reached].temperature
        nodes = _watched(np.unique(problem.work_surface.nodes), last)
        rows = np.zeros((len(nodes), model.size))
        rows[np.arange(len(nodes)), nodes] = 1.0
        sensors += [problem.work_surface.load(1.0) / problem.work_surface.area, *rows]
        watched = 1 + len(nodes)
    reading = np.array(sensors).reshape(len(sensors), model.size)
    mold = reduce(model, reading, start, duration, None, corners=problem.corners, scales=SCALES)
    times = np.linspace(0.0, duration, POINTS)
    curves = mold.run(times, asked.settings(mold), STEPS)
    rows_found = []
    for i in range(asked.count):
        factors = {name: float(values[i]) for name, values in asked.factors.items()}
        one = Variation(factors=factors)
        if watched:
            mean, surface = curves[i, :, len(names)], curves[i, :, len(names) + 1 :]
            at = duration if document.run.target is None else _reached(times, mean, document.run.target)
            one.warmup_time_s = at if document.run.target is not None else None
            when = duration if at is None else at
            nodal = np.array([np.interp(when, times, column) for column in surface.T])
            one.work_surface_mean_degC = float(np.interp(when, times, mean))
            one.work_surface_spread_K = float(nodal.max() - nodal.min())
        for j, name in enumerate(names):
            values = as_shown(times, curves[i, :, j], problem.lags[name])
            one.probes_max_degC[name] = float(values.max())
            one.probes_final_degC[name] = float(values[-1])
        rows_found.append(one)
    return Variations(
        duration_s=duration,
        unknowns=len(mold.start),
        difference_max_K=_difference(mold, history, reading),
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


def _watched(nodes: NDArray[np.int64], temperature: Array) -> NDArray[np.int64]:
    """Return the hottest and the coldest node of a surface, and some between."""
    order = nodes[np.argsort(temperature[nodes], kind="stable")]
    return np.unique(order[np.linspace(0, len(order) - 1, NODES).round().astype(np.int64)])


def _reached(times: Array, mean: Array, target: float) -> float | None:
    """Return when a curve first reaches the target, linear between its close points."""
    above = np.flatnonzero(mean >= target)
    if len(above) == 0:
        return None
    i = int(above[0])
    if i == 0:
        return 0.0
    share = (target - mean[i - 1]) / (mean[i] - mean[i - 1])
    return float(times[i - 1] + share * (times[i] - times[i - 1]))


def _difference(mold: ReducedMold, history: History, reading: Array) -> float:
    """Return how far the reduced mold is from the full run at any of its steps [K]."""
    times = np.array([state.time for state in history.states])
    full = np.array([reading @ state.temperature for state in history.states])
    nominal = Asked({"film": np.ones(1)})
    return float(np.abs(mold.run(times, nominal.settings(mold), STEPS)[0] - full).max())
