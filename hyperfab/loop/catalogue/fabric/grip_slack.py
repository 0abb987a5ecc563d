"""Play in the grips, or a specimen mounted taut."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: strain that only takes up play, with or without a rounded end."""
    reach = context.reach
    slack = Constant("slack", 0.0, -0.1 * reach, 0.6 * reach, 0.02 * reach)
    count = len(context.path.curves)
    each = []
    if count > 1:
        own = [
            Constant(f"of_test_{k}", 0.0, -0.3 * reach, 0.6 * reach, 0.02 * reach)
            for k in range(2, count + 1)
        ]
        each.append(
            Form("each", (slack, *own), ((0.03 * reach, *(0.0 for _ in own)),), refines="play", of_each=True)
        )
    return Effect(
        id="grip-slack",
        title="the first extension takes up slack",
        rides_on=("stretch",),
        shown_by="the stretch from marks on the specimen beside that of the grips, close readings at the start",
        source="ASTM D638, annex A1 (toe compensation)",
        forms=(
            Form("play", (slack,), ((0.03 * reach,), (0.1 * reach,), (-0.02 * reach,)), ((0.005 * reach,),)),
            *each,
            Form(
                "toe",
                (slack, Constant("toe", 0.0, 0.0, 0.6 * reach, 0.02 * reach)),
                ((0.03 * reach, 0.03 * reach),),
                refines="play",
            ),
        ),
        smooth=True,
    )
