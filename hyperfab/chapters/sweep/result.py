"""The outcome of a study: its table, main effects, Pareto front, and pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from hyperfab.cases.sweep import SweepCase
from hyperfab.chapters.job import Job
from hyperfab.documents.sweep import FigureRange, Front, SweepDocument
from hyperfab.io.output import Output
from hyperfab.report.figures_sweep import cases_png, effects_png
from hyperfab.studies.effects import idle, main_effects, pareto_front
from hyperfab.studies.plan import Plan
from hyperfab.studies.store import Outcome, Store
from hyperfab.studies.table import NUMBER, Table, collect, to_csv, to_parquet


def write_result(
    job: Job, plan: Plan, store: Store, accidents: Mapping[str, Outcome], output: Output, case: SweepCase
) -> tuple[int, int]:
    """Write the table and the document; return how many cases failed, and how many have a negative verdict."""
    table = collect(plan, store, accidents)
    for step, entries in table.validity:
        job.ranges.taken(step, {"validity": entries})
    effects = main_effects(table, plan.axes)
    still = idle(table, plan.layout)
    if still:
        job.console.warn(
            f"along {', '.join(still)} every case finds the same: what is set there plays no part in it. See that "
            "these runs can tell it, and where the edited document has the number: a fabric of two directions has its "
            "constants under directions.warp and directions.weft, one of several temperatures in a row for each"
        )
    senses = _senses(plan, table)
    document = SweepDocument(
        name=plan.study.name,
        question=plan.study.question,
        cases=len(plan),
        steps=_different_steps(table),
        by_status={str(status): count for status, count in sorted(Counter(table.columns["status"]).items())},
        axes=table.axes,
        figures=_ranges(table),
        limits={name: limit.model_dump(exclude_none=True) for name, limit in plan.study.limit.items()},
        effects=effects,
        idle=still,
        front=_front(plan, table),
        best=_best(table, senses),
        senses=senses,
        table=output.path(".csv").name,
    )
    if plan.study.limit:
        document.within_limits = sum(cell is True for cell in table.columns["within_limits"])
    output.add(".csv", to_csv(table))
    if case.parquet:
        output.add(".parquet", to_parquet(table))
    if effects:
        output.add(".effects.png", effects_png(effects))
        output.add(".cases.png", cases_png(table, None if document.front is None else document.front.cases))
    job.write(output, document, case)
    statuses = table.columns["status"]
    return sum(status not in (0, 1) for status in statuses), sum(status == 1 for status in statuses)


def _different_steps(table: Table) -> int:
    return sum(
        len({cell for cell in cells if cell is not None})
        for name, cells in table.columns.items()
        if name.endswith("_document")
    )


def _ranges(table: Table) -> dict[str, FigureRange]:
    found = {}
    for name in table.figures:
        values = table.numbers(name)
        if values is not None and np.isfinite(values).any():
            known = values[np.isfinite(values)]
            found[name] = FigureRange(
                cases=len(known),
                least=float(known.min()),
                mean=float(known.mean()),
                greatest=float(known.max()),
            )
    return found


def _eligible(table: Table) -> np.ndarray:
    """Return which cases may be the best: those that came to their end, within the limits."""
    if "within_limits" not in table.columns:
        return table.done
    return np.array([cell is True for cell in table.columns["within_limits"]])


def _front(plan: Plan, table: Table) -> Front | None:
    wish = plan.study.pareto
    if wish is None:
        return None
    names = [*wish.minimize, *wish.maximize]
    directions = ["minimize"] * len(wish.minimize) + ["maximize"] * len(wish.maximize)
    columns = []
    for name, direction in zip(names, directions, strict=True):
        values = table.numbers(name)
        if values is None:
            return None
        columns.append(np.where(_eligible(table), values if direction == "minimize" else -values, np.nan))
    rows = pareto_front(columns[0], columns[1])
    return Front(figures=names, directions=directions, cases=[str(table.columns["case"][row]) for row in rows])


def _senses(plan: Plan, table: Table) -> dict[str, str]:
    """Return what is wanted of a figure, where the study says it: by a goal, or by a limit on one side alone."""
    wish, found = plan.study.pareto, {}
    for name in table.figures:
        limit = plan.study.limit.get(name)
        if wish is not None and name in (*wish.minimize, *wish.maximize):
            found[name] = "greatest" if name in wish.maximize else "least"
        elif limit is not None and (limit.least is None) != (limit.most is None):
            found[name] = "greatest" if limit.most is None else "least"
    return found


def _best(table: Table, senses: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Return, for each figure, the row with its best value within the limits: the least, or the greatest if wanted."""
    found: dict[str, dict[str, Any]] = {}
    shown = ["case", NUMBER, *table.axes.values(), *table.figures]
    for name in table.figures:
        values = table.numbers(name)
        if values is None:
            continue
        values = np.where(_eligible(table), values, np.nan)
        if np.isfinite(values).any():
            place = np.nanargmax(values) if senses.get(name) == "greatest" else np.nanargmin(values)
            row = table.row(int(place))
            found[name] = {key: row[key] for key in shown if key in row}
    return found
