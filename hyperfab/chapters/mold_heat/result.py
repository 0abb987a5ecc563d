"""The figures of a heated mold, gathered into its document."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.chapters.mold_heat.production import describe
from hyperfab.documents.heat import (
    Energy,
    Evenness,
    Extreme,
    FaceUse,
    HeatDocument,
    ProbeResult,
    ReducedRun,
    WorkSurface,
)
from hyperfab.documents.mold import MoldDocument
from hyperfab.numerics.vectors import dot
from hyperfab.thermal import facet_operator
from hyperfab.thermal.condition import Heater
from hyperfab.thermal.history import LEAST_CHANGE, History, curve, curve_times
from hyperfab.thermal.sensors import as_shown
from hyperfab.thermal.trail import Past

#: The account of heat must close to this share, or the command ends with exit status 4.
IMBALANCE_ALLOWED = 1e-8
#: Temperatures beyond all that is around, by this share of what the mold goes through, are the elements' own: there
#: those of a board of 60 mm, held, heated or in a film for 15 to 960 s, were off by 1 % of it and more, else by less.
BEYOND_ALL = 0.01


def transient_document(document: MoldDocument, problem: Problem, history: History) -> HeatDocument:
    """Return the document of a warm-up."""
    energy = energy_of(history)
    imbalance, reached = energy.imbalance_relative, history.reached
    result = _common(problem, history, energy)
    result.steps = len(history.states) - 1
    result.rejected_steps = history.rejected
    result.residual_max_K = history.residual
    result.end_time_s = history.states[-1].time
    result.warmup_time_s = history.reached_time
    result.target_degC = document.run.target
    if document.run.target is not None:
        result.target_reached = reached is not None
    result.switches_s = history.switches or None
    if history.reduced is not None:
        told = history.reduced
        result.reduced = ReducedRun(
            unknowns=told.unknowns,
            begun_s=told.begun,
            stretches=told.stretches,
            checks=told.checks,
            error_bound_K=told.error,
            taken_back=told.returns,
        )
    result.status = _status(imbalance, document, result)
    result.probes = probes_of(problem, history)
    result.efficiency = efficiency_of(energy)
    if problem.pieces is not None:
        result.production = describe(problem.pieces, history)
    if problem.work_surface is not None and reached is not None and result.work_surface is not None:
        there = history.states[reached].temperature
        if reached == 0:  # reached at once: by places that are held, which jump
            there = problem.model.hold(0.0, there)
        found = problem.work_surface.evenness(there)
        result.work_surface.at_warmup = _evenness(found)
    return result


def unresolved(document: MoldDocument, problem: Problem, history: History, low: float, high: float) -> list[str]:
    """Say where elements are too large for the time of a run.

    Without sources heat flow has its extremes at the start and the surroundings, ``low`` and ``high`` [degC]. A step of
    heat that has not yet come through an element makes its far nodes colder, or hotter, than that.
    """
    last, found = len(history.states) - 1, []
    for state in (history.states[k] for k in sorted({history.reached or last, last})):
        there = state.temperature[: problem.mesh.solid]
        past = {int(there.argmin()): low - float(there.min()), int(there.argmax()): float(there.max()) - high}
        node = max(past, key=lambda k: past[k])
        span = min(high, float(there.max())) - max(low, float(there.min()))
        if past[node] <= max(BEYOND_ALL * span, document.run.tolerance):
            continue
        number = int(problem.mesh.parts[np.any(problem.mesh.elements == node, axis=1)][0])
        part, material, at = document.part[number], problem.model.materials[number], float(there[node])
        spread = material.conductivity.at(at) / material.density / material.specific_heat.at(at)
        size = min(2e3 * np.sqrt(spread * state.time), 0.5 * (part.mesh_size or document.run.mesh_size))
        x, y, z = 1e3 * problem.mesh.points[node]
        found.append(
            f"after {state.time:.3g} s the elements of {part.name!r} are {past[node]:.2g} K "
            f"{'colder' if at < low else 'hotter'} at ({x:.3g}, {y:.3g}, {z:.3g}) mm than anything they began at or "
            "stand in: they are too large for heat that has had so little time, and what is told of places there may "
            f'be off by more than that; give the part mesh_size = "{size:.2g} mm"'
        )
    return found


def energy_of(history: History) -> Energy:
    """Return the account of heat of a run."""
    ledger, reached = history.ledger, history.reached
    energy = Energy(
        supplied_J=ledger.supplied(),
        lost_J=ledger.lost(),
        stored_J=ledger.stored[-1] if ledger.stored else 0.0,
        imbalance_relative=ledger.imbalance(),
        by_condition_J=ledger.by_condition,
    )
    if reached:
        energy.at_warmup = {
            "supplied_J": ledger.supplied(reached),
            "lost_J": ledger.lost(reached),
            "stored_J": ledger.stored[reached - 1],
        }
    return energy


def steady_document(problem: Problem, history: History) -> HeatDocument:
    """Return the document of a steady state."""
    first, last = history.states[0], history.states[-1]
    powers = _powers(problem, last)
    # Against nothing but rounding, what the mold would lose if it were warmer by LEAST_CHANGE.
    uniform = problem.model.free.astype(float)
    conductance = dot(uniform, problem.model.steady_matrix(last.time, last.temperature) @ uniform)
    turned = max(sum(abs(power) for power in powers.values()), LEAST_CHANGE * conductance)
    imbalance = abs(sum(powers.values())) / turned if turned else 0.0
    energy = Energy(stored_J=float((last.stored - first.stored).sum()), imbalance_relative=imbalance)
    result = _common(problem, history, energy)
    result.steady = True
    # A temperature is held by whatever gives the heat for it: where nothing else changes, that is a supply.
    held = {condition.name for condition in problem.model.prescribed if powers[condition.name] > 0.0}
    result.power_supplied_W = (result.power_supplied_W or 0.0) + sum(powers[name] for name in sorted(held))
    result.power_lost_W = {name: lost for name, lost in result.power_lost_W.items() if name not in held}
    if not result.converged:
        result.status = f"heat in and out differ by {imbalance:.2g}"
    result.probes = {
        name: ProbeResult(final_degC=dot(sensor, last.temperature), max_degC=dot(sensor, last.temperature))
        for name, sensor in problem.probes.items()
    }
    return result


def _common(problem: Problem, history: History, energy: Energy) -> HeatDocument:
    model, last = problem.model, history.states[-1]
    solid = last.temperature[: problem.mesh.solid]
    masses = model.medium.masses
    parts = [part.name for part in problem.geometry.parts]
    powers, heaters = _powers(problem, last), {heater.name for heater in model.heaters}
    flux = np.linalg.norm(model.medium.flux(last.temperature), axis=1)
    imbalance = energy.imbalance_relative
    result = HeatDocument(
        converged=bool(np.isfinite(imbalance) and imbalance <= IMBALANCE_ALLOWED),
        steps=0,
        unknowns=int(model.free.sum()),
        elements=len(problem.mesh.elements),
        solver=model.solver_name,
        linear_iterations=model.iterations,
        energy=energy,
        power_supplied_W=sum(heater.power_at(last.time) for heater in model.heaters),
        power_lost_W={name: -power for name, power in powers.items() if name not in heaters},
        conditions={
            name: FaceUse(area_mm2=area or None, power_W=powers.get(name)) for name, area in problem.areas.items()
        },
        mass_kg=float(masses.sum()),
        mass_by_part_kg=dict(zip(parts, masses.tolist(), strict=True)),
        heat_capacity_J_K=model.total_capacity(last.temperature) - float(model.loose.sum()),
        hottest=_extreme(problem, last, int(np.argmax(solid))),
        coldest=_extreme(problem, last, int(np.argmin(solid))),
        flux_max_W_m2=float(flux.max()),
    )
    if problem.work_surface is not None:
        end = _evenness(problem.work_surface.evenness(last.temperature))
        area = problem.work_surface.area * 1e6
        result.work_surface = WorkSurface(**end.model_dump(), area_mm2=area, at_end=end)
    return result


def _powers(problem: Problem, state: Past) -> dict[str, float]:
    """Return the power that enters through each condition at a state [W]."""
    model = problem.model
    powers = {
        c.name: c.power_at(state.time) if isinstance(c, Heater) else float(c.flow(state.time, state.temperature).sum())
        for c in model.conditions
    }
    if model.prescribed:
        reaction = -model.flow(state.time, state.temperature)
        if len(state.rate) and not np.allclose(state.rate, -reaction):
            reaction = state.rate + reaction
        done = model.free.copy()
        for held in model.prescribed:
            mine = held.nodes[~done[held.nodes]]
            powers[held.name] = float(reaction[mine].sum())
            done[mine] = True
    return powers


def _status(imbalance: float, document: MoldDocument, result: HeatDocument) -> str | None:
    if not result.converged:
        return f"the account of heat is off by {imbalance:.2g}, more than {IMBALANCE_ALLOWED:g}"
    if result.target_reached is False:
        mean = result.work_surface.mean_degC if result.work_surface else float("nan")
        when = f"by {result.end_time_s:.6g} s" if document.run.until is not None else "ever: it has come to rest"
        return f"the work surface did not reach {document.run.target:g} degC {when}; its mean is {mean:.2f} degC"
    return None


def probes_of(problem: Problem, history: History) -> dict[str, ProbeResult]:
    """Return what each probe reads at the end and at most."""
    times = curve_times(history)
    curves = [curve(history, sensor, times) for sensor in problem.probes.values()]
    return shown(problem, times, np.array(curves).reshape(len(curves), len(times)).T)


def shown(problem: Problem, times: Array, values: Array) -> dict[str, ProbeResult]:
    """Return what each probe reads at the end and at most, of what it feels at ``times`` (t,): ``values`` (t, p)."""
    found = {}
    for (name, lags), felt in zip(problem.lags.items(), values.T, strict=True):
        read = as_shown(times, felt, lags)
        found[name] = ProbeResult(final_degC=float(read[-1]), max_degC=float(read.max()))
    return found


def efficiency_of(energy: Energy) -> float | None:
    """Return what is stored of the heat supplied, up to the target where it is reached."""
    account = energy.at_warmup
    supplied = account["supplied_J"] if account else energy.supplied_J
    stored = account["stored_J"] if account else energy.stored_J
    return stored / supplied if supplied is not None and supplied > 0.0 else None


def _evenness(found: facet_operator.Evenness) -> Evenness:
    return Evenness(mean_degC=found.mean, min_degC=found.least, max_degC=found.greatest, spread_K=found.spread)


def _extreme(problem: Problem, state: Past, node: int) -> Extreme:
    x, y, z = (1e3 * problem.mesh.points[node]).tolist()
    return Extreme(temperature_degC=float(state.temperature[node]), at_mm=(x, y, z))
