"""A female that stands out of parallel: ``[press] tilt`` of foam.toml."""

from __future__ import annotations

import math

from hyperfab.loop.catalogue.press import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a rotation about each of the two axes across the closing axis."""
    edge = math.degrees(0.1 / context.half_mm)
    about_x, about_y = (
        Constant(f"tilt_{name}_deg", 0.0, -5.0, 5.0, 0.5 * edge, places=(f"tilt_deg.{name}",))
        for name in "xy"
    )
    starts = ((2.0 * edge, 0.0), (0.0, 2.0 * edge), (-2.0 * edge, 0.0), (0.0, -2.0 * edge))
    return Effect(
        id="tilt",
        title="the molds are not parallel",
        not_sought="a floating female finds its own tilt" if context.floats else "",
        rides_on=("x_mm", "y_mm"),
        shown_by="pressure or thickness on opposite sides of the mold",
        source="rigid rotation, Rodrigues' formula",
        forms=(Form("rotation", (about_x, about_y), starts, ((edge, 0.0), (0.0, edge))),),
        smooth=False,
        confounded_share=0.95,
        mimic_left=0.35,
    )
