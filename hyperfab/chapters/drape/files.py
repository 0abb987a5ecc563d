"""What ``hf drape`` writes beside its document: the field, the energy history, the picture."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.chapters.drape.model import Model, State
from hyperfab.chapters.drape.result import peak
from hyperfab.chapters.uncertainty.carry import Sure
from hyperfab.cloth import Sheet
from hyperfab.cloth.friction import SLIDES, STARTS, STICKS
from hyperfab.io import vtu
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output
from hyperfab.io.stl_write import stl_bytes

HISTORY = (
    "nodes_x",
    "nodes_y",
    "iteration",
    "energy_J",
    "residual_relative",
    "contact_nodes",
    "step",
    "inner_iterations",
    "contact_set_changed",
    "depth_mm",
)


def write(out: Output, model: Model, states: list[State], sure: Sure, force: str) -> None:
    """Queue the files: of the last state, and where several were asked for a field of each; the mold as it stands.

    ``sure`` says how sure the last state's fields and force are, ``force`` what the press force is, in words.
    """
    sheet, max_stretch, last = model.sheet, model.case.max_stretch, states[-1]
    surface = model.files.placed.surface
    corners = surface.vertices + np.array(model.files.placed.standing(last.depth))
    out.add(".vtu", field(sheet, last, max_stretch, {**sure.twins, **sure.handed}))
    if len(states) > 1:
        names = []
        for number, state in enumerate(states, 1):
            suffix = f".{number:03d}.vtu"
            out.add(suffix, field(sheet, state, max_stretch))
            names.append(out.path(suffix).name)
        out.add(".pvd", vtu.collection([state.depth for state in states], names))
    out.add(".csv", history(states))
    out.add(".mold.stl", stl_bytes(corners, surface.faces))
    out.add(".png", picture(sheet, states, (corners, surface.faces), force, sure.interval("force_N")))


def field(sheet: Sheet, state: State, max_stretch: float | None, sure: Mapping[str, Array] = {}) -> bytes:
    """The draped net as quads; ``flat_mm`` is each node's place on the flat sheet."""
    n, m = sheet.n, sheet.m
    found, fields = state.found, state.fields
    number = np.arange(n * m).reshape(n, m)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], 2).reshape(-1, 4)
    flat = sheet.flat().reshape(-1, 3)
    points = {
        "stress_warp_MPa": fields.stress_warp.ravel(),
        "stress_weft_MPa": fields.stress_weft.ravel(),
        "contact": fields.touching.ravel(),
        "residual_N": np.linalg.norm(found.residual, axis=2).ravel(),
        "contact_force_N": fields.contact_force.reshape(-1, 3),
        "flat_mm": flat,
    }
    if state.rest is not None:
        points["friction_N"] = state.rest.friction.forces().reshape(-1, 3)
        points["sliding"] = np.isin(state.rest.friction.stick_slip, (STARTS, SLIDES)).ravel()
        points["sticking"] = (state.rest.friction.stick_slip == STICKS).ravel()
    cells = {
        "thickness_mm": fields.cell_thickness.ravel(),
        "stretch_warp": fields.cell_stretch_warp.ravel(),
        "stretch_weft": fields.cell_stretch_weft.ravel(),
        "stretch_larger": fields.cell_stretch.ravel(),
        "shear_deg": fields.cell_shear.ravel(),
        "slack": fields.cell_slack.ravel(),
        "on_edge": fields.cell_on_edge.ravel(),
    }
    if max_stretch is not None:
        cells["over_max_stretch"] = (fields.cell_stretch > max_stretch).ravel()
    if fields.cells is not None:
        cells["stress_larger_MPa"] = fields.cells.cauchy.ravel()
    for name, values in sure.items():
        if len(values) == len(quads):
            cells[name] = values
        else:
            points[name] = values.reshape(n * m, -1).squeeze()
    return vtu.unstructured(found.state.x.reshape(-1, 3), {"quad": quads}, points, cells)


def history(states: list[State]) -> bytes:
    """The energy and the residual step by step, grid by grid, depth by depth."""
    rows = [
        (
            *s.nodes,
            s.iteration,
            s.energy * 1e-3,
            s.residual,
            s.contacts,
            s.step_length,
            s.inner,
            s.set_changed,
            state.depth,
        )
        for state in states
        for s in state.found.history
    ]
    return csv_bytes(HISTORY, rows)


def picture(
    sheet: Sheet,
    states: list[State],
    mold: tuple[Array, Ints],
    force: str,
    interval: tuple[float, float] | None,
) -> bytes:
    """The sheet draped on the mold (corners, facets), on the flat sheet its stretch and what follows from it, and the
    ``force`` of the press, in words, with its ``interval`` where it is known."""
    # matplotlib takes a fifth of the command's start.
    from hyperfab.report.figures_drape import Draped, drape_figure

    found, place = states[-1].found, peak(sheet, states[-1])
    return drape_figure(
        Draped(found.state.x, sheet.flat(), states[-1].fields, (place.flat, place.draped), mold),
        [(0.0, 0.0), *((s.depth, s.fields.press_force) for s in states)] if len(states) > 1 else None,
        force,
        interval,
    )
