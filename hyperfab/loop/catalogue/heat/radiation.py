"""Heat radiated to the surroundings: ``[[radiation]]`` of the mold document."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import HAS_IT, Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a grey emissivity of the faces that have a film, to surroundings as warm as the air or not."""
    reason = HAS_IT if context.emits else "" if context.films else "no face has a film"
    emissivity = Constant("emissivity", 0.0, 0.0, 1.0, 0.1, places=("emissivity",))
    surroundings = Constant("surroundings_K", 0.0, -40.0, 40.0, 2.0, 8.0, ("surroundings_K",))
    return Effect(
        id="radiation",
        title="the mold radiates to its surroundings",
        not_sought=reason,
        rides_on=("temperature_degC",),
        shown_by="a plateau at twice the temperature rise, and a cool-down with the power off",
        source="Stefan-Boltzmann law",
        forms=(
            Form("grey", (emissivity,), ((0.3,), (0.8,)), ((0.1,),)),
            Form("other surroundings", (emissivity, surroundings), ((0.3, 0.0),), refines="grey"),
        ),
    )
