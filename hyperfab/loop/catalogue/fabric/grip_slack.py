"""Play in the grips, or a specimen mounted taut."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric.scene import Scene
from hyperfab.loop.problem import Constant, Effect, Form


def entry(scene: Scene) -> Effect:
    """Return the effect: strain that only takes up play, with or without a rounded end."""
    reach = scene.reach
    slack = Constant("slack", 0.0, -0.1 * reach, 0.6 * reach, 0.02 * reach)
    return Effect(
        id="grip-slack",
        title="the first extension takes up slack",
        rides_on=("stretch",),
        shown_by="the stretch from marks on the specimen beside that of the grips, close readings at the start",
        source="ASTM D638, annex A1 (toe compensation)",
        forms=(
            Form("play", (slack,), ((0.03 * reach,), (0.1 * reach,), (-0.02 * reach,)), ((0.005 * reach,),)),
            Form(
                "toe",
                (slack, Constant("toe", 0.0, 0.0, 0.6 * reach, 0.02 * reach)),
                ((0.03 * reach, 0.03 * reach),),
                refines="play",
            ),
        ),
        mimic_share=0.93,
    )
