"""Stiffness that falls, or rises, with temperature."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely


def entry(context: DataContext) -> Effect:
    """Return the effect: exponential in temperature; with three also its curvature, with four a step towards glass."""
    several = len(context.temperatures) > 1
    span = float(np.ptp(context.temperatures)) if several else 30.0
    linear = Constant("softening_1_K", 0.0, -5.0 / span, 5.0 / span, 0.1 / span)
    forms = [Form("exponential", (linear,), ((0.2 / span,), (-0.2 / span,)), ((0.02 / span,),))]
    bend = Constant("softening_1_K2", 0.0, -5.0 / span**2, 5.0 / span**2, 0.1 / span**2)
    if len(context.temperatures) > 2:
        forms.append(Form("curved", (linear, bend), ((0.2 / span, 0.05 / span**2),), refines="exponential"))
    if len(context.temperatures) > 3:
        low, high = float(np.min(context.temperatures)), float(np.max(context.temperatures))
        glass = (
            linear,
            Constant("step", 0.0, 0.0, 8.0, 0.2),
            Constant("at_degC", low + 0.3 * span, low - 0.5 * span, high, 0.1 * span),
            Constant("width_K", 0.1 * span, 0.02 * span, 0.5 * span, 0.05 * span),
        )
        colder = (0.05 / span, 1.0, low + 0.3 * span, 0.1 * span), (0.05 / span, 3.0, low, 0.15 * span)
        forms.append(Form("glass", glass, colder, colder[:1], refines=("exponential", "curved")))
    bends = len(context.temperatures) > 2
    curvature = bend if bends else fixed("softening_1_K2", 0.0)
    reach = fixed("reach", context.reach)
    more = [Constant(f"with_strain_{k}_1_K", 0.0, -5.0 / span, 5.0 / span, 0.1 / span) for k in (1, 2)]
    start = (context.reach, 0.2 / span, *3 * (0.0,))
    smooth = freely(forms, "smooth", (reach, linear, curvature, *more), start)
    return Effect(
        id="thermal-softening",
        title="stiffness changes with temperature",
        not_sought="" if several else "the tests state one temperature at most",
        rides_on=("temperature",),
        shown_by="the same pull at two temperatures 30 K or more apart",
        source="Ferry (1980), Viscoelastic Properties of Polymers, ch. 11",
        forms=(*forms, smooth),
    )
