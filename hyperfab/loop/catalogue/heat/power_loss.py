"""Heaters that give less than their rating, the less the hotter."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a share lost, constant or growing with the heater's temperature, or out of its back.

    A wire that resists more when hot draws less at the same voltage.
    """
    share = Constant("lost_share", 0.0, -0.3, 0.9, 0.05, places=("lost",))
    rise, loss = context.rise_K, context.power_W / context.rise_K
    warm = Constant("lost_share_per_K", 0.0, -0.5 / rise, 0.9 / rise, 0.05 / rise, places=("lost_per_K",))
    bend = Constant(
        "lost_share_per_K2", 0.0, -0.9 / rise**2, 0.9 / rise**2, 0.05 / rise**2, places=("lost_per_K2",)
    )
    back = Constant("back_W_K", 0.0, 0.0, 0.9 * loss, 0.05 * loss, places=("back_W_K",))
    # Metals resist 0.004 more a kelvin, nickel 0.006, heater alloys less: CRC Handbook of Chemistry and Physics.
    wire = Constant("resistance_per_K", 0.0, 0.0, 4.0 / rise, 0.05 / rise, 0.004, ("wire_per_K",))
    return Effect(
        id="power-loss",
        title="part of the power does not reach the mold",
        not_sought="" if context.heaters else "the model has no heater",
        rides_on=("power_W", "temperature_degC"),
        shown_by="a power meter at the heaters at two plateaus",
        source="energy balance of a resistance heater",
        forms=(
            Form("constant", (share,), ((0.15,),), ((0.03,),)),
            Form(
                "with temperature",
                (share, warm),
                ((0.1, 0.1 / context.rise_K), (0.02, 0.2 / context.rise_K)),
                ((0.03, 0.0), (0.0, 0.03 / context.rise_K)),
            ),
            Form(
                "through the back",
                (share, back),
                ((0.02, 0.1 * context.power_W / context.rise_K),),
                ((0.0, 0.03 * context.power_W / context.rise_K),),
            ),
            # A straight decline passes for a film: where there is one body alone, only the bend shows.
            Form(
                "wire",
                (wire,),
                ((0.1 / context.rise_K,), (0.5 / context.rise_K,)),
                ((0.05 / context.rise_K,), (0.5 / context.rise_K,)),
            ),
            Form("wire and share", (share, wire), ((0.0, 0.0),), refines="wire"),
            Form("bent", (share, warm, bend), ((0.0, 0.0, 0.0),), refines=("with temperature", "wire")),
        ),
    )
