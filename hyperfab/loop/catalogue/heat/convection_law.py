"""A film coefficient that grows with the temperature difference, as free convection does."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: ``h ~ (T - ambient)^n``; free convection has n from 1/4 to 1/3."""
    return Effect(
        id="convection-law",
        title="the film coefficient depends on the temperature difference in another way",
        not_sought="" if context.films else "no face has a film",
        rides_on=("above ambient_K",),
        shown_by="plateaus at three powers, and a cool-down with the power off",
        source="Churchill & Chu (1975), doi:10.1016/0017-9310(75)90243-4",
        forms=(
            Form(
                "power",
                (Constant("exponent", 0.0, -0.5, 1.0, 0.05, places=("exponent",)),),
                ((0.25,), (-0.15,)),
                ((0.05,),),
            ),
        ),
    )
