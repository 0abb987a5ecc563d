"""Measured files of a press, a sheet or thermocouples: read, counted, how loud, and those that take no part."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.job import Job
from hyperfab.chapters.look import stated_noise
from hyperfab.errors import InputError, UsageError, placed
from hyperfab.io.csv_table import Table, read_table
from hyperfab.io.dictionary import plain
from hyperfab.io.headings import Heading, is_of
from hyperfab.io.layout import Layout, filled_in
from hyperfab.io.long_log import extremes
from hyperfab.io.units import quantity
from hyperfab.loop.fitting import Fit
from hyperfab.loop.known import F, File, FilesProblem
from hyperfab.loop.no_worse import none_apart
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import among_specimens, rounding
from hyperfab.loop.problem import Problem
from hyperfab.loop.scatter import Guess, levels
from hyperfab.loop.thresholds import FEWEST
from hyperfab.numerics.doubt import leap
from hyperfab.numerics.spikes import off_in_hold

#: The quantity that ``--noise`` states of each kind of reading.
_QUANTITIES = {
    "pressure": "stress",
    "thickness": "length",
    "formed": "length",
    "fabric": "length",
    "place": "length",
    "force": "force",
    "contact": "dimensionless",
}


@dataclass(frozen=True)
class Files(Generic[F]):
    """The files of ``--measured``, and those of ``--hold-out``; what ``--noise`` states of which quantity, how many
    rows of which kind were not taken, and how the others are understood."""

    measured: list[F]
    apart: list[F] = field(default_factory=list)
    level: tuple[str, float] | None = None
    left_out: Counter[str] = field(default_factory=Counter)
    preparation: list[str] = field(default_factory=list)

    def misses(self, problem: FilesProblem[F]) -> Callable[[Fit], float]:
        """Return what says how far a model misses the readings that were set apart; by nothing where none were."""
        return set_apart(problem, self.apart).misses if self.apart else none_apart

    def noise(self, problem: FilesProblem[F], predicted: Array | None) -> Noise:
        """Return the noise of the files less what a model predicts (the model as it is where None).

        What was stated of a file's quantity holds, else its sd column, else what it seems to be. Files of a kind whose
        estimates differ by no more than chance were read with the same instrument: they have the mean of them; noise in
        proportion to the reading is looked for in all of them. None is less than what rounding leaves.
        """
        if predicted is None:
            predicted = problem.delivered
        sd, unsure, count, source = np.ones(len(problem.measured)), 0.0, 0, ""
        guessed: dict[str, list[tuple[Ints, Guess]]] = {}
        for one in self.measured:
            rows = problem.rows_of(one.name)
            if self.level is not None and self.level[0] == _QUANTITIES.get(one.kind):
                sd[rows], how = self.level[1], "stated"
            elif one.sd is not None:
                sd[rows], how = one.sd, "standard deviations in the data"
            else:
                guess = one.guess(predicted[rows])
                how = guess.source
                if guess.rows is None:
                    guessed.setdefault(one.kind, []).append((rows, guess))
                else:
                    sd[rows] = guess.rows
                    unsure += len(rows) ** 2 / guess.dof
                if guess.is_assumed:  # what one file rests on, the verdict does
                    source = how
            source = source or how
            count += len(rows)
        for group in guessed.values():
            for rows, size, known in levels(problem.measured, group):
                sd[rows] = np.maximum(size, rounding(problem.measured[rows]))
                unsure += len(rows) ** 2 / known
        return among_specimens(problem, Noise(sd, count**2 / unsure if unsure > 0.0 else np.inf, source))


def read_files(
    job: Job,
    given: Given,
    read: Callable[[Job, str, Layout, Counter[str]], Sequence[F]],
    quantities: Sequence[str],
) -> Files[F]:
    """Read every file, of which each may hold several specimens, of ``quantities`` that ``--noise`` may state;
    InputError where there are too few readings."""
    found: Files[F] = Files([], level=stated_noise(given.case.noise, quantities))
    for name in given.case.readings:
        found.measured.extend(read(job, name, given.layout, found.left_out))
    if sum(len(one.values) for one in found.measured) < FEWEST:
        raise InputError(
            "has too few readings to tell noise from a residual",
            file=given.case.readings[0],
            remedy=f"give {FEWEST} or more",
        )
    for name in given.case.held:
        found.apart.extend(read(job, name, given.layout, found.left_out))
    if found.level is not None and all(found.level[0] != _QUANTITIES.get(one.kind) for one in found.measured):
        raise UsageError("--noise states another kind of reading than the files hold")
    return found


def stated_size(text: str | None, kind: str) -> float | None:
    """Return the size of ``--noise`` where readings are of one ``kind``."""
    told = stated_noise(text, (kind,))
    return None if told is None else told[1]


def told_left_out(left_out: Mapping[str, int]) -> list[str]:
    """Return the sentence that says how many rows of which kind were not taken, if any."""
    counts = "; ".join(f"{count} rows of {what}" for what, count in left_out.items())
    return [f"left out: {counts}"] if counts else []


def unread(job: Job, name: str, table: Table) -> None:
    """Note the columns of a file that nothing was taken from."""
    if table.aside:
        job.console.note(f"{name}: columns not used: {', '.join(one.title for one in table.aside)}")


def stated_in(table: Table, key: str, kind: str = "temperature") -> float | None:
    """Return a quantity that a file states of all its readings, or None."""
    with placed(table.name, key):
        value = quantity(table.metadata[key], kind) if key in table.metadata else None
    return value


def spread(table: Table, column: str) -> Array | None:
    """Return the standard deviations a file states beside a column, or None."""
    name = f"{column} sd"
    return table[name] if name in table and np.all(table[name] > 0.0) else None


def check_fixed(fix: Sequence[str], names: Sequence[str], what: str) -> None:
    """UsageError where ``--fix`` names none of the constants that a model has."""
    for key in fix:
        if key not in names:
            raise UsageError(f"--fix {key}: the {what} has no such constant; it has {', '.join(names)}")


@dataclass(frozen=True)
class Apart:
    """Readings (n,) that take no part, and the ``rows`` they would have in a wider ``problem``."""

    problem: Problem
    rows: slice
    measured: Array

    def predicted(self, fit: Fit) -> Array:
        """Return what a model says of them."""
        return self.problem.predict(fit.x[: fit.own], fit.terms)[self.rows]

    def misses(self, fit: Fit) -> float:
        """Return by how much a model misses them, rms."""
        missed = float(np.sqrt(np.mean((self.measured - self.predicted(fit)) ** 2)))
        return missed if np.isfinite(missed) else np.inf


def set_apart(problem: Any, files: Sequence[File]) -> Apart:
    """Return the readings of files that take no part."""
    values = np.concatenate([one.values for one in files])
    for one in files:
        problem = problem.with_reading(one)
    return Apart(problem, slice(len(problem.measured) - len(values), None), values)


@dataclass(frozen=True)
class Thermocouples:
    """Times (t,) [s], readings (t, p) [degC], nan where one is missing, and the probes' names, as in the file.

    ``powers`` (t,) [W] are what heaters drew, where the file says it: ``power`` all together, ``heater.0.power`` the
    first of the mold; ``left_out`` counts readings that each probe lacks, rows that are no reading, and readings that
    stood off their neighbours and are nan; ``unread`` are columns that nothing was taken from and that may tell
    the power.
    """

    times: Array
    readings: Array
    names: list[str]
    powers: Mapping[str, Array] = field(default_factory=dict)
    left_out: Mapping[str, int] = field(default_factory=dict)
    unread: tuple[Heading, ...] = ()


def read_thermocouples(
    job: Job, name: str, probes: Sequence[str], layout: Layout, rated: Mapping[str, float | None] | None = None
) -> Thermocouples:
    """Read a thermocouple file; every column of a temperature must be a probe of the mold.

    A power that is told as a share, of one or in per cent, is one of what is ``rated`` [W] by its name; None where the
    mold has no such rating.
    """
    rated = rated or {}
    shares = {one.name: one for one in layout.columns if one.name in rated and is_of(one.unit or "", "dimensionless")}
    for one, share in shares.items():
        if rated[one] is None:
            raise InputError(
                "is a share of what power? the mold has no rating of it",
                file=name,
                column=share.title,
                remedy=f"write what was drawn, as {one} [W]",
            )
    table = read_table(
        job.inputs.read(name),
        name,
        {"time": "time"},
        optional={one: "dimensionless" if one in shares else "power" for one in rated},
        increasing="time",
        rest="temperature",
        called=probes,
        layout=layout,
        gaps=True,
    )
    unread(job, name, table)
    known = {probe.casefold(): probe for probe in probes}
    log = {column: values for column, values in table.columns.items() if column not in ("time", *rated)}
    for probe, ends in extremes([*log], probes).items():
        low, high = (log.pop(end) for end in ends)
        if probe.casefold() not in map(str.casefold, log):
            job.console.note(f"{name}: {probe} is taken as the middle of {' and '.join(ends)}")
            log[probe] = 0.5 * (low + high)
    columns = [*log]
    strange = [column for column in columns if column.casefold() not in known]
    if strange:
        told = [one.entry for one in layout.columns]
        remedy = f'call a [[probe]] so (name = "{strange[0]}")'
        taken = {column.casefold() for column in columns}
        free = [probe for probe in probes if probe.casefold() not in taken]
        if free:  # centre Ave. is likely the centre
            named = [(one, probe) for one in strange for probe in free if f" {plain(probe)} " in f" {plain(one)} "]
            likely = named if len(dict(named)) == len({probe for _, probe in named}) == len(named) else []
            entries = [(one, f"{probe} [degC]") for one, probe in likely or [(strange[0], free[0])]]
            remedy += f", or say which it is, as in {filled_in([*told, *entries])}"
        if len(strange) < len(columns):
            remedy += f", or leave the others out: {filled_in([*told, *((column, 'aside') for column in strange)])}"
        raise InputError(
            f"is no probe of the mold; it has {', '.join(probes) or 'none'}",
            file=name,
            column=strange[0],
            remedy=remedy,
        )
    readings = np.stack([log[column] for column in columns], axis=1)
    for number, column in enumerate(columns):
        if np.isfinite(readings[:, number]).sum() < FEWEST:
            raise InputError(
                "has too few readings to tell noise from a residual",
                file=name,
                column=column,
                remedy=f"give {FEWEST} or more, or leave the column out",
            )
    powers = {one: table[one] * (rated[one] or 0.0 if one in shares else 1.0) for one in rated if one in table}
    names = [known[column.casefold()] for column in columns]
    lacking = zip(names, (~np.isfinite(readings)).sum(axis=0), strict=True)
    left_out = {f"no reading of {name}": int(count) for name, count in lacking if count} | dict(table.left_out)
    for number, probe in enumerate(names):
        there = np.flatnonzero(np.isfinite(readings[:, number]))
        own = readings[there, number]
        # A loose plug, a switched relay stand off both sides of their neighbours.
        rows = there[sorted(off_in_hold(np.ones_like(own), own, leap(own, float(np.ptp(own)))))]
        if rows.size:
            left_out[f"{probe} off its neighbours"] = int(rows.size)
            job.console.warn(
                f"{name}, line {table.lines[rows[0]]}: {probe} reads {readings[rows[0], number]:g} degC, off its "
                f"neighbours{f', as {rows.size - 1} more' if rows.size > 1 else ''}; left out"
            )
            readings[rows, number] = np.nan
    begun, last = table["time"][[0, -1]]
    if begun > last - begun:
        job.console.warn(
            f"{name}: the readings begin {begun:.6g} s after the start of the run and go on for {last - begun:.6g} s; "
            "time counts from the mold's start"
        )
    return Thermocouples(table["time"], readings, names, powers, left_out, table.aside)
