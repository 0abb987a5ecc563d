"""A clamp that gives: ``--rim-slip``."""

from __future__ import annotations

from hyperfab.loop.catalogue.contact.scene import Scene
from hyperfab.loop.problem import Constant, Effect, Form


def entry(scene: Scene) -> Effect | None:
    """Return the effect: the rim creeps inward in proportion to the pull."""
    slip = Constant("slip_mm2_N", 0.0, 0.0, scene.slip, 0.02 * scene.slip)
    return Effect(
        id="rim-slip",
        title="the sheet slips in its clamp",
        rides_on=("depth_mm",),
        shown_by="marks on the sheet along the rim, before and after",
        source="a linear spring in the plane of the clamp",
        forms=(Form("spring", (slip,), ((0.1 * scene.slip,), (0.5 * scene.slip,)), ((0.03 * scene.slip,),)),),
        smooth=False,
        mimic_share=0.95,
        mimic_left=0.5,
    )
