"""The sheet's own weight: ``--mass``."""

from __future__ import annotations

from hyperfab.loop.catalogue.drape import Scene
from hyperfab.loop.problem import Constant, Effect, Form


def entry(scene: Scene) -> Effect | None:
    """Return the effect: a mass per area."""
    mass = Constant("mass_g_m2", 0.0, 0.0, scene.mass, 0.02 * scene.mass, places=("mass",))
    return Effect(
        id="gravity",
        title="the sheet hangs under its own weight",
        rides_on=("from the middle_mm", "z_mm"),
        shown_by="the sheet on a scale; or the sag of the mounted sheet before it is draped",
        source="weight of the nodes' shares",
        forms=(Form("weight", (mass,), ((0.1 * scene.mass,), (0.5 * scene.mass,)), ((0.03 * scene.mass,),)),),
        smooth=False,
        mimic_share=0.95,
        mimic_left=0.5,
    )
