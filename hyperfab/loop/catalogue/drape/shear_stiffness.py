"""Threads that resist turning against each other: ``--shear-modulus``."""

from __future__ import annotations

from hyperfab.loop.catalogue.drape import Scene
from hyperfab.loop.problem import Constant, Effect, Form


def entry(scene: Scene) -> Effect | None:
    """Return the effect: a shear modulus, added to the model's own."""
    modulus = Constant("modulus_MPa", 0.0, 0.0, scene.shear, 0.02 * scene.shear, places=("shear",))
    starts = ((0.1 * scene.shear,), (0.5 * scene.shear,))
    return Effect(
        id="shear-stiffness",
        title="the fabric resists shear",
        rides_on=("x0_mm", "y0_mm"),
        shown_by="a bias test, cut at 45 degrees to the warp; or markers on the diagonals",
        source="energy of the angle between the threads, G gamma^2/2",
        forms=(Form("linear", (modulus,), starts, ((0.03 * scene.shear,),)),),
        smooth=False,
        mimic_share=0.95,
        mimic_left=0.5,
    )
