"""The loop on a heated mold: a mold document against thermocouples."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import TypeGuard

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.chapters.close_loop.describe import describe, say
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.chapters.close_loop.extended_mold import TABLES, extend
from hyperfab.chapters.close_loop.finalise import picture, ticking, write
from hyperfab.chapters.close_loop.heaters import Drawn, as_power, heated_by, own_power, ratings, read_powers, ruled
from hyperfab.chapters.close_loop.readings import Thermocouples, check_fixed, read_thermocouples, stated_size
from hyperfab.chapters.close_loop.sure import caution, noted
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat.problem import MoldBuilder, Problem
from hyperfab.chapters.mold_heat.recipe import heated, note_ranges
from hyperfab.chapters.mold_heat.tables import EXPOSED
from hyperfab.chapters.rerun import Overlay
from hyperfab.documents.base import parse_document
from hyperfab.documents.mold import ContactSection, ConvectionSection, FacesInBox, MoldDocument
from hyperfab.errors import HyperfabError, InputError, UsageError, placed
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output
from hyperfab.io.toml_io import load_toml
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.heat import HeatProblem, bounds_of, heat_problem
from hyperfab.loop.probes import Log
from hyperfab.loop.switching import is_coarse, of_switches
from hyperfab.thermal.condition import Contact, Convection, Heater, Radiation
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.geometry import Box
from hyperfab.thermal.history import curve, curve_times
from hyperfab.thermal.reduced import HOLDS, reduce
from hyperfab.thermal.sensors import as_shown

#: Conductance that counts as a perfect joint [W/m^2/K].
PERFECT = 1e7
#: Zones of a part, a power of two: what changes with temperature goes by the mean of each.
_ZONES = 16
#: Share of the noise from which on it is told what the written mold reads beside what the loop predicts.
_BESIDE = 0.1


def run(job: Job, given: Given) -> int:
    """Close the loop on a mold document."""
    out = job.opened(".model.toml", *TABLES, ".png", ".csv")
    document = parse_document(given.data, given.case.model, MoldDocument)
    if given.case.held:
        raise UsageError("--hold-out takes only auto for a mold: each probe is predicted from the others")
    if len(given.case.readings) != 1:
        raise UsageError("--measured takes one file of thermocouples for a mold: one run, a column a probe")
    with placed(given.case.model):
        if document.run.steady:
            raise InputError("a steady run has no times to compare at", key="run.steady", remedy="give until instead")
        if document.production is not None:
            raise InputError(
                "close-loop does not follow pieces laid in and taken out",
                key="production",
                remedy="measure the mold without pieces, and take the table out",
            )
    probes = [probe.name for probe in document.probe]
    rated = ratings(document)
    read = read_thermocouples(job, given.case.readings[0], probes, given.layout, rated)
    drawn = read_powers(document, read.powers)
    unread = set(ruled(document)).difference(*(one.heaters for one in drawn))
    offered = as_power(read.unread, rated, given.layout)
    if unread:
        raise InputError(
            "close-loop does not follow a thermostat: its switching and the model's drift out of step",
            file=given.case.model,
            key=f"heater.{min(unread)}.control",
            remedy="add what the heaters drew to the thermocouples, as a column power [W] (several that --columns "
            f"calls so are added up) or of each as {own_power(min(unread))} [W], or give it as "
            'schedule = "power.csv" in place of control' + offered,
        )
    if offered and not drawn:
        job.console.note(f"{given.case.readings[0]}: the heaters are taken to draw what the mold says{offered}")
    if any(is_coarse(one.power) for one in drawn):
        job.console.warn(
            "the heaters switch about as fast as their power was read, so that some of it was between two readings: "
            "read it several times as often"
        )
    level = stated_size(given.case.noise, "temperature-difference")
    builder = MoldBuilder(document, given.case.model, job.inputs)
    out.refuse_inputs(job.inputs)
    job.console.warn(*builder.doubts)
    put = [own_power(number) for one in drawn for number in one.heaters if document.heater[number].control is None]
    if put:
        job.console.note(f"{given.case.readings[0]}: tells {', '.join(sorted(put))}, in place of what the mold says")
    with job.console.progress("Closing the loop") as advance:
        advance(0.0, "meshing")
        problem = pose(builder, read, given.case.fix, given.surely, drawn)
        log = Log(problem)
        found = close(problem, noise=level, tick=ticking(advance, 0.2), put_right=log.explains)
        found, odd = log.looked_through(found)
    job.console.warn(*odd)
    result = describe(problem, found, read.left_out, odd, domain="heat")
    fit = found.after.fit
    outside, anywhere = problem.temperatures(fit.x[: fit.own], fit.terms)
    reached = {True: outside, False: anywhere}
    note_ranges(job, given.case.model, builder.tables, reached.__getitem__, problem.runs[0].clock[0])
    say(job.console, problem, found, result)
    if out.wants_files:
        target = out.path(".model.toml")
        folders = (os.path.dirname(given.case.model), str(target.parent))
        noise = float(np.min(found.noise.sd))
        files, notes = extend(given.data, document, problem, found.after.fit, out.path("").name, folders, noise)
        notes = [*notes, *written_otherwise(files, out, builder, problem, found)]
        files[".model.toml"] = noted(caution(found), files[".model.toml"])
        job.console.warn(*notes)
        result.warnings += notes
        for suffix, content in files.items():
            out.add(suffix, content)
        result.model = out.path(".model.toml").name
        _files(out, problem, found, read)
    return write(job, out, given, found, result)


def pose(
    given: MoldBuilder, read: Thermocouples, fix: Sequence[str], prior: float, drawn: Sequence[Drawn] = ()
) -> HeatProblem:
    """Return the problem of a mold and its thermocouples, heated by what was ``drawn`` where that was read."""
    builder = _with_held_faces(given)
    document, built = builder.document, builder.build()
    given.take_mesh(builder)
    pairs = _touching(document, built)
    if pairs:
        more = [ContactSection(between=pair, h=f"{PERFECT:g} W/m^2/K") for pair in pairs]
        document = document.model_copy(update={"contact": [*document.contact, *more]})
        builder = given.of(document)
        builder.take_mesh(given)
        built = builder.build()
    model = built.model
    contacts = [c for c in model.conditions if isinstance(c, Contact)]
    opened = contacts[len(contacts) - len(pairs) :]
    declared = contacts[: len(contacts) - len(pairs)]
    start = builder.start_field(built)
    probes = np.stack([built.probes[key] for key in read.names])
    began = _probed(built, read.names)[1:]
    free = _bench_facets(built)
    bench = FacetOperator(built.mesh.points, built.mesh.facet_nodes(free)) if np.any(free) else None
    # Where the fit may go, the basis follows: that of one conductivity misses half of it by as much as noise.
    mold = reduce(
        model, probes, start, float(read.times[-1]) - min(0.0, float(read.times[0])), bench, opened,
        _corners(built), [[part] for part in began], [c for c in model.conditions if _holds(c)],
        conducting=(1.0, bounds_of("conductivity", prior)[0]), zones=_ZONES,
    )  # fmt: skip
    for one in drawn:
        mold = heated_by(mold, one, read.times, one.power)
    own = _own(document, built, [document.part[part].name for part in began])
    check_fixed(fix, [key for key, _ in own], "mold")
    problem = heat_problem(
        mold,
        read.times,
        read.readings,
        read.names,
        own,
        [joint.conductance for joint in declared],
        prior,
        fix,
    )
    problem.pairs = pairs
    problem.base = _base(document, built)
    problem.tables = {
        f"{m.name}.{what}": getattr(m, what)
        for m in built.model.materials
        for what in ("conductivity", "specific_heat")
    }
    problem.lag_s = np.array([built.lags[key] for key in read.names]).T
    problem.read = tuple(number for one in drawn for number in one.heaters)
    known = [of_switches(problem, read.times, one.power, partial(heated_by, mold, one)) for one in drawn]
    problem.common = np.hstack([one for one in known if one.size] or [problem.common])
    return problem


def _with_held_faces(builder: MoldBuilder) -> MoldBuilder:
    """Return the builder of the mold with its held temperatures as films that leave the face no choice."""
    document = builder.document
    if not document.temperature:
        return builder
    films = [
        ConvectionSection.model_construct(on=held.on, h=HOLDS, ambient=held.value) for held in document.temperature
    ]
    other = builder.of(document.model_copy(update={"temperature": [], "convection": [*document.convection, *films]}))
    other.tables = builder.tables  # one account of what was read, whatever it is built of
    return other


def _base(document: MoldDocument, built: Problem) -> list[str | tuple[int, int]]:
    """Return the places the mold stands on: of ``[[insulated]]``, by table and place, or names of faces.

    Faces have several names, of a part, its shapes or a box: what the document says is insulated is called as it is
    there. The rest are ``part.z-`` of the parts that reach down to them, or the way they look.
    """
    bench, outer = _bench_facets(built), built.mesh.facets.outer
    found, left = list[str | tuple[int, int]](), bench.copy()
    for number, section in enumerate(document.insulated):
        for place, on in enumerate(section.on):
            if on == EXPOSED:
                continue
            if isinstance(on, FacesInBox):
                own = built.faces.inside(on.part, Box(on.box.origin, on.box.size))
            else:
                own = built.faces.named(on)
            if np.any(own.mask & bench):
                found.append((number, place))
                left &= ~own.mask
    for name in (f"{part.name}.{way}" for way in ("z-", "x-", "x+", "y-", "y+", "z+") for part in document.part):
        if not np.any(left):
            break
        try:
            mask = built.faces.named(name).mask & outer
        except InputError:  # no face of the part looks that way
            continue
        if np.any(mask & left):
            found.append(name)
            left &= ~mask
    return found


def _holds(condition: object) -> TypeGuard[Convection]:
    return isinstance(condition, Convection) and bool(np.all(condition.film.y == HOLDS))


def _touching(document: MoldDocument, built: Problem) -> list[tuple[str, str]]:
    """Return pairs of parts that touch and conduct perfectly in the document."""
    names = [part.name for part in document.part]
    declared = {frozenset(contact.between) for contact in document.contact}
    found = []
    for one, other in combinations(names, 2):
        if frozenset((one, other)) in declared:
            continue
        try:
            built.faces.interface(one, other)
        except InputError:
            continue
        found.append((one, other))
    return found


def _probed(built: Problem, names: Sequence[str]) -> list[int]:
    """Return the parts that a probe reads, in order: each is known to begin where its probe begins."""
    mesh, found = built.mesh, set()
    for name in names:
        nodes = np.flatnonzero(np.abs(built.probes[name]) > 1e-9)
        inside = np.isin(mesh.elements, nodes).sum(axis=1)
        found.add(int(mesh.parts[int(np.argmax(inside))]))
    return sorted(found)


def _own(document: MoldDocument, built: Problem, began: Sequence[str] = ()) -> list[tuple[str, str]]:
    """Return the mold's own constants, by key and kind, in the order of the reduced mold's matrices."""
    films = [c for c in document.convection if c.h != HOLDS]
    own = [(f"convection.{i}.h", "film") for i in range(len(films))]
    used = list(dict.fromkeys(material.name for material in built.model.materials))
    own += [(f"material.{key}.conductivity", "conductivity") for key in used]
    own += [(f"material.{key}.specific_heat", "capacity") for key in used]
    own += [(f"heater.{i}.power", "power") for i in range(len(document.heater))]
    declared = [contact for contact in document.contact if contact.h < 0.99 * PERFECT]
    own += [(f"contact.{i}.h", "joint") for i in range(len(declared))]
    starts = ["run.start", *(f"part.{name}.start" for name in began)]
    return [*own, *((name, "start") for name in starts), ("ambient", "ambient")]


def _corners(built: Problem) -> list[float]:
    """Return the times at which a heater's power or a joint's schedule really turns."""
    found: set[float] = set()
    for condition in built.model.conditions:
        table = condition.power if isinstance(condition, Heater) else getattr(condition, "closed", None)
        if table is None or len(table.x) < 2:
            continue
        slope = np.diff(table.y) / np.diff(table.x)
        around = np.concatenate([[0.0], slope, [0.0]])
        turns = np.abs(np.diff(around)) > 1e-9 * max(float(np.max(np.abs(slope))), 1e-300)
        found |= {float(t) for t in table.x[turns]}
    return sorted(found)


def _bench_facets(built: Problem) -> Flags:
    """Return the facets a mold stands on, or else all outer ones without film, radiation or cavity."""
    mesh = built.mesh
    outer = mesh.facets.outer & ~built.faces.cavity
    cooled: set[tuple[int, ...]] = set()
    for condition in built.model.conditions:
        if isinstance(condition, (Convection, Radiation)):
            cooled |= {tuple(sorted(row[:3])) for row in condition.facets.nodes.tolist()}
    nodes = mesh.facet_nodes(outer)
    free = np.array([tuple(sorted(row[:3])) not in cooled for row in nodes.tolist()], dtype=bool)
    # What a mold stands on is below it; only where nothing is free there do other insulated faces count.
    height = mesh.points[nodes][:, :, 2]
    below = free & np.all(height < float(mesh.points[:, 2].min()) + 1e-6, axis=1)
    found = np.zeros(len(outer), dtype=bool)
    found[np.flatnonzero(outer)[below if np.any(below) else free]] = True
    return found


def _files(out: Output, problem: HeatProblem, found: Finding, read: Thermocouples) -> None:
    before, after = found.before.fit.predicted, found.after.fit.predicted
    rows, count = len(read.times), len(read.names)
    head = ["time_s"] + [f"{n}_{w}_degC" for n in read.names for w in ("measured", "before", "after")]
    told = np.full((3, count * rows), np.nan)
    told[:, problem.runs[0].kept] = problem.measured, before, after
    columns = told.reshape(3, count, rows).transpose(2, 1, 0).reshape(rows, 3 * count)
    out.add(".csv", csv_bytes(head, list(np.column_stack([read.times, columns])), digits=8))
    out.add(".png", picture(problem, found, "time_s", "degC", {"probe": read.names}))


def written_otherwise(
    files: Mapping[str, bytes], out: Output, given: MoldBuilder, problem: HeatProblem, found: Finding
) -> Iterator[str]:
    """Yield by how much the written mold differs from what is predicted, where that is not small beside the noise.

    ``files`` are those that will be written, by suffix; ``given`` has built the mold that was given. It takes a run of
    the whole mold, and is asked where an effect was added and materials change with temperature: all else the reduced
    mold answers for to a share of that. A thermostat that was seen to switch is not followed.
    """
    changing = "property-drift" in found.after.ids or problem.runs[0].mold.changes.shape[2] > 1
    if not found.after.ids or not changing or ruled(given.document):
        return
    path = str(out.path(".model.toml"))
    times, kept = problem.runs[0].times, problem.runs[0].kept
    try:
        document = parse_document(load_toml(files[".model.toml"], path), path, MoldDocument)
        builder = MoldBuilder(document, path, Overlay({str(out.path(suffix)): data for suffix, data in files.items()}))
        builder.take_mesh(given)
        read = _shown(builder, problem, times).ravel()[kept]
    except HyperfabError as error:
        yield f"hf mold-heat does not run with what was found: {error}"
        return
    known = np.isfinite(read)
    off = (read - found.after.fit.predicted)[known]
    if not len(off):
        return
    size, noise = float(np.sqrt(np.mean(off**2))), float(np.sqrt(np.mean(found.noise.sd[known] ** 2)))
    if size > _BESIDE * noise:
        yield (
            f"the mold as it is written reads {size:.2g} K (rms, {np.max(np.abs(off)):.2g} K at most) beside what is "
            f"predicted here, {100.0 * size / noise:.2g} % of the noise: hf mold-heat computes it on all of its mesh"
        )


def _shown(builder: MoldBuilder, problem: HeatProblem, times: Array) -> Array:
    """Return what the probes of a mold show at ``times`` (t,) [s], (probes, t) [degC]; nan before it begins."""
    document = builder.document
    built = builder.build()
    until = document.run.model_copy(update={"until": float(times[-1]), "target": None})
    whole = document.model_copy(update={"run": until})
    history = heated(whole, built, builder.start_field(built), lambda fraction, text="": None)
    at = curve_times(history)
    shown = [as_shown(at, curve(history, built.probes[name], at), built.lags[name]) for name in problem.names]
    return np.array([np.where(times < at[0], np.nan, np.interp(times, at, row)) for row in shown])
