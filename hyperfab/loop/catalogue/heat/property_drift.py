"""Conductivity and specific heat that change with temperature."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: specific heat, conductivity or both linear in temperature, then with a bend."""
    rise = context.rise_K
    c = Constant("specific_heat_per_K", 0.0, -0.5 / rise, 2.0 / rise, 0.05 / rise, places=("capacity_per_K",))
    k = Constant(
        "conductivity_per_K", 0.0, -0.7 / rise, 2.0 / rise, 0.05 / rise, places=("conductivity_per_K",)
    )
    bend = Constant(
        "specific_heat_per_K2",
        0.0,
        -0.5 / rise**2,
        2.0 / rise**2,
        0.05 / rise**2,
        places=("capacity_per_K2",),
    )
    return Effect(
        id="property-drift",
        title="conductivity or specific heat change with temperature",
        rides_on=("temperature_degC", "heating rate_K_s"),
        shown_by="heating and cooling through the same temperatures at two powers",
        source="Touloukian (1970), Thermophysical Properties of Matter",
        forms=(
            Form(
                "specific heat",
                (c,),
                ((0.2 / context.rise_K,), (-0.1 / context.rise_K,)),
                ((0.03 / context.rise_K,),),
            ),
            Form(
                "conductivity",
                (k,),
                ((0.2 / context.rise_K,), (-0.3 / context.rise_K,)),
                ((0.03 / context.rise_K,),),
            ),
            Form(
                "both",
                (c, k),
                ((0.1 / context.rise_K, -0.1 / context.rise_K), (0.0, -0.3 / context.rise_K)),
                ((0.0, 0.03 / context.rise_K),),
            ),
            Form("bent", (c, bend), ((0.0, 0.0),), refines="specific heat"),
            Form("bent both", (c, bend, k), ((0.0, 0.0, 0.0),), refines=("bent", "both")),
        ),
    )
