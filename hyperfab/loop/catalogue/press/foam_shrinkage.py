"""Foam that has lost thickness to heat: ``shrinkage`` of foam.toml."""

from __future__ import annotations

from hyperfab.loop.catalogue.press import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a share of the foam's thickness."""
    amount = Constant("amount", 0.0, 0.0, 0.8, 0.02, places=("foam.lost",))
    return Effect(
        id="foam-shrinkage",
        title="the foam has shrunk",
        rides_on=("x_mm", "y_mm", "z_mm"),
        shown_by="the thickness of the foam before and after it was heated without load",
        source="ASTM D2126: response of rigid cellular plastics to heat",
        forms=(Form("share", (amount,), ((0.05,), (0.2,)), ((0.02,),)),),
        smooth=False,
        confounded_share=0.95,
        mimic_left=0.35,
    )
