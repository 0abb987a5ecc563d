"""What ``hf drape`` writes beside its document: the field, the energy history, the picture."""

from __future__ import annotations

import numpy as np

from hyperfab.chapters.drape.states import State
from hyperfab.cloth import Sheet
from hyperfab.cloth.friction import SLIDES, STARTS, STICKS
from hyperfab.io import vtu
from hyperfab.io.csv_write import csv_bytes
from hyperfab.io.output import Output

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


def write(out: Output, sheet: Sheet, states: list[State], max_stretch: float | None) -> None:
    """Queue the files: of the last state, and where several were asked for a field of each."""
    last = states[-1]
    out.add(".vtu", field(sheet, last, max_stretch))
    if len(states) > 1:
        names = []
        for number, state in enumerate(states, 1):
            suffix = f".{number:03d}.vtu"
            out.add(suffix, field(sheet, state, max_stretch))
            names.append(out.path(suffix).name)
        out.add(".pvd", vtu.collection([state.depth for state in states], names))
    out.add(".csv", history(states))
    out.add(".png", picture(sheet, states))


def field(sheet: Sheet, state: State, max_stretch: float | None) -> bytes:
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
        points["sliding"] = np.isin(state.rest.friction.rubs, (STARTS, SLIDES)).ravel()
        points["sticking"] = (state.rest.friction.rubs == STICKS).ravel()
    cells = {
        "thickness_mm": fields.cell_thickness.ravel(),
        "stretch_warp": fields.cell_stretch_warp.ravel(),
        "stretch_weft": fields.cell_stretch_weft.ravel(),
        "shear_deg": fields.cell_shear.ravel(),
        "slack": fields.cell_slack.ravel(),
        "on_edge": fields.cell_on_edge.ravel(),
    }
    if max_stretch is not None:
        cells["over_max_stretch"] = (
            np.maximum(fields.cell_stretch_warp, fields.cell_stretch_weft) > max_stretch
        ).ravel()
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


def picture(sheet: Sheet, states: list[State]) -> bytes:
    """The draped sheet, and on the flat sheet its stresses, thickness, contact and slack."""
    from hyperfab.report.figures_drape import drape_figure  # matplotlib takes a fifth of the command's start

    found, fields = states[-1].found, states[-1].fields
    return drape_figure(
        found.state.x,
        sheet.flat(),
        fields.stress_warp,
        fields.stress_weft,
        fields.cell_thickness,
        fields.touching,
        fields.cell_slack,
        [(0.0, 0.0), *((s.depth, s.fields.press_force) for s in states)] if len(states) > 1 else None,
    )
