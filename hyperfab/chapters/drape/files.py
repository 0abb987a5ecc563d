"""What ``hf drape`` writes beside its document: the field, the energy history, the picture."""

from __future__ import annotations

import numpy as np

from hyperfab.cloth import Answers, Equilibrium, Sheet
from hyperfab.cloth.mold import FREE
from hyperfab.io import vtu
from hyperfab.report.figures_drape import drape_figure

CSV_HEADER = (
    "nodes_x,nodes_y,iteration,energy_J,residual_relative,contact_nodes,step,inner_iterations,"
    "contact_set_changed"
)


def field(sheet: Sheet, found: Equilibrium, fields: Answers) -> bytes:
    """The draped net as quads; ``flat_mm`` is each node's place on the flat sheet."""
    n, m = sheet.n, sheet.m
    number = np.arange(n * m).reshape(n, m)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], 2).reshape(-1, 4)
    flat = sheet.flat().reshape(-1, 3)
    return vtu.unstructured(
        found.state.x.reshape(-1, 3),
        {"quad": quads},
        {
            "stress_warp_MPa": fields.stress_warp.ravel(),
            "stress_weft_MPa": fields.stress_weft.ravel(),
            "contact": (found.state.contact != FREE).ravel(),
            "residual_N": np.linalg.norm(found.residual, axis=2).ravel(),
            "contact_force_N": fields.contact_force.reshape(-1, 3),
            "flat_mm": flat,
        },
        {
            "thickness_mm": fields.cell_thickness.ravel(),
            "stretch_warp": fields.cell_stretch_warp.ravel(),
            "stretch_weft": fields.cell_stretch_weft.ravel(),
            "shear_deg": fields.cell_shear.ravel(),
            "slack": fields.cell_slack.ravel(),
        },
    )


def history(found: Equilibrium) -> bytes:
    """The energy and the residual step by step, grid by grid."""
    lines = [CSV_HEADER]
    for s in found.history:
        lines.append(
            f"{s.nodes[0]},{s.nodes[1]},{s.iteration},{s.energy * 1e-3!r},{s.residual!r},{s.contacts},"
            f"{s.step_length!r},{s.inner},{int(s.set_changed)}"
        )
    return ("\n".join(lines) + "\n").encode()


def picture(sheet: Sheet, found: Equilibrium, fields: Answers) -> bytes:
    """The draped sheet, and on the flat sheet its stresses, thickness, contact and slack."""
    return drape_figure(
        found.state.x,
        sheet.flat(),
        fields.stress_warp,
        fields.stress_weft,
        fields.cell_thickness,
        found.state.contact != FREE,
        fields.cell_slack,
    )
