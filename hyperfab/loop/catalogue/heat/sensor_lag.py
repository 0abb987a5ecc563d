"""Thermocouples that follow late: ``lag`` of a probe."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form


def entry(context: DataContext) -> Effect:
    """Return the effect: a first-order lag of all probes; one each; or two in a row, of sheath and sensor."""
    lag = Constant("lag_s", 0.0, 0.0, 0.2 * context.duration_s, 0.01 * context.duration_s, places=("lag_s",))
    starts = ((0.01 * context.duration_s,), (0.04 * context.duration_s,))
    most, step = 0.2 * context.duration_s, 0.005 * context.duration_s
    second = Constant("second_lag_s", 0.0, 0.0, most, step, places=("second_lag_s",))
    own = [
        Constant(f"of_probe_{k}_s", 0.0, -most, most, step, places=(f"lag_s.{k - 1}",))
        for k in range(2, context.probes + 1)
    ]
    richer = [Form("two-stage", (lag, second), ((0.01 * context.duration_s,) * 2,), refines="first-order")]
    if own:
        start = (0.01 * context.duration_s, *(0.0 for _ in own))
        richer.append(Form("each", (lag, *own), (start,), refines="first-order"))
    return Effect(
        id="sensor-lag",
        title="the sensors lag behind the metal",
        rides_on=("heating rate_K_s",),
        shown_by="a step of power sampled closely, with a probe of known quick response beside",
        source="first-order lag; ASTM E839",
        forms=(
            Form(
                "first-order", (lag,), starts, ((0.002 * context.duration_s,), (0.02 * context.duration_s,))
            ),
            *richer,
        ),
    )
