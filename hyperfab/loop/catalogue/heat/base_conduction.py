"""Heat that leaves through faces the model takes as insulated."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat.scene import Scene
from hyperfab.loop.problem import Constant, Effect, Form


def entry(scene: Scene) -> Effect | None:
    """Return the effect: a conductance to the ambient through the outer faces without a film."""
    if not scene.bench:
        return None
    h = Constant("h_W_m2K", 0.0, 0.0, 2000.0, 0.3 * scene.typical_film)
    return Effect(
        id="base-conduction",
        title="heat leaves through the base",
        rides_on=("above ambient_K", "probe"),
        shown_by="a thermocouple in the base plate beside one at the work surface, over a cool-down",
        source="Newton's law of cooling at the support",
        forms=(
            Form(
                "film",
                (h,),
                ((scene.typical_film,), (10.0 * scene.typical_film,)),
                ((0.1 * scene.typical_film,),),
            ),
        ),
        smooth=False,
        mimic_share=0.98,
    )
