"""A sheet mounted taut: ``--prestretch``."""

from __future__ import annotations

from hyperfab.loop.catalogue.drape import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect | None:
    """Return the effect: stretch of the mounted sheet, alike along warp and weft, or not."""
    down, up = context.prestretch
    both = Constant("added_stretch", 0.0, -down, up, 0.005, places=("prestretch",))
    more = Constant("weft_more", 0.0, -up, up, 0.005, places=("weft more",))
    return Effect(
        id="pretension",
        title="the sheet was mounted under tension",
        rides_on=("from the middle_mm", "z_mm"),
        shown_by="the force of the press over the first tenth of its way; markers where the sheet hangs free",
        source="springs shorter than the mounted sheet",
        forms=(
            Form("even", (both,), ((0.02,), (0.08,)), ((0.005,),)),
            Form("each way", (both, more), ((0.03, 0.0),), ((0.0, 0.005),), refines="even"),
        ),
    )
