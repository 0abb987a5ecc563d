"""Threads that resist turning against each other: ``--shear-modulus``."""

from __future__ import annotations

from hyperfab.loop.catalogue.drape import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a shear modulus, added to the model's own; a membrane's law has its own shear."""
    modulus = Constant("modulus_MPa", 0.0, 0.0, context.shear, 0.02 * context.shear, places=("shear",))
    starts = ((0.1 * context.shear,), (0.5 * context.shear,))
    form = Form("linear", (modulus,), starts, ((0.03 * context.shear,),))
    return Effect(
        id="shear-stiffness",
        title="the fabric resists shear",
        rides_on=("x0_mm", "y0_mm"),
        shown_by="a bias test, cut at 45 degrees to the warp; or markers on the diagonals",
        source="energy of the angle between the threads, G gamma^2/2",
        forms=(form,) if context.shear else (),
        not_sought="" if context.shear else "the law of a membrane has its own shear",
    )
