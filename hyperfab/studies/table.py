"""The table of a study: one row a case, in the order of the study, whatever the order of completion."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.documents.study import LimitSection
from hyperfab.errors import InputError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.studies.plan import Plan, Step
from hyperfab.studies.store import Outcome, Store, is_result

Cell = float | int | bool | str | None
#: Digits of its hash that name a case in the table.
SHOWN = 12
#: The column of the running number of a case, which people call it by.
NUMBER = "number"
#: What a document says of how it was made.
_ASKED = frozenset({"provenance", "setup", "files"})


@dataclass
class Table:
    """Columns of equal length; a cell that was not computed is None. ``owners``: the step that each figure is of.
    ``validity``: by step, what its documents tell of the ranges in which laws and tables were used. ``found``: of each
    case a number that it shares with those that found the same, but for what was asked; empty where that is not known.
    """

    columns: dict[str, list[Cell]] = field(default_factory=dict)
    axes: dict[str, str] = field(default_factory=dict)
    figures: list[str] = field(default_factory=list)
    owners: dict[str, str] = field(default_factory=dict)
    validity: list[tuple[str, Any]] = field(default_factory=list)
    found: list[int] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.columns["case"])

    def numbers(self, column: str) -> Array | None:
        """Return a column as numbers, NaN where a cell is empty or what a failed step came to; None where it holds
        words.
        """
        cells = self.columns[column]
        if any(isinstance(cell, str) for cell in cells):
            return None
        found = np.array([np.nan if cell is None else float(cell) for cell in cells])
        if column in self.owners:
            failed = [step == self.owners[column] for step in self.columns["failed_step"]]
            found[np.array(failed) & ~self.done] = np.nan
        return found

    @property
    def done(self) -> Flags:
        """Which cases (rows,) came to their end, also with a negative verdict."""
        return np.array([is_result(status) for status in self.columns["status"]])

    def row(self, index: int) -> dict[str, Cell]:
        """Return one row, without its empty cells."""
        return {name: cells[index] for name, cells in self.columns.items() if cells[index] is not None}


def columns_of(plan: Plan) -> list[str]:
    """Return the names of the table's columns in their order; InputError where an axis or a figure has that of another.

    What stands in one column for two would be taken for either.
    """
    study = plan.study
    own = [*(["within_limits"] if study.limit else []), "failed_step", "message"]
    own += [f"{step.name}_document" for step in study.step]
    known = dict.fromkeys(["case", "status", "within_limits", *own], "a column of each table's own")
    axes, figures = [(axis.column, f"axis.{axis.name}") for axis in plan.axes], study.figures
    for name, key in [*axes, *((name, f"figures.{name}") for name in figures)]:
        if name in known:
            raise InputError(f"is the column {name}, {known[name]}", key=key, remedy="give one of them another name")
        known[name] = f"the column of {key}"
    names = ["case", *dict(axes), "status", *figures, *own]
    return names + ([] if NUMBER in names else [NUMBER])  # last: what reads the table by place finds all where it was


def collect(plan: Plan, store: Store, accidents: Mapping[str, Outcome]) -> Table:
    """Read the results of all cases out of ``store``; ``accidents`` are outcomes that were not kept there."""
    study = plan.study
    axes = {axis.name: axis.column for axis in plan.axes}
    figures = {name: path.split(".", 1) for name, path in study.figures.items()}
    columns: dict[str, list[Cell]] = {name: [] for name in columns_of(plan)}
    cache: dict[str, tuple[Outcome | None, dict[str, Cell], bytes]] = {}
    alike: dict[tuple[bytes, ...], int] = {}
    each: list[int] = []
    wanted = {step.name: {n: key for n, (owner, key) in figures.items() if owner == step.name} for step in study.step}
    last: dict[str, str] = {}
    validity: list[tuple[str, Any]] = []
    for case in plan:
        row: dict[str, Cell] = {"case": case.key[:SHOWN], NUMBER: len(columns["case"]) + 1, "status": 0}
        row |= {axes[name]: value for name, value in case.values.items()}
        told_by = []
        for step in case.steps:
            if step.key not in cache:
                cache.pop(last.get(step.name, ""), None)  # the steps a chain shares come one after another
                cache[step.key] = _step(store, accidents, step, wanted[step.name], validity)
                last[step.name] = step.key
            outcome, found, told = cache[step.key]
            row |= found
            told_by.append(told)
            if outcome is None:
                break
            if outcome.status:
                # A result that is not as asked for has no message but the warnings that say so.
                message = outcome.message or "; ".join(outcome.warnings)
                row |= {"status": outcome.status, "failed_step": step.name, "message": message}
            if not outcome.has_result:
                break
        if study.limit:
            row["within_limits"] = _within(row, study.limit)
        each.append(alike.setdefault(tuple(told_by), len(alike)))
        for name, cells in columns.items():
            cells.append(row.get(name))
    owners = {name: owner for name, (owner, _) in figures.items()}
    return Table(columns, axes, list(figures), owners, validity, each)


def _step(
    store: Store,
    accidents: Mapping[str, Outcome],
    step: Step,
    wanted: Mapping[str, str],
    validity: list[tuple[str, Any]],
) -> tuple[Outcome | None, dict[str, Cell], bytes]:
    """Return how a step ended, the figures ``wanted`` of it, and a digest of what it found."""
    outcome = store.outcome(step.key) or accidents.get(step.key)
    document = None if outcome is None else store.document(step)
    if document is None:
        return outcome, {}, b""
    if document.get("validity"):
        validity.append((step.name, document["validity"]))
    place = store.place(step.key).relative_to(store.folder) / f"{step.name}.json"
    found: dict[str, Cell] = {f"{step.name}_document": str(place)}
    for name, key in wanted.items():
        value = look_up(document, key)
        if isinstance(value, (bool, int, float, str)):
            found[name] = value
    return outcome, found, _told(document)


def _told(document: Mapping[str, Any]) -> bytes:
    """Return a digest of what a document tells, without what it was asked and what it was made from."""
    kept = {key: value for key, value in document.items() if key not in _ASKED}
    sure = kept.get("uncertainty")
    if isinstance(sure, Mapping):  # its sources are called by the files that they stand in
        kept["uncertainty"] = {key: value for key, value in sure.items() if key != "sources"}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).digest()[:16]


def look_up(document: Any, key: str) -> Any:
    """Return what stands under a dotted key, or None.

    A name may hold dots itself.

    >>> look_up({"regions": [{"area_mm2": 12.0}]}, "regions.0.area_mm2")
    12.0
    >>> look_up({"power_lost_W": {"convection plate.z+": 3.0}}, "power_lost_W.convection plate.z+")
    3.0
    """
    parts = key.split(".")
    for count in range(1, len(parts) + 1):
        name, rest = ".".join(parts[:count]), ".".join(parts[count:])
        if isinstance(document, Mapping) and name in document:
            found = document[name]
        elif isinstance(document, list) and name.isdecimal() and int(name) < len(document):
            found = document[int(name)]
        else:
            continue
        if rest:
            found = look_up(found, rest)
        if found is not None:
            return found
    return None


def to_csv(table: Table) -> bytes:
    """Return the table as CSV; numbers are written so that reading them gives the same doubles.

    >>> to_csv(Table({"case": ["ab"], "force_N": [0.1], "message": [None]}))
    b'case,force_N,message\\nab,0.1,\\n'
    """
    return csv_bytes(
        list(table.columns),
        list(zip(*(map(_no_formula, cells) for cells in table.columns.values()), strict=True)),
    )


def _no_formula(value: Cell) -> Cell:
    """Return what no spreadsheet takes for a formula."""
    return f"'{value}" if isinstance(value, str) and value.lstrip()[:1] in ("=", "@", "+", "-") else value


def to_parquet(table: Table) -> bytes:
    """Return the table as Parquet. Raises ImportError where pyarrow is not installed."""
    import pandas as pd

    buffer = io.BytesIO()
    frame = pd.DataFrame({name: _column(cells) for name, cells in table.columns.items()})
    frame.to_parquet(buffer, engine="pyarrow", index=False)
    return buffer.getvalue()


def _column(cells: Sequence[Cell]) -> list[Cell]:
    words = any(isinstance(cell, str) for cell in cells)
    return [str(cell) if words and cell is not None else cell for cell in cells]


def _within(row: Mapping[str, Cell], limits: Mapping[str, LimitSection]) -> bool | None:
    """Whether a case keeps to all limits; None where it failed or a figure it is judged by is missing."""
    if not is_result(row["status"]):
        return None
    for name, limit in limits.items():
        value = row.get(name)
        if not isinstance(value, (int, float)):
            return None
        if limit.least is not None and value < limit.least:
            return False
        if limit.most is not None and value > limit.most:
            return False
    return True
