"""Foam whose pressure dies away while it is held: ``relaxation`` of foam.toml."""

from __future__ import annotations

from hyperfab.loop.catalogue.press import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a share of the pressure, and with readings over time its time."""
    share = Constant("share", 0.0, 0.0, 0.95, 0.03, places=("relaxation.share",))
    forms = [Form("share", (share,), ((0.2,), (0.5,)), ((0.05,),))]
    if context.timed:
        whole = context.time_s
        time = Constant(
            "time_s", 0.3 * whole, 1e-3 * whole, 30.0 * whole, 0.1 * whole, places=("relaxation.time_s",)
        )
        half = 0.3 * context.time_s
        forms += [
            Form(
                "in time", (share, time), ((0.2, half), (0.2, 0.1 * half)), ((0.05, half), (0.05, 0.1 * half))
            ),
            Form(
                "stretched",
                (share, time, Constant("power", 1.0, 0.2, 1.5, 0.1, places=("relaxation.power",))),
                ((0.2, half, 1.0),),
                refines="in time",
            ),
        ]
    return Effect(
        id="foam-relaxation",
        title="the foam's pressure relaxes",
        rides_on=("time_s",),
        shown_by="the force at a held gap over time",
        source="ISO 3385; one Maxwell branch, or Kohlrausch's stretched exponential",
        forms=tuple(forms),
        smooth=False,
        confounded_share=0.95,
        mimic_left=0.35,
    )
