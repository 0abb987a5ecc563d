"""Molds that have grown with heat: ``expansion`` of foam.toml and the temperature of the press."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Constant, Form


class ThermalExpansion(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Let both molds grow."""
        press.strain += at["strain"] + np.array([0.0, at.get("female_more", 0.0)])


def entry(context: DataContext) -> PressEffect:
    """Return the effect: thermal strain of both molds, or of each, beyond what the model has."""
    # 23e-6 1/K: aluminium, 100 K.
    strain = Constant("strain", 0.0, -0.03, 0.03, 2e-4)
    more = Constant("female_more", 0.0, -0.03, 0.03, 2e-4)
    return ThermalExpansion(
        id="thermal-expansion",
        title="the molds have grown with heat",
        rides_on=("x_mm", "y_mm", "z_mm"),
        shown_by="the thickness of the sandwich on top and on the flanks, cold and hot",
        source="linear thermal expansion about the mounting face",
        forms=(
            Form("both molds", (strain,), ((2e-3,), (-2e-3,)), ((2e-4,),)),
            Form("each mold", (strain, more), ((2e-3, 0.0),), ((0.0, 2e-4),), refines="both molds"),
        ),
    )
