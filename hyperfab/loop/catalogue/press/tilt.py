"""A female that stands out of parallel: ``[press] tilt`` of foam.toml."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Constant, Form


class Tilt(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Turn the female."""
        press.tilt += np.radians([at["tilt_x_deg"], at["tilt_y_deg"]])


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a rotation about each of the two axes across the closing axis."""
    edge = math.degrees(0.1 / context.half_mm)
    about_x, about_y = (Constant(f"tilt_{name}_deg", 0.0, -5.0, 5.0, 0.5 * edge) for name in "xy")
    starts = ((2.0 * edge, 0.0), (0.0, 2.0 * edge), (-2.0 * edge, 0.0), (0.0, -2.0 * edge))
    return Tilt(
        id="tilt",
        title="the molds are not parallel",
        not_sought="a floating female finds its own tilt" if context.floats else "",
        rides_on=("x_mm", "y_mm"),
        shown_by="pressure or thickness on opposite sides of the mold",
        source="rigid rotation, Rodrigues' formula",
        forms=(Form("rotation", (about_x, about_y), starts, ((edge, 0.0), (0.0, edge))),),
    )
