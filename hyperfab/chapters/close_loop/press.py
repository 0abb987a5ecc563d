"""The loop on a press: a press document against pressure, contact, thickness, or force over stroke."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.extended_press import FOAM, SET, extend
from hyperfab.chapters.close_loop.finalise import MODEL_SUFFIXES, finish
from hyperfab.chapters.close_loop.press_places import on_front, told_of_places, with_heights
from hyperfab.chapters.close_loop.readings import Files, spread, stated_in, unread
from hyperfab.chapters.close_loop.readings import read_files as read_measured
from hyperfab.chapters.close_loop.taken import AS_READ, at_places, once, past_touch, pushed, specimens
from hyperfab.chapters.close_loop.upstream_written import WRITTEN
from hyperfab.chapters.fit.prepare import Steps
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact import SIBLINGS, note_ranges, solve
from hyperfab.chapters.press_contact.formed import formed, read_setting
from hyperfab.chapters.press_contact.formed import note_ranges as note_set_ranges
from hyperfab.chapters.press_contact.laws import compression_law, note_temperature
from hyperfab.chapters.press_contact.model import model_of, read_files
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.chapters.press_contact.warmth import column_of
from hyperfab.chapters.rerun import Listener, check_unchanged, unchanged
from hyperfab.documents.foam import MaterialLaw
from hyperfab.errors import InputError, UsageError
from hyperfab.io.cells import plain_values
from hyperfab.io.csv_table import Table, read_tables
from hyperfab.io.dictionary import plain
from hyperfab.io.headings import is_of, meaning
from hyperfab.io.layout import Layout
from hyperfab.loop.catalogue.press import FoamContext
from hyperfab.loop.press import PressProblem, press_problem
from hyperfab.loop.press_reading import Kind, Reading, Setting, Warmth
from hyperfab.loop.press_table import press_table

#: Columns of readings at places, their unit, and the kind of reading each is.
_COLUMNS = {
    "pressure": "stress",
    "contact": "dimensionless",
    "thickness": "length",
    "formed thickness": "length",
    "height": "length",
}
#: Colours of films are told apart in so many classes at most.
_CLASSES = 10.0
_PEAK = {"peak", "max", "maximum", "spitze"}
_OTHER: dict[str, Kind] = {"formed thickness": "formed", "height": "mounting"}


def run(job: Job, given: Given) -> int:
    """Close the loop on a press document."""
    beside = [f".model{suffix}" for suffix in SIBLINGS]
    out = job.opened(*MODEL_SUFFIXES, *beside, *WRITTEN, FOAM, SET, ".png", ".csv")
    made = unchanged(PressCase, given.data, given.case.model)
    files = read_measured(
        job, given, partial(read_press, steps=given.how.steps), ("stress", "length", "force", "dimensionless")
    )
    for one in [*files.measured, *files.apart]:
        if one.stroke is not None:
            past_touch(one.name, one.stroke, "stroke")
    kind = files.measured[0].kind
    if any(one.kind != kind for one in files.apart):
        raise UsageError(f"--hold-out takes readings of the first --measured file's kind here: {kind}")
    out.refuse_inputs(job.inputs)
    files.preparation.extend(
        f"{one.name}: shows nothing below {least:.3g} MPa: where it reads 0, less than that may press"
        for one in [*files.measured, *files.apart]
        if (least := one.least) > 0.0
    )
    with job.console.progress("Closing the loop") as advance:
        advance(0.05, "the model")
        told, warnings = closed_press(job, made.case)
        files = _with_heights(told, files)
        for one in files.measured:
            if one.temperature is not None:
                note_temperature(job, made.case.foam, told.model.files.document, one.temperature)
        for one in [*files.measured, *files.apart]:
            said, warned = told_of_places(told, one)
            files.preparation.extend(said)
            warnings.extend(warned)
        check_unchanged(job, made, [*given.case.readings, *given.case.held])
        advance(0.15, "gaps over the stroke")
        problem, others = pose(told, files.measured, given.surely, given.case.fix, files.apart)
    upstream = None
    if given.case.upstream:
        # It closes presses as this module does.
        from hyperfab.chapters.close_loop.upstream_press import tracing

        upstream = tracing(job, made.case, given, out, problem)
    return finish(
        job,
        out,
        problem,
        replace(files, apart=others),
        given=given,
        extend=lambda found: extend(job, out, made.case, told, problem, found),
        warnings=warnings,
        upstream=upstream,
    )


def _with_heights(told: PressResult, files: Files[Reading]) -> Files[Reading]:
    """Return files with every coordinate of their places, which is told where the male gives one."""
    measured, apart = ([with_heights(told, one) for one in part] for part in (files.measured, files.apart))
    axis = told.frame.axis
    said = [
        f"{one.name}: tells no {axis} of its places: each is taken on the male, seen along {axis}"
        for one, made in zip([*files.measured, *files.apart], [*measured, *apart], strict=True)
        if made is not one
    ]
    return replace(files, measured=measured, apart=apart, preparation=[*files.preparation, *said])


def closed_press(job: Job, case: PressCase) -> tuple[PressResult, list[str]]:
    """Return the press of a case, closed, and what its files are warned of."""
    listener = Listener()
    quiet = replace(job, console=listener)
    files = read_files(quiet, case)
    setting = read_setting(quiet, case.foam, files.document)
    model = model_of(quiet, case, files)
    told = solve(quiet, model)
    note_ranges(quiet, model, told.closed)
    if setting is not None and case.dwell is not None:
        column = column_of(quiet, model, told.closed)
        stays = formed(setting, column, case.dwell, told.closed)
        note_set_ranges(quiet, stays, case.dwell, told.closed)
        told = replace(told, formed=stays)
    return told, listener.warnings


def read_press(job: Job, name: str, layout: Layout, left_out: Counter[str], steps: Steps = AS_READ) -> list[Reading]:
    """Read a file of ``x, y, z`` with one of pressure, contact, thickness, formed thickness, height, or of ``stroke,
    force``, or of fabrics alone, ``pressure, thickness``; and its sd column. Of several specimens each is its own.

    The coordinates are those of the drawing (STL). Rows without a reading of their own are counted in ``left_out``.
    """
    optional = dict.fromkeys("xyz", "length") | dict(_COLUMNS) | {"stroke": "length", "force": "force"}
    optional |= {f"{key} sd": kind for key, kind in {**_COLUMNS, "force": "force"}.items()}
    optional |= {"time": "time", "temperature": "temperature"}
    tables = read_tables(job.inputs.read(name), name, {}, along="stroke", optional=optional, layout=layout)
    parts = [part for table in tables for part in _parts(table)]
    unread(job, name, parts[0])
    found = []
    for table in parts:
        kind, load, places = next((one for one in _COLUMNS if one in table), "force"), None, None
        temperature = _temperature(table)
        if "stroke" in table and "force" in table:
            kind, table = "force", pushed(job, table, "stroke", steps)
            table = once(table, (kind, "force sd"), left_out, along="stroke")
        elif any(axis in table for axis in "xyz"):
            table = once(table, (kind, f"{kind} sd"), left_out)
            lacks = np.full(len(table.lines), np.nan)
            places = np.stack([table.columns.get(axis, lacks) for axis in "xyz"], axis=1)
        else:
            kind, table = "thickness", once(table, ("thickness", "thickness sd"), left_out, along="pressure")
            load = table["pressure"]
        values = table[kind]
        if kind == "contact":
            remedy = "write 1 where it touches and 0 where it does not"
            table.refuse((values != 0.0) & (values != 1.0), "is {:g}", column="contact", remedy=remedy)
        told: Kind = "fabric" if load is not None else _OTHER.get(kind, kind)  # type: ignore[arg-type]
        found.append(
            Reading(
                table.name, told, values - np.mean(values) if told == "mounting" else values, places=places, load=load,
                stroke=table["stroke"] if told == "force" else None, time_s=None if told == "fabric" else _time(table),
                temperature=None if told == "fabric" else temperature, sd=spread(table, kind),
            )
        )  # fmt: skip
    return found


def _parts(table: Table) -> list[Table]:
    """Return the specimens of a table; InputError where it is no reading of a press."""
    kinds = [kind for kind in _COLUMNS if kind in table]
    if "stroke" in table and "force" in table:
        return specimens(table, "stroke")
    if "pressure" in table and "thickness" in table and not any(axis in table for axis in "xyz"):
        return [table]
    where = [axis for axis in "xyz" if axis in table]
    if len(kinds) == 1 and len(where) >= (3 if kinds == ["height"] else 2):
        return at_places(table, where)
    unknown = _likely(table) if not kinds or not where else []
    raise InputError(
        "is no reading of a press",
        file=table.name,
        remedy='give "x [mm]", "y [mm]", "z [mm]" (that along the press may lack) with one of "pressure [MPa]", '
        '"contact", "thickness [mm]", "formed thickness [mm]" or "height [mm]", or "stroke [mm]" with "force [N]"'
        + (f"; or say which it is, as in {table.option(unknown)}" if unknown else ""),
    )


def _likely(table: Table) -> list[tuple[str, str]]:
    """Return what columns that were not read are by their units, for a message; else the last a pressure."""
    heads = table.aside
    placed = all(axis in table for axis in "xyz")
    axes = [] if placed else [(one, axis) for one in heads for axis in "xyz" if axis in plain(one.label).split()]
    names = {"stress": "pressure", "length": "thickness"} if placed or axes else {"length": "stroke", "force": "force"}
    found = {axis: one for one, axis in reversed(axes)}
    for one in sorted(heads, key=lambda one: not _PEAK.isdisjoint(plain(one.label).split())):  # a mean before a peak
        name = next((name for kind, name in names.items() if is_of(one.unit or "", kind)), None)
        if name is not None and one not in found.values():
            found.setdefault(name, one)
    bare = [
        (one.title, shown)
        for one, cells in [*zip(heads, table.cells, strict=True)][-1:]
        if one.unit is None and meaning(one) is None and (placed or axes) and (shown := _shown(cells))
    ]
    told = [(one, name) for one in heads for name, other in found.items() if other is one]
    return [(one.title, f"{name} [{one.unit or 'mm'}]") for one, name in told] or bare


def _shown(cells: Sequence[str]) -> str:
    """Return what a film without a unit likely shows: a contact in 0 and 1; nothing for words and for classes."""
    values = set(plain_values(cells))
    if values == {0.0, 1.0}:
        return "contact"
    classes = not values or (len(values) > 1 and all(one.is_integer() and 0.0 <= one <= _CLASSES for one in values))
    return "" if classes else "pressure [MPa]"


def _time(table: Table) -> Array | None:
    """Return when each row was read [s], from a column or, of all of them, the metadata; a date, a time of day or words
    there say nothing of that.
    """
    if "time" in table or not re.fullmatch(r"\d*[.,]?\d+ *[^\W\d]*", table.metadata.get("time", "")):
        return table.columns.get("time")
    return np.full(len(table.lines), stated_in(table, "time", "time"))


def _temperature(table: Table) -> float | None:
    """Return at which temperature [degC] of the molds a file was read, from a column or the metadata."""
    column = table.columns.get("temperature")
    if column is None:
        return stated_in(table, "temperature")
    if np.ptp(column) > 1.0:
        raise InputError(
            f"was read between {column.min():g} and {column.max():g} degC", file=table.name, column="temperature",
            remedy="give a file for each temperature of the molds",
        )  # fmt: skip
    return float(np.mean(column))


def pose(
    told: PressResult,
    files: Sequence[Reading],
    prior: float,
    fix: Sequence[str],
    apart: Sequence[Reading] = (),
) -> tuple[PressProblem, list[Reading]]:
    """Return the problem of a closed press and its readings, and readings ``apart`` placed for it."""
    closed = told.closed
    every = [*files, *apart]
    travel = max((float(np.max(r.stroke)) for r in every if r.stroke is not None), default=0.0)
    whole, summed, correction = press_table(closed, plan_of(told), travel, _stays(told))
    placed = []
    setting = setting_of(told)
    if _foam_of(told).sets and told.formed is None and any(one.kind == "formed" for one in every):
        raise InputError(
            "has a law of what stays, and the press document no dwell",
            file=told.model.case.foam, key="set", remedy="run hf press-contact with --dwell",
        )  # fmt: skip
    for reading in (_in_press(told, setting, one) for one in every):
        at_places = reading.places is not None and reading.kind != "mounting"
        placed.append(on_front(told, reading) if at_places else reading)
    spare = np.linspace(0, len(whole.foam) - 1, 80).astype(np.int64)
    chosen = np.unique(np.concatenate([spare, *(one.corners.ravel() for one in placed if one.corners is not None)]))
    placed = [
        reading if reading.corners is None else replace(reading, corners=np.searchsorted(chosen, reading.corners))
        for reading in placed
    ]
    problem = press_problem(
        (whole.of(chosen), summed, correction),
        setting,
        placed[: len(files)],
        foam=_foam_of(told),
        prior=prior,
        fixed=fix,
    )
    return problem, placed[len(files) :]


def setting_of(told: PressResult) -> Setting:
    """Return how the press of a document was set."""
    closed, case = told.closed, told.closed.case
    compliance = 0.0 if case.frame is None or case.force is not None else 1.0 / case.frame
    start = closed.pose.opening - compliance * closed.contact.closing_force
    rate = (0.0, 0.0)
    if case.zero_hot:
        at = float(closed.datum.at[2])
        rate = (at - case.male.mount, case.female.mount - at)
    fabrics, warm = told.model.files.fabrics, tuple(grown.temperature for grown in told.model.grown)
    mean = 0.5 * (warm[0] + warm[1])
    return Setting(
        opening=start,
        force=case.force,
        compliance=compliance,
        zero_rate=rate,
        floating=case.floating,
        thickness=told.model.foam.thickness,
        fabric=(fabrics.below, fabrics.above),
        tilt=case.tilt,
        half_mm=0.5 * float(np.ptp(case.male.vertices[:, :2], axis=0).max()),
        temperature=mean,
        cold=_warmth(told, mean, told.reference) if abs(mean - told.reference) > 1.0 else None,
    )


def _warmth(told: PressResult, mean: float, temperature: float) -> Warmth:
    """Return the press at another mean temperature [degC] of its molds than the model's, both changed alike."""
    male, female = (
        float(expansion.strain(grown.temperature + temperature - mean) - expansion.strain(grown.temperature))
        for expansion, grown in zip(told.model.files.expansions, told.model.grown, strict=True)
    )
    case, document = told.model.case, told.model.files.document
    hot = mean - told.reference
    share = (temperature - told.reference) / hot if abs(hot) >= 1.0 else 1.0
    if _foam_of(told).law_degC is not None:
        return Warmth(temperature, (male, female), share=share)
    quiet = Job(case.COMMAND, [], Listener())
    laws, _ = compression_law(quiet, case.foam, document, temperature, case.dwell)
    return Warmth(temperature, (male, female), laws.at(temperature), share)


