"""A female mounted off the male's axis: ``[press] offset`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Constant, Form


class LateralShift(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Move the female across the axis."""
        press.offset += np.array([at["offset_x_mm"], at["offset_y_mm"]])


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a displacement along each of the two axes across the closing axis."""
    some = 0.1
    both = tuple(Constant(f"offset_{name}_mm", 0.0, -5.0, 5.0, 0.5 * some) for name in "xy")
    return LateralShift(
        id="lateral-shift",
        title="the molds are mounted off each other's axis",
        rides_on=("x_mm", "y_mm"),
        shown_by="the thickness on opposite flanks, and a dial gauge on the mounting face, which a tilt moves",
        source="rigid displacement",
        forms=(
            Form(
                "displacement", both,
                ((2.0 * some, 0.0), (0.0, 2.0 * some), (-2.0 * some, 0.0), (0.0, -2.0 * some)),
                ((some, 0.0), (0.0, some)),
            ),
        ),
    )  # fmt: skip
