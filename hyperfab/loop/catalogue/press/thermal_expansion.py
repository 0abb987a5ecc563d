"""Molds that have grown with heat: ``expansion`` of foam.toml and the temperature of the press."""

from __future__ import annotations

from hyperfab.loop.catalogue.press import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: thermal strain of both molds, or of each, beyond what the model has."""
    # 23e-6 1/K: aluminium, 100 K.
    strain = Constant("strain", 0.0, -0.03, 0.03, 2e-4, places=("strain.male", "strain.female"))
    more = Constant("female_more", 0.0, -0.03, 0.03, 2e-4, places=("strain.female",))
    return Effect(
        id="thermal-expansion",
        title="the molds have grown with heat",
        rides_on=("x_mm", "y_mm", "z_mm"),
        shown_by="the thickness of the sandwich on top and on the flanks, cold and hot",
        source="linear thermal expansion about the mounting face",
        forms=(
            Form("both molds", (strain,), ((2e-3,), (-2e-3,)), ((2e-4,),)),
            Form("each mold", (strain, more), ((2e-3, 0.0),), ((0.0, 2e-4),), refines="both molds"),
        ),
        smooth=False,
        confounded_share=0.95,
        mimic_left=0.35,
    )
