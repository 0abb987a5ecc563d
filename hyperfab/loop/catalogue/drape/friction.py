"""Coulomb friction between sheet and mold: ``--friction``."""

from __future__ import annotations

from hyperfab.loop.catalogue.drape import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect | None:
    """Return the effect: a coefficient, added to the model's own."""
    mu = Constant("mu", 0.0, 0.0, max(context.friction, 1e-9), 0.05, places=("friction",))
    return Effect(
        id="friction",
        title="the sheet rubs on the mold",
        rides_on=("from the middle_mm", "z_mm"),
        shown_by="the same drape with the mold polished, or with a film of grease",
        source="Coulomb's law",
        forms=(Form("Coulomb", (mu,), ((0.1,), (0.35,)), ((0.05,),)),) if context.friction else (),
    )
