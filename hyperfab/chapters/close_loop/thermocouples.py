"""Readings of a heated mold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.io.layout import Layout
from hyperfab.loop.problem import Array
from hyperfab.loop.thresholds import FEWEST_READ


@dataclass(frozen=True)
class Thermocouples:
    """Times (t,) [s], readings (t, p) [degC], nan where one is missing, and the probes' names, as in the file.

    ``power`` (t,) [W] is what all heaters drew together, where the file says it.
    """

    times: Array
    readings: Array
    names: list[str]
    power: Array | None = None

    @property
    def missing(self) -> dict[str, int]:
        """How many readings each probe lacks, by name, of those that lack any."""
        counts = (~np.isfinite(self.readings)).sum(axis=0)
        return {name: int(count) for name, count in zip(self.names, counts, strict=True) if count}


def read_thermocouples(job: Job, name: str, probes: Sequence[str], layout: Layout | None) -> Thermocouples:
    """Read a thermocouple file; every column of a temperature must be a probe of the mold."""
    table = read_table(
        job.inputs.read(name),
        name,
        {"time": "time"},
        optional={"power": "power"},
        increasing="time",
        rest="temperature",
        layout=layout,
        gaps=True,
    )
    known = {probe.casefold(): probe for probe in probes}
    columns = [column for column in table.columns if column not in ("time", "power")]
    for column in columns:
        if column.casefold() not in known:
            raise InputError(
                f"is no probe of the mold; it has {', '.join(probes) or 'none'}",
                file=name,
                column=column,
                remedy="name the columns after the [[probe]] tables",
            )
    readings = np.stack([table[column] for column in columns], axis=1)
    for number, column in enumerate(columns):
        if np.isfinite(readings[:, number]).sum() < FEWEST_READ:
            raise InputError(
                "has too few readings to tell noise from a residual",
                file=name,
                column=column,
                remedy=f"give {FEWEST_READ} or more, or leave the column out",
            )
    power = table["power"] if "power" in table.columns else None
    return Thermocouples(table["time"], readings, [known[column.casefold()] for column in columns], power)
