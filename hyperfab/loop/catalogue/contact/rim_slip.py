"""A clamp that gives: ``--rim-slip``."""

from __future__ import annotations

from hyperfab.loop.catalogue.contact import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: the rim creeps inward in proportion to the pull, or to what of it the clamp does not hold."""
    slip = Constant("slip_mm2_N", 0.0, 0.0, context.slip, 0.02 * context.slip, places=("slip",))
    past = Constant("slip_mm2_N", 0.0, 0.0, 4.0 * context.slip, 0.02 * context.slip, places=("slip",))
    hold = Constant("hold_N_mm", 0.0, 0.0, 0.9 * context.pull, 0.02 * context.pull, places=("hold",))
    some = ((0.3 * context.slip, 0.2 * context.pull), (0.8 * context.slip, 0.5 * context.pull))
    return Effect(
        id="rim-slip",
        title="the sheet slips in its clamp",
        rides_on=("depth_mm",),
        shown_by="marks on the sheet along the rim, before and after",
        source="a linear spring in the plane of the clamp, or one that dry friction holds at first",
        forms=(
            Form(
                "spring", (slip,), ((0.1 * context.slip,), (0.5 * context.slip,)), ((0.03 * context.slip,),)
            ),
            Form("past a hold", (past, hold), some, ((0.05 * context.slip, 0.3 * context.pull),)),
        ),
    )
