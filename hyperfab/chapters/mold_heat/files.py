"""The files beside ``heat.json``: last field, time series, curves, picture."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.chapters.mold_heat.problem import Problem
from hyperfab.chapters.mold_heat.production import pieces_csv
from hyperfab.chapters.uncertainty.carry import Sure
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output
from hyperfab.io.vtu import collection, refilled, unstructured
from hyperfab.report.figures_heat import heat_figure
from hyperfab.thermal.history import History, curve, curve_times
from hyperfab.thermal.sensors import as_shown

#: Frames of the time series, and bytes all fields may take together: more steps are thinned evenly.
FRAMES, SERIES_BYTES = 40, 50e6
#: The field of a series that changes from frame to frame.
TEMPERATURE = "temperature_degC"


def load_writers() -> None:
    """Import what ``write_fields`` will need: a second that may pass while another process is waited for."""
    import matplotlib.backends.backend_agg
    import matplotlib.figure
    import matplotlib.tri  # noqa: F401
    import meshio  # noqa: F401


def write_fields(out: Output, problem: Problem, history: History, target: float | None, sure: Sure) -> None:
    """Queue every sibling of the document; ``sure`` says how sure the last field and the time of warm-up are."""
    last = history.states[-1]
    flux = problem.model.medium.flux(last.temperature)
    final = _field(problem, last.temperature, flux, {**sure.twins, **sure.handed})
    out.add(".vtu", final)
    if not history.ledger.entered:  # a steady state has no curves
        out.add(
            ".png",
            heat_figure(*_work_surface(problem, last.temperature), {}, np.zeros(0), None, "in the steady state"),
        )
        return
    ending = _field(problem, last.temperature, None)
    count = frame_count(len(ending), len(final))
    frames = np.unique(np.linspace(0, len(history.states) - 1, count).round().astype(int))
    names = []
    for number, index in enumerate(frames):
        suffix = f".{number:03d}.vtu"
        temperature = history.states[index].temperature[: problem.mesh.solid]
        out.add(suffix, refilled(ending, TEMPERATURE, temperature))
        names.append(out.path(suffix).name)
    out.add(".pvd", collection([history.states[i].time for i in frames], names))
    times = curve_times(history)
    curves = {
        name: as_shown(times, curve(history, sensor, times), problem.lags[name])
        for name, sensor in problem.probes.items()
    }
    heads = ["time_s", *(f"{name}_degC" for name in curves)]
    out.add(".csv", csv_bytes(heads, list(zip(times, *curves.values(), strict=True))))
    out.add(".history.csv", _history(problem, history))
    if problem.pieces is not None:
        out.add(".pieces.csv", pieces_csv(problem.pieces, history))
    shown = dict(curves)
    if problem.work_surface is not None:
        shown = {"work surface, mean": curve(history, problem.work_surface.mean_weights, times), **shown}
    at = last if history.reached is None else history.states[history.reached]
    warm = sure.interval("warmup_time_s")
    title = f"{'at the end' if history.reached is None else 'at warm-up'}, {at.time / 60:.1f} min"
    out.add(".png", heat_figure(*_work_surface(problem, at.temperature), shown, times, target, title, warm))


def frame_count(size: int, final: int) -> int:
    """Return how many frames of ``size`` bytes a time series has beside ``final`` bytes: first and last at least.

    >>> frame_count(100_000, 200_000), frame_count(6_000_000, 8_000_000), frame_count(10**9, 10**9)
    (40, 7, 2)
    """
    return int(np.clip((SERIES_BYTES - final) // size, 2, FRAMES))


def _field(problem: Problem, temperature: Array, flux: Array | None, sure: Mapping[str, Array] = {}) -> bytes:
    mesh = problem.mesh
    cells: dict[str, NDArray] = {"part": mesh.parts.astype(np.int32)}
    if flux is not None:
        cells["heat_flux_W_m2"] = flux
        cells["temperature_gradient_K_m"] = problem.model.medium.gradient(temperature)
    solid = mesh.solid
    return unstructured(
        mesh.points[:solid] * 1e3,
        {"tetra10": mesh.elements},
        {TEMPERATURE: temperature[:solid], **sure},
        cells,
    )


def _history(problem: Problem, history: History) -> bytes:
    """One row a step: account of heat and evenness of the work surface."""
    ledger = history.ledger
    supplied, lost = (np.cumsum([0.0, *heat]) for heat in ledger.by_step)
    header = ["time_s", "supplied_J", "lost_J", "stored_J"]
    columns = [np.array(history.states.times), supplied, lost, np.array([0.0, *ledger.stored])]
    if problem.work_surface is not None:
        found = [state.evenness(problem.work_surface) for state in history.states]
        header += [f"work_surface_{what}" for what in ("mean_degC", "min_degC", "max_degC", "spread_K")]
        columns += [np.array([getattr(f, name) for f in found]) for name in ("mean", "least", "greatest", "spread")]
    return csv_bytes(header, list(zip(*columns, strict=True)))


def _work_surface(problem: Problem, temperature: Array) -> tuple[Array, Ints, Array]:
    """Return nodes [mm], flat triangles (four a facet) and temperatures of the work surface, or of all outer faces."""
    if problem.work_surface is not None:
        nodes = problem.work_surface.nodes
    else:
        nodes = problem.mesh.facet_nodes(problem.mesh.facets.outer)
    corners = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
    used, small = np.unique(nodes[:, corners].reshape(-1, 3), return_inverse=True)
    return problem.mesh.points[used] * 1e3, small, temperature[used]
