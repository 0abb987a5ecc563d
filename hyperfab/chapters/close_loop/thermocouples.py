"""Readings of a heated mold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.loop.problem import Array


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
