"""Foam that is softer when hot than where it was tested: a ``compression`` of several temperatures in foam.toml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.loop.catalogue.press import DataContext, PressEffect
from hyperfab.loop.press_reading import Changes
from hyperfab.loop.problem import HAS_IT, Constant, Form


@dataclass(frozen=True)
class FoamSoftening(PressEffect):
    """What it does to a press whose foam's law holds at ``law_degC``; the molds of the model are at ``molds_degC``."""

    law_degC: float = 20.0
    molds_degC: float = 20.0

    def left(self, temperature: float, at: Mapping[str, float]) -> float:
        """Return the share of the foam's stress that is left at a temperature [degC]."""
        above = temperature - self.law_degC
        return float(np.exp(-(at["softening_1_K"] + at.get("softening_1_K2", 0.0) * above) * above))

    def move(self, press: Changes, at: Mapping[str, float]) -> None:
        """Take from the foam's pressure what it is softer by when each reading is taken."""
        press.left.append(
            lambda reading: self.left(
                self.molds_degC if reading.warmth is None else reading.warmth.temperature, at
            )
        )


def entry(context: DataContext) -> PressEffect:
    """Return the effect: the stress goes exponentially with temperature."""
    law, met = context.foam.law_degC, context.temperatures
    reason = ""
    if law is None:
        reason = HAS_IT
    elif not context.foam.even:
        reason = (
            "the foam is not equally hot everywhere: leave out --dwell, and give both molds one temperature"
        )
    elif max(abs(one - law) for one in met) < 1.0:
        reason = "no reading was taken at another temperature than the foam's law holds at"
    far = max(abs(one - (law or 0.0)) for one in met) or 1.0
    rate = Constant("softening_1_K", 0.0, -2.0 / far, 4.0 / far, 0.05 / far)
    forms = [Form("exponential", (rate,), ((0.3 / far,), (1.0 / far,)), ((0.05 / far,),))]
    if len(met) > 2:
        bend = Constant("softening_1_K2", 0.0, -4.0 / far**2, 4.0 / far**2, 0.05 / far**2)
        forms.append(
            Form("curved", (rate, bend), ((0.3 / far, 0.0),), ((0.0, 0.05 / far**2),), "exponential")
        )
    return FoamSoftening(
        id="foam-softening",
        title="the foam is softer when it is hot",
        not_sought=reason,
        rides_on=("temperature_degC",),
        shown_by="force over stroke with the molds cold",
        source="an exponential of temperature",
        forms=tuple(forms),
        law_degC=20.0 if law is None else law,
        molds_degC=context.molds_degC,
    )
