"""A load cell off its zero."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a constant stress, and one that drifts with time."""
    peak = context.peak_stress
    offset = Constant("offset_MPa", 0.0, -0.5 * peak, 0.5 * peak, 0.01 * peak)
    forms = [Form("constant", (offset,), ((0.02 * peak,), (-0.02 * peak,)), ((0.01 * peak,),))]
    if context.path.knows_time:
        whole = context.times[1]
        drift = Constant("drift_MPa_s", 0.0, -peak / whole, peak / whole, 0.01 * peak / whole)
        forms.append(
            Form("drift", (offset, drift), ((0.01 * peak, 0.01 * peak / whole),), refines="constant")
        )
        tau = Constant("tau_s", 0.3 * whole, 0.01 * whole, 10.0 * whole, 0.3 * whole)
        rise = Constant("drift_MPa_s", 0.0, -50.0 * peak / whole, 50.0 * peak / whole, 0.05 * peak / whole)
        forms.append(
            Form(
                "settling",
                (offset, rise, tau),
                ((0.01 * peak, 0.05 * peak / whole, 0.2 * whole),),
                refines="constant",
            )
        )
    count = len(context.path.curves)
    if count > 1:
        own = [
            Constant(f"of_test_{k}_MPa", 0.0, -0.5 * peak, 0.5 * peak, 0.01 * peak)
            for k in range(2, count + 1)
        ]
        forms.append(
            Form(
                "each",
                (offset, *own),
                ((0.01 * peak, *(0.0 for _ in own)),),
                refines="constant",
                of_each=True,
            )
        )
    return Effect(
        id="load-offset",
        title="the load cell is off its zero",
        rides_on=("stretch",),
        shown_by="readings at rest, before the pull and after full unloading",
        source="ASTM E4 (zero of a testing machine)",
        forms=tuple(forms),
        smooth=True,
    )
