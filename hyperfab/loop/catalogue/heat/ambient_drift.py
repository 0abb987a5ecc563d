"""Surroundings that warm up or cool down during the run."""

from __future__ import annotations

from hyperfab.loop.catalogue.heat import DataContext
from hyperfab.loop.problem import Constant, Effect, Form

#: What the air of a room does: so far over a shift, with its doors, and so fast when it is heated or aired.
FARTHEST_K, FASTEST_K_S = 20.0, 0.01


def entry(context: DataContext) -> Effect:
    """Return the effect: ambient linear in time, quadratic, cubic."""
    whole = context.duration_s
    most = min(FARTHEST_K / whole, FASTEST_K_S)
    slope = Constant("drift_K_s", 0.0, -4.0 * most, 4.0 * most, 2.0 / whole, places=("ambient_per_s",))
    bend = Constant(
        "drift_K_s2", 0.0, -4.0 * most / whole, 4.0 * most / whole, 2.0 / whole**2, places=("ambient_per_s2",)
    )
    twist = Constant(
        "drift_K_s3",
        0.0,
        -8.0 * most / whole**2,
        8.0 * most / whole**2,
        2.0 / whole**3,
        places=("ambient_per_s3",),
    )
    return Effect(
        id="ambient-drift",
        title="the ambient changes with time",
        not_sought="" if context.films else "no face has a film",
        rides_on=("time_s",),
        shown_by="a thermometer in the air, away from the mold",
        source="Newton's law of cooling with a moving ambient",
        forms=(
            Form("linear", (slope,), ((8.0 / whole,), (-8.0 / whole,)), ((2.0 / whole,),)),
            Form("quadratic", (slope, bend), ((8.0 / whole, 0.0),), refines="linear"),
            Form("cubic", (slope, bend, twist), ((8.0 / whole, 0.0, 0.0),), refines="quadratic"),
        ),
    )
