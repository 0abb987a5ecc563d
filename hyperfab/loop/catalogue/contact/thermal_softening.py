"""Stiffness that falls, or rises, with temperature: ``temperatures`` of the material document, ``--temperature``."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.catalogue.contact import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: exponential in temperature; with three temperatures also its curvature."""
    away = max((abs(v - context.reference_degC) for v in context.temperatures), default=0.0)
    span = max(away, float(np.ptp(context.temperatures)) if context.temperatures else 0.0, 10.0)
    linear = Constant("softening_1_K", 0.0, -5.0 / span, 5.0 / span, 0.1 / span)
    bend = Constant("softening_1_K2", 0.0, -5.0 / span**2, 5.0 / span**2, 0.1 / span**2)
    forms = [Form("exponential", (linear,), ((0.2 / span,), (-0.2 / span,)), ((0.02 / span,),))]
    if len(context.temperatures) > 2:
        forms.append(Form("curved", (linear, bend), ((0.2 / span, 0.05 / span**2),), refines="exponential"))
    return Effect(
        id="thermal-softening",
        title="stiffness changes with temperature",
        not_sought="" if context.temperatures else "no file states its temperature",
        rides_on=("temperature_degC",),
        shown_by="the same test at two temperatures 30 K or more apart",
        source="Ferry (1980), Viscoelastic Properties of Polymers, ch. 11",
        forms=tuple(forms),
    )
