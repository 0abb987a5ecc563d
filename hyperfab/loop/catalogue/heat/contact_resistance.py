"""A joint that does not conduct perfectly: ``[[contact]]`` of the mold document."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat.scene import Scene
from hyperfab.loop.problem import Constant, Effect, Form


def entry(scene: Scene) -> Effect | None:
    """Return the effect: one resistance for the joints that conduct perfectly in the model."""
    if not scene.opened:
        return None
    # A film of air of a few hundredths of a millimetre: 1e-3 m^2 K/W.
    resistance = Constant("resistance_m2K_W", 0.0, 0.0, 0.1, 2e-4)
    return Effect(
        id="contact-resistance",
        title="parts that touch do not conduct perfectly",
        rides_on=("power_W", "probe"),
        shown_by="a thermocouple on each side of the joint",
        source="Yovanovich (2005), doi:10.1109/TCAPT.2005.848483",
        forms=(Form("gap", (resistance,), ((3e-4,), (3e-3,)), ((5e-5,), (5e-4,))),),
        smooth=False,
        mimic_share=0.98,
    )
