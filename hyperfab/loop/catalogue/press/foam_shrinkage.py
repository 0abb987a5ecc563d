"""Foam that has lost thickness to heat: ``shrinkage`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import Constant, Form


class FoamShrinkage(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Take from the foam's thickness."""
        press.lost += at["amount"]


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a share of the foam's thickness."""
    amount = Constant("amount", 0.0, 0.0, 0.8, 0.02)
    return FoamShrinkage(
        id="foam-shrinkage",
        title="the foam has shrunk",
        rides_on=("x_mm", "y_mm", "z_mm"),
        shown_by="the thickness of the foam before and after it was heated without load",
        source="ASTM D2126: response of rigid cellular plastics to heat",
        forms=(Form("share", (amount,), ((0.05,), (0.2,)), ((0.02,),)),),
    )
