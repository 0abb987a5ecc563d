"""A sheet mounted taut: ``--prestretch``."""

from __future__ import annotations

from hyperfab.loop.catalogue.contact import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: stretch of the rim, added to the model's own."""
    down, up = context.prestretch
    added = Constant("added_stretch", 0.0, -down, up, 0.005, places=("prestretch",))
    return Effect(
        id="pretension",
        title="the sheet was mounted under tension",
        rides_on=("depth_mm",),
        shown_by="the first tenth of the depth, read closely: a taut sheet resists at once",
        source="a rim held at a multiple of its place",
        forms=(Form("even", (added,), ((0.01,), (0.04,)), ((0.003,),)),),
    )
