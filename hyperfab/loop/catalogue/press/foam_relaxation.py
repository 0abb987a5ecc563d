"""Foam whose pressure dies away while it is held: ``relaxation`` of foam.toml."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes, Reading
from hyperfab.loop.problem import Constant, Form


class FoamRelaxation(PressEffect):
    """What it does to a press."""

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Let the pressure fade while it is held, or throughout where no time is known."""

        def left(reading: Reading) -> Array | float:
            if "time_s" not in at or reading.time_s is None:
                return 1.0 - at["share"]
            gone = np.expm1(-((reading.time_s / at["time_s"]) ** at.get("power", 1.0)))
            return np.asarray(1.0 + at["share"] * gone)

        press.left.append(left)


def entry(context: DataContext) -> PressEffect:
    """Return the effect: a share of the pressure, and with readings over time its time."""
    share = Constant("share", 0.0, 0.0, 0.95, 0.03)
    forms = [Form("share", (share,), ((0.2,), (0.5,)), ((0.05,),))]
    if context.timed:
        whole = context.time_s
        time = Constant("time_s", 0.3 * whole, 1e-3 * whole, 30.0 * whole, 0.1 * whole)
        half = 0.3 * context.time_s
        forms += [
            Form(
                "in time", (share, time), ((0.2, half), (0.2, 0.1 * half)), ((0.05, half), (0.05, 0.1 * half))
            ),
            Form(
                "stretched",
                (share, time, Constant("power", 1.0, 0.2, 1.5, 0.1)),
                ((0.2, half, 1.0),),
                refines="in time",
            ),
        ]
    return FoamRelaxation(
        id="foam-relaxation",
        title="the foam's pressure relaxes",
        rides_on=("time_s",),
        shown_by="the force at a held gap over time",
        source="ISO 3385; one Maxwell branch, or Kohlrausch's stretched exponential",
        forms=tuple(forms),
    )
