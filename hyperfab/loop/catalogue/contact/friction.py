"""Coulomb friction between sheet and punch: ``--friction``."""

from __future__ import annotations

from hyperfab.loop.catalogue.contact import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a coefficient, added to the model's own."""
    mu = Constant("mu", 0.0, 0.0, max(context.friction, 1e-9), 0.05, places=("friction",))
    return Effect(
        id="friction",
        title="the sheet rubs on the punch",
        not_sought="" if context.friction else "the model's sheet sticks to the punch where it touches",
        rides_on=("depth_mm",),
        shown_by="the same test with the punch oiled, or powdered",
        source="Coulomb's law",
        forms=(Form("Coulomb", (mu,), ((0.2,), (0.5,)), ((0.1,),)),) if context.friction else (),
    )
