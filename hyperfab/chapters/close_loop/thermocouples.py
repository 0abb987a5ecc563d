"""Readings of a heated mold, and what they tell of its thermostats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.documents.mold import MoldDocument
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.loop.problem import Array
from hyperfab.thermal.tables import Table


@dataclass(frozen=True)
class Thermocouples:
    """Times (t,) [s], readings (t, p) [degC] and the probes' names, in the order of the files."""

    times: Array
    readings: Array
    names: list[str]


def read_thermocouples(job: Job, name: str, probes: Sequence[str], decimal: str | None) -> Thermocouples:
    """Read a thermocouple file; every column must be a probe of the mold."""
    table = read_table(
        job.inputs.read(name), name, {"time": "time"}, increasing="time", rest="temperature", decimal=decimal
    )
    known = {probe.casefold(): probe for probe in probes}
    columns = [column for column in table.columns if column != "time"]
    for column in columns:
        if column.casefold() not in known:
            raise InputError(
                f"is no probe of the mold; it has {', '.join(probes) or 'none'}",
                file=name,
                column=column,
                remedy="name the columns after the [[probe]] tables",
            )
    readings = np.stack([table[column] for column in columns], axis=1)
    if len(table["time"]) < 12:
        raise InputError(
            "has too few rows to tell noise from a residual", file=name, remedy="give 12 or more"
        )
    return Thermocouples(table["time"], readings, [known[column.casefold()] for column in columns])


def follow_thermostats(document: MoldDocument, built: Problem, read: Thermocouples, name: str) -> None:
    """Give each heater under a thermostat the power that its probe's readings say it drew.

    The switching of a model that is a little wrong drifts out of step with the real one; the measured probe tells when
    the real thermostat switched. Raises InputError where that probe was not read.
    """
    for number, (section, heater) in enumerate(zip(document.heater, built.model.heaters, strict=True)):
        control = section.control
        if control is None:
            continue
        if control.probe not in read.names:
            raise InputError(
                f"the thermostat's probe {control.probe!r} is not among the measured ones",
                file=name,
                key=f"heater.{number}.control",
                remedy='measure it too, or give the power that was drawn as schedule = "power.csv"',
            )
        seen = read.readings[:, read.names.index(control.probe)]
        at, on = switched(read.times, seen, control.set_point, control.band)
        heater.power = Table(at, on * np.array([heater.power.at(float(t)) for t in at]))


def switched(times: Array, seen: Array, set_point: float, band: float) -> tuple[Array, Array]:
    """Return times [s] and whether the heater was on (1 or 0) then: off at set + band/2, on at set - band/2.

    >>> at, on = switched(np.arange(4.0), np.array([0.0, 8.0, 12.0, 8.0]), 9.0, 2.0)
    >>> on.tolist()
    [1.0, 1.0, 0.0, 0.0, 1.0, 1.0]
    """
    smooth = seen.copy()
    if len(seen) > 4:
        smooth[1:-1] = np.median(np.stack([seen[:-2], seen[1:-1], seen[2:]]), axis=0)
    running = bool(smooth[0] < set_point + 0.5 * band)
    at, on = [float(times[0])], [float(running)]
    for i in range(1, len(times)):
        limit = set_point + (0.5 if running else -0.5) * band
        past = smooth[i] >= limit if running else smooth[i] <= limit
        if not past:
            continue
        step = float(smooth[i] - smooth[i - 1])
        share = min(max((limit - float(smooth[i - 1])) / step, 0.0), 1.0) if step else 1.0
        gap = float(times[i] - times[i - 1])
        moment = max(float(times[i - 1]) + share * gap, at[-1] + 1e-3 * gap)
        at += [moment, moment + 1e-3 * gap]
        on += [float(running), float(not running)]
        running = not running
    at.append(max(float(times[-1]), at[-1] + 1e-9))
    on.append(float(running))
    return np.array(at), np.array(on)
