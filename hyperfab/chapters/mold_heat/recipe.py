"""``hf mold-heat``: mesh the mold, follow its temperatures, say how long, how even, and where the heat went."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array
from hyperfab.cases.mold import MoldCase
from hyperfab.chapters.job import Job
from hyperfab.chapters.mold_heat import nearby
from hyperfab.chapters.mold_heat.files import load_writers, write_fields
from hyperfab.chapters.mold_heat.pace import Pace
from hyperfab.chapters.mold_heat.problem import MoldBuilder, Problem
from hyperfab.chapters.mold_heat.result import IMBALANCE_ALLOWED, steady_document, transient_document, unresolved
from hyperfab.chapters.mold_heat.tables import Tables
from hyperfab.chapters.mold_heat.variations import SHARPER, read_variations, variations_csv, vary
from hyperfab.chapters.uncertainty.carry import Sure, carry
from hyperfab.chapters.uncertainty.sources import Origins, of_films, origins
from hyperfab.console import Advance
from hyperfab.documents.heat import Design, HeatDocument, RunPart
from hyperfab.documents.mold import EarlierField, MoldDocument
from hyperfab.documents.uncertainty import figures_of
from hyperfab.errors import InputError, NotConverged, placed
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.design import scale_for_warmup, scaled, share_power
from hyperfab.thermal.history import History, Ledger, Target
from hyperfab.thermal.model import without_route
from hyperfab.thermal.shortcut import View, is_long, shortcut_for
from hyperfab.thermal.step import initial_state
from hyperfab.thermal.trail import Past, Trail
from hyperfab.thermal.transient import Schedule
from hyperfab.thermal.transient import run as follow

#: Share of the progress line when the temperatures are found.
FOLLOWED = 0.95
#: So much hotter [K] than the target no work surface is meant to end.
_FAR_ABOVE = 50.0
#: A mold whose temperatures differ by no more [K], anywhere and at any time, was not heated.
_STILL = 1e-6


def run(job: Job, case: MoldCase, document: MoldDocument) -> int:
    """Heat the mold of the case, whose ``document`` was read; 0, or 4 where the account of heat does not close."""
    mold = case.mold
    out = job.opened(".vtu", ".[0-9]*.vtu", ".csv", ".history.csv", ".variations.csv", ".pieces.csv", ".png", ".pvd")
    with placed(mold):
        check(case, document)
    asked = None if case.variations is None else read_variations(job.inputs, case.variations, document, mold)
    builder = MoldBuilder(document, mold, job.inputs, case.stl_unit)
    out.refuse_inputs(job.inputs)
    job.console.warn(*builder.doubts)
    # A mesher does not say how far it is.
    with job.console.progress("Meshing the mold", paced=False) as advance:

        def waiting(seconds: float) -> None:
            advance(seconds / (seconds + 5.0))
            if out.wants_files:  # the mesher is at work in a process of its own
                load_writers()

        known = len(builder.doubts)
        problem = builder.build(waiting, job.console.note)
    job.console.warn(*builder.doubts[known:])
    start = builder.start_field(problem)
    size = f"{problem.model.size} unknowns in {len(problem.mesh.elements)} elements"
    if document.run.steady:  # one system of equations: it has no pace to tell beforehand
        job.console.note(f"steady state of {size}")
    with job.console.progress("Heating the mold", size) as advance:

        def warmup() -> float | None:
            return heated(document, problem, start, advance).reached_time

        with placed(mold):
            chosen = design(case, document, problem, start, warmup)
            steady = _steady(problem, start) if document.run.steady else None
        if steady is not None:
            history = steady
            result = steady_document(problem, history)
        else:
            history = heated(document, problem, start, advance)
            result = transient_document(document, problem, history)
        if asked is not None:
            advance(FOLLOWED, "variations")
            sharper = heated(document, problem, start, advance, SHARPER)
            result.variations = vary(asked, document, problem, sharper, start)
            out.add(".variations.csv", variations_csv(result.variations))
        advance(0.97, "writing")
    for text in problem.notes:
        job.console.note(f"{mold}: {text}")

    coldest, hottest = min(builder.around[0], float(start.min())), max(builder.around[1], float(start.max()))

    @cache
    def reached(outside: bool) -> Array:
        # A little colder than anything it began at or stands in is, beside a heater that was just switched on, what
        # elements make of a step and no wall: heaters only add.
        outer = problem.mesh.facet_nodes(problem.mesh.facets.outer)
        nodes = np.unique(outer) if outside else np.arange(problem.mesh.solid)
        return np.maximum(history.states.extremes(nodes), coldest)

    note_ranges(job, mold, builder.tables, reached, history.states.times)
    result.design = chosen
    result.notes = builder.doubts + problem.notes
    asked_run = document.run
    result.setup = RunPart(
        start_degC=None if isinstance(asked_run.start, EarlierField) else asked_run.start,
        target_degC=asked_run.target,
        until_s=asked_run.until,
        mesh_size_mm=asked_run.mesh_size,
        steady=asked_run.steady,
        tolerance_K=asked_run.tolerance,
    )
    least, greatest = history.states.extremes(np.arange(problem.mesh.solid))
    if not asked_run.steady:
        told = unresolved(document, problem, history, coldest, np.inf if document.heater else hottest)
        job.console.warn(*told)
        result.notes += told
    _say(job, result, document.run.target, still=greatest - least < _STILL)
    sure = Sure()
    if result.converged:
        value = dict(figures_of(result.to_json(), result.KIND))
        sure = carry(
            job,
            case,
            result,
            lambda: _origins(job, case, builder),
            lambda known: nearby.beside(case, document, problem, history, value, known),
        )
    if out.wants_files:
        write_fields(out, problem, history, document.run.target, sure)
    job.write(out, result, case)
    return 0 if result.converged else NotConverged.exit_status


def _origins(job: Job, case: MoldCase, builder: MoldBuilder) -> Origins:
    """Return what the document and its tables say of how sure they are."""
    found = origins(job.inputs, case, documents={case.mold: MoldDocument})
    found.found += of_films(builder.tables.unsure)
    return found


def note_ranges(job: Job, name: str, tables: Tables, reached: Callable[[bool], ArrayLike], times: ArrayLike) -> None:
    """Note where the tables were used: films at the temperatures ``reached`` outside (True) [degC], what materials have
    at those anywhere (False), the rest at ``times`` [s].

    Where no table states a temperature, all are constants: the mold's temperatures are told, and that nothing says
    where those hold.
    """
    then = "its end rows hold there"
    for (kind, table), known in tables.tabulated.items():
        met = reached(kind == "film-coefficient")
        job.ranges.used(table, met, known=known, source=name, unit="degC", then=then)
    if not tables.tabulated:
        job.ranges.used("temperature_degC", reached(False), known=None, source=name)
    for table, known in tables.timed.items():
        job.ranges.used(table, times, known=known, source=name, unit="s", then=then)


def heated(document: MoldDocument, problem: Problem, start: Array, advance: Advance, share: float = 1.0) -> History:
    """Follow the mold; each step may err by ``share`` of the document's tolerance."""
    settings = document.run
    target = None
    if settings.target is not None and problem.work_surface is not None:
        surface = problem.work_surface
        target = Target(surface.mean_weights, settings.target)

    schedule = Schedule(settings.until, problem.corners, share * settings.tolerance)
    shortcut, why = None, "parts come fresh" if problem.renewals and settings.until is not None else None
    if share == 1.0 and not problem.renewals:
        nodes = np.zeros(0, dtype=np.int64)
        if problem.work_surface is not None:
            nodes = problem.work_surface.all_nodes
        full = View(problem.model, problem.thermostats, target)
        shortcut, why = shortcut_for(full, settings.until, list(problem.probes.values()), nodes, settings.reduced)
    pace = Pace(problem, start, shortcut is not None)
    reached = [(0.0, 0.0 if target is None else dot(target.sensor, start))]

    some = np.arange(0, len(start), max(len(start) // 2000, 1))  # to show where it is, enough

    def progress(now: Past) -> None:
        time, until = now.time, settings.until
        if problem.pieces is not None:
            until = problem.pieces.section.period * problem.pieces.count
        elif until is None:
            assert target is not None
            reached.append((time, now.reading(target.sensor)[0]))
            (before, cold), (_, warm) = reached[-2:]
            until = time + max(target.value - warm, 0.0) * (time - before) / max(warm - cold, 1e-9)
        advance(FOLLOWED * pace.done(time, until), f"{time:.0f} s, {now.on(some).max():.1f} degC")

    history = follow(
        problem.model,
        start,
        schedule,
        target=target,
        thermostats=problem.thermostats,
        renewals=problem.renewals,
        finished=(lambda history: False) if problem.pieces is None else problem.pieces.finished,
        shortcut=shortcut,
        advance=progress,
    )
    if why is not None and settings.reduced is not False and is_long(problem.model, history):
        problem.notes.append(f"a long run, followed in full: {why}")
    return history


def _steady(problem: Problem, start: Array) -> History:
    model = problem.model
    lost = without_route(model)
    if lost is not None:
        x, y, z = 1e3 * problem.mesh.points[lost]
        raise InputError(
            f"there is no steady state: the part around ({x:.0f}, {y:.0f}, {z:.0f}) mm has no route for the heat out",
            key="run.steady",
            remedy="add convection, radiation or a held temperature to it",
        )
    after = max(problem.corners, default=0.0)  # schedules and tables in time keep their last values
    state = initial_state(model, 0.0, start)
    temperature, _ = model.solve_steady(after, model.hold(after, start))
    for thermostat in problem.thermostats:
        if thermostat.excess(temperature) >= 0.0:
            raise InputError(
                f"there is no steady state: {thermostat.heater.name}, always on, would bring its thermostat's probe to "
                f"{dot(thermostat.sensor, temperature):.6g} degC, and it switches off at {thermostat.threshold:g}",
                key="run.steady",
                remedy='take the control out, or give until = "3600 s" in place of steady',
            )
    history = History(Trail([state]), Ledger.begin(model, model.total(state.stored)))
    history.states.append(initial_state(model, after, temperature))
    return history


def _say(job: Job, result: HeatDocument, target: float | None, still: bool) -> None:
    """Tell a person what came out; the ``target`` [degC] is the document's, ``still`` a mold that stays as it was."""
    console = job.console
    work = result.work_surface
    if still:
        console.warn(
            "nothing heats or cools the mold, it stays at the temperature it began at: give a [[heater]], "
            "or another start"
        )
    if result.warmup_time_s == 0.0:
        console.warn(
            f"the work surface begins at the target of {target:g} degC or above it: the warm-up is 0 s; for the time "
            "it takes to cool, give until in place of the target and read NAME.history.csv"
        )
    if work is not None and target is not None and work.mean_degC > target + _FAR_ABOVE:
        console.warn(
            f"the work surface ends at {work.mean_degC:.0f} degC, {work.mean_degC - target:.0f} K above the target: "
            "heaters without control or schedule stay on to the end; give one, or a shorter until"
        )
    if not result.converged:
        console.warn(
            f"the account of heat is off by {result.energy.imbalance_relative:.2g}, above {IMBALANCE_ALLOWED:g}"
        )
    elif result.status:
        console.warn(result.status)
    if result.warmup_time_s is not None:
        console.note(f"warm-up {result.warmup_time_s / 60:.1f} min, {result.steps} steps, {result.unknowns} unknowns")
    if result.reduced is not None:
        told = result.reduced
        console.note(
            f"{told.stretches} stretches from {told.begun_s:.0f} s on {told.unknowns} instead of {result.unknowns} "
            f"unknowns, within {told.error_bound_K:.2g} K"
        )
    if result.design is not None:
        chosen = ", ".join(f"{name} {power:.1f} W" for name, power in result.design.power_W.items())
        console.note(f"powers chosen: {chosen}")
    if result.design is not None and result.design.steady_spread_K is not None:
        before, after = result.design.steady_spread_before_K, result.design.steady_spread_K
        console.note(f"steady spread of the work surface: {before:.3g} K before, {after:.3g} K with them")
    if result.production is not None:
        made = result.production
        console.note(
            f"piece {made.pieces}: the work surface dips by {made.last.dip_K:.2f} K from "
            f"{made.last.surface_degC:.2f} degC, the piece takes {made.last.heat_from_mold_J:.1f} J, "
            f"{made.power_to_hold_W:.1f} W would hold the mold"
        )
    if result.variations is not None:
        varied = result.variations
        console.note(
            f"{len(varied.runs)} variations on {varied.unknowns} unknowns, within "
            f"{varied.difference_max_K:.2g} K of the full run"
        )
    rows = [
        (
            name,
            f"{use.area_mm2 / 1e2:.1f}" if use.area_mm2 else "",
            f"{use.power_W:.1f}" if use.power_W is not None else "",
            f"{result.energy.by_condition_J[name] / 1e3:.2f}" if name in result.energy.by_condition_J else "",
        )
        for name, use in result.conditions.items()
    ]
    if rows:
        console.table("Where the heat goes", ("condition", "area cm^2", "power W at the end", "heat in kJ"), rows)


def check(case: MoldCase, document: MoldDocument) -> None:
    """Refuse aids that this mold cannot have."""
    if document.production is not None and (case.share_power or case.warmup_in is not None):
        raise InputError(
            "the powers are chosen for the warm-up, before the first piece",
            key="production",
            remedy='choose them without it, then start = { document = "heat.json" } here',
        )
    if not document.heater and (case.share_power or case.warmup_in is not None):
        raise InputError("has no heater whose power could be chosen", key="heater")
    if case.warmup_in is not None and (document.run.target is None or document.run.steady):
        raise InputError(
            "--warmup-in needs the temperature to reach",
            key="run.target",
            remedy='add target = "200 degC" to [run], without steady',
        )
    if case.share_power and document.work_surface is None:
        raise InputError("--share-power needs the surface to make even", key="work_surface", remedy="add it")
    if case.share_power and any(h.schedule is not None or h.control is not None for h in document.heater):
        raise InputError(
            "--share-power is for heaters of constant power", key="heater", remedy="take schedule and control out"
        )


def design(
    case: MoldCase,
    document: MoldDocument,
    problem: Problem,
    start: Array,
    warmup: Callable[[], float | None],
) -> Design | None:
    """Set the heaters as asked; return what was chosen. ``warmup`` runs the mold as it is set."""
    if not case.share_power and case.warmup_in is None:
        return None
    heaters = problem.model.heaters
    result = Design()
    if case.share_power:
        assert problem.work_surface is not None
        if without_route(problem.model) is not None:
            raise InputError(
                "--share-power works on the steady state, and a part has no route for the heat out",
                key="convection",
                remedy="add convection, radiation or a held temperature",
            )
        mean = None if case.warmup_in is not None else document.run.target
        shared = share_power(problem.model, problem.work_surface, start, most=case.heater_max, mean=mean)
        result.steady_spread_before_K = shared.spread_before
        result.steady_spread_K = shared.spread
        result.steady_mean_degC = shared.mean
    if case.warmup_in is not None:
        powers = [heater.power for heater in heaters]

        def scale(factor: float) -> None:
            for heater, power in zip(heaters, powers, strict=True):
                heater.power = power
                heater.power = scaled(heater, factor)

        def time(factor: float) -> float | None:
            scale(factor)
            return warmup()

        _refuse_hot(document, problem, start)
        result.warmup_wanted_s = case.warmup_in
        result.power_factor, result.runs = scale_for_warmup(case.warmup_in, time)
        scale(result.power_factor)
    result.power_W = {heater.name: float(heater.power.y.max()) for heater in heaters}
    most = max(result.power_W, key=lambda name: result.power_W[name])
    if case.heater_max is not None and result.power_W[most] > case.heater_max * (1.0 + 1e-6):
        raise NotConverged(
            f"the target in {case.warmup_in:g} s takes {result.power_W[most]:.6g} W of {most}, more than the "
            f"{case.heater_max:g} W of --heater-max",
            remedy="allow more power a heater, or a longer --warmup-in",
        )
    return result


def _refuse_hot(document: MoldDocument, problem: Problem, start: Array) -> None:
    """Refuse to choose powers for a warm-up that is over as it begins."""
    target, surface = document.run.target, problem.work_surface
    assert target is not None  # ``check`` saw to it,
    assert surface is not None  # the document to this
    begins = dot(surface.mean_weights, problem.model.hold(0.0, start))
    if begins >= target:
        raise InputError(
            f"--warmup-in: the work surface begins at {begins:.6g} degC, and the target is {target:g} degC",
            key="run.start",
            remedy="begin below the target, or leave --warmup-in out",
        )
