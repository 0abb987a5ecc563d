"""The sheet's own weight: ``--mass``."""

from __future__ import annotations

from hyperfab.loop.catalogue.drape import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect | None:
    """Return the effect: a mass per area."""
    mass = Constant("mass_g_m2", 0.0, 0.0, context.mass, 0.02 * context.mass, places=("mass",))
    return Effect(
        id="gravity",
        title="the sheet hangs under its own weight",
        rides_on=("from the middle_mm", "z_mm"),
        shown_by="the sheet on a scale; or the sag of the mounted sheet before it is draped",
        source="weight of the nodes' shares",
        forms=(
            Form(
                "weight", (mass,), ((0.1 * context.mass,), (0.5 * context.mass,)), ((0.03 * context.mass,),)
            ),
        ),
    )