def _in_press(told: PressResult, setting: Setting, reading: Reading) -> Reading:
    """Return a reading with what the molds have grown at its temperature, and what may press where its film shows
    nothing; thickness after opening is ``formed``."""
    least = reading.least
    if least > 0.0:
        reading = replace(reading, below=np.where(reading.values == 0.0, least, 0.0))
    if reading.kind == "thickness" and told.model.foam.recovery is not None and told.model.foam.recovery < 1.0:
        reading = replace(reading, kind="formed")
    if reading.kind == "mounting" and reading.places is not None:
        return replace(reading, places=told.frame.inward(reading.places))
    if reading.temperature is None or reading.temperature == setting.temperature:
        return reading
    return replace(reading, warmth=_warmth(told, setting.temperature, reading.temperature))


def _stays(told: PressResult) -> Array | float:
    """Return the share of the foam's strain that stays as the model has it, at the front; 0 where it says nothing."""
    if told.formed is not None:
        return told.formed.share
    given, back = told.model.files.document.set, told.model.foam.recovery
    return float(given) if isinstance(given, float) else 0.0 if back is None else 1.0 - back


def _foam_of(told: PressResult) -> FoamContext:
    """Return what the model has of the sandwich."""
    document, fabrics = told.model.files.document, told.model.files.fabrics
    law = document.laws[0]
    several = len(document.laws) > 1 or isinstance(law, MaterialLaw)
    return FoamContext(
        fabric_mm=fabrics.thickness,
        across=fabrics.law is not None,
        sets=document.set is not None and not isinstance(document.set, float),
        even=told.model.case.dwell is None
        and all(grown.celsius is None for grown in told.model.grown)
        and abs(told.model.grown[0].temperature - told.model.grown[1].temperature) < 1e-9,
        shrinks=told.model.foam.lost > 0.0,
        law_degC=None if several else told.reference if law.temperature is None else law.temperature,
    )


def plan_of(told: PressResult) -> Array:
    """Return the coordinates (n, 2) of thickness variation at the vertices of the front."""
    drawn = told.frame.outward(told.closed.case.male.vertices)
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    half = np.where(high > low, 0.5 * (high - low), 1.0)
    scaled = (told.frame.outward(told.closed.cold) - 0.5 * (low + high)) / half
    return np.asarray(scaled[:, [i for i, axis in enumerate("xyz") if axis != told.frame.axis]])
