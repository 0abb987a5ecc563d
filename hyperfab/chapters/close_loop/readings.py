"""Measured files of a press or a sheet: read, counted, how loud they are, and those that take no part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hyperfab.chapters.close_loop.domain import Given
from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_table import Table
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Array, Problem

#: Readings below which noise cannot be told from a residual.
LEAST = 12


class Reading(Protocol):
    """One file: its name, and what was read, in the order of the problem's rows."""

    @property
    def name(self) -> str:
        """The file."""

    @property
    def values(self) -> Array:
        """What was read, row by row."""


R = TypeVar("R", bound=Reading)


@dataclass(frozen=True)
class Files(Generic[R]):
    """The files of ``--measured`` with their sd columns, and those of ``--hold-out``."""

    measured: list[tuple[R, Array | None]]
    apart: list[R]

    @property
    def plain(self) -> list[R]:
        """The measured files without what they say of their noise."""
        return [one for one, _ in self.measured]


def read_files(given: Given, read: Callable[[str], tuple[R, Array | None]]) -> Files[R]:
    """Read every file; InputError where there are too few readings."""
    measured = [read(name) for name in given.measured]
    if sum(len(one.values) for one, _ in measured) < LEAST:
        raise InputError(
            "has too few readings to tell noise from a residual",
            file=given.measured[0],
            remedy=f"give {LEAST} or more",
        )
    return Files(measured, [read(name)[0] for name in given.held])


def spread(table: Table, column: str) -> Array | None:
    """Return the standard deviations a file states beside a column, or None."""
    name = f"{column} sd"
    return table[name] if name in table and np.all(table[name] > 0.0) else None


def check_fixed(problem: Problem, fix: Sequence[str], what: str) -> None:
    """UsageError where ``--fix`` names no constant of the problem."""
    names = [one.name for one in problem.own]
    for key in fix:
        if key not in names:
            raise UsageError(f"--fix {key}: the {what} has no such constant; it has {', '.join(names)}")


def widened(problem: Any, apart: Sequence[Reading]) -> tuple[Problem, Array]:
    """Return the problem with files that take no part at its end, and what was read in them."""
    for one in apart:
        problem = problem.with_reading(one)
    return problem, np.concatenate([one.values for one in apart])


def noise_from(
    files: Sequence[tuple[R, Array | None]],
    level: Callable[[R], float | None],
    rows_of: Callable[[Any, R], NDArray[np.int64]],
    estimate: Callable[[Any, R, NDArray[np.int64], Array], tuple[float, float, str]],
) -> Callable[[Problem, Array | None], Noise]:
    """Return what tells the noise of the files less what a model predicts (the model as it is where None).

    For each file ``level`` is what was stated, else its sd column holds, else ``estimate`` returns from its rows of the
    prediction the standard deviation, its degrees of freedom, and how that was found.
    """

    def noise(problem: Problem, predicted: Array | None) -> Noise:
        if predicted is None:
            predicted = problem.predict(np.array([one.value for one in problem.own]), {})
        sd, unsure, count, source = np.ones(len(problem.measured)), 0.0, 0, ""
        for one, column in files:
            rows = rows_of(problem, one)
            told, known = level(one), np.inf
            if told is not None:
                sd[rows], how = told, "stated"
            elif column is not None:
                sd[rows], how = column, "standard deviations in the data"
            else:
                sd[rows], known, how = estimate(problem, one, rows, predicted)
            source = source or how
            count += len(rows)
            unsure += len(rows) ** 2 / known
        return Noise(sd, count**2 / unsure if unsure > 0.0 else np.inf, source)

    return noise
