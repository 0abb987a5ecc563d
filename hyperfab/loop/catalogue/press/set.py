"""Foam that does not spring back from all of its compression: ``set`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import HAS_IT, Constant, Form


class Set(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Let more of the strain stay."""
        press.stays += np.array([at["share"], at.get("share_more", 0.0)])


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a share of the strain, the same of all or going with the strain."""
    reason = HAS_IT if context.foam.sets else ""
    share = Constant("share", 0.0, -1.0, 1.0, 0.05)
    more = Constant("share_more", 0.0, -1.0, 1.0, 0.05)
    return Set(
        id="set",
        title="a share of the foam's compression stays",
        not_sought=reason if context.formed else "no thickness was read after the press had opened",
        rides_on=("x_mm", "y_mm", "z_mm"),
        shown_by="the thickness after the press has opened beside that in the closed press",
        source="ISO 1856: compression set",
        forms=(
            Form("share", (share,), ((0.3,), (0.8,)), ((0.05,),)),
            Form("with strain", (share, more), ((0.3, 0.0),), ((0.0, 0.05),), refines="share"),
        ),
    )
