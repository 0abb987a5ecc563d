"""A level or loop that moves with the rate: stress that relaxes."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely


def entry(context: DataContext) -> Effect:
    """Return the effect: one Maxwell branch, two, or stiffness with the logarithm of the rate."""
    step, whole = context.times
    peak = context.peak_stress
    low, high = 0.2 * step, 20.0 * whole
    times = [float(t) for t in np.geomspace(2.0 * step, 0.5 * whole, 4)]

    def branch(k: int, start: float) -> tuple[Constant, Constant]:
        return Constant(f"g{k}", 0.0, 0.0, 20.0, 0.1), Constant(f"tau{k}_s", start, low, high, start)

    three = branch(3, times[3])
    measure = Constant("measure", 0.0, -4.0, 4.0, 1.0)
    power = Constant("power", 1.0, 1.0, 8.0, 0.5)
    # Of power, time and stress level one is free to choose: the level.
    level = Constant("flow_MPa", 0.1 * peak, 0.1 * peak, 0.1 * peak, 0.1 * peak)
    bend = Constant("bend", 0.0, -8.0, 8.0, 1.0)
    one, two = branch(1, times[1]), branch(2, times[2])
    reason = "" if context.shows_rate else "the tests have one rate, no hold and no way back"
    if not context.path.knows_time:
        reason = "not every test states its times or its rate"
    forms = (
        Form(
            "prony-1",
            one,
            tuple((0.3, t) for t in (times[0], times[1], times[3])),
            tuple((0.02, t) for t in times),
        ),
        Form(
            "prony-2",
            (*one, *two),
            ((0.2, times[0], 0.2, times[3]), (0.2, times[0], 0.1, times[1])),
            refines="prony-1",
        ),
        Form(
            "prony-3",
            (*one, *two, *three),
            ((0.2, times[0], 0.2, times[2], 0.1, times[3]),),
            refines="prony-2",
        ),
        Form("prony-bent", (*one, bend), ((0.3, times[1], 0.5),), refines="prony-1"),
        Form(
            "prony-2-bent",
            (*one, bend, *two),
            ((0.2, times[0], 0.5, 0.2, times[2]), (0.2, times[0], 0.5, 0.2, times[0])),
            refines=("prony-bent", "prony-2"),
        ),
        Form(
            "prony-3-bent",
            (*one, bend, *two, *three),
            ((0.2, times[0], 0.5, 0.2, times[2], 0.2, times[3]),),
            refines=("prony-2-bent", "prony-3"),
        ),
        Form(
            "thinning",
            (*one, Constant("flow_MPa", 100.0 * peak, 0.005 * peak, 100.0 * peak, 0.2 * peak)),
            ((0.5, times[1], 0.15 * peak), (0.5, times[2], 0.15 * peak)),
            refines="prony-1",
        ),
        Form(
            "thinning-prony",
            (*one, Constant("flow_MPa", 100.0 * peak, 0.005 * peak, 100.0 * peak, 0.2 * peak), *two),
            ((0.5, times[1], 0.15 * peak, 0.1, times[3]),),
            refines=("thinning", "prony-2"),
        ),
        Form(
            "thinning-bent",
            (*one, Constant("flow_MPa", 100.0 * peak, 0.005 * peak, 100.0 * peak, 0.2 * peak), bend),
            ((0.5, times[1], 0.15 * peak, 0.5),),
            refines="thinning",
        ),
        Form("flow", (*one, power, level), ((0.5, times[1], 2.5, 0.1 * peak),), refines="prony-1"),
        Form(
            "flow-strain",
            (*one, power, level, Constant("strain", 0.0, -1.5, 1.5, 0.2)),
            ((0.5, times[1], 2.5, 0.1 * peak, -0.3),),
            refines=("flow", "thinning", "thinning-bent"),
        ),
        Form("prony-measure", (*one, measure), ((0.3, times[1], 0.5),), refines="prony-1"),
        Form(
            "prony-2-measure",
            (*one, measure, *two),
            ((0.2, times[0], 0.5, 0.2, times[2]),),
            refines=("prony-measure", "prony-2"),
        ),
        Form(
            "viscous",
            (
                Constant("viscous_MPa", 0.0, 0.0, peak, 0.05 * peak),
                Constant("power", 0.5, 0.2, 2.0, 0.2),
            ),
            ((0.05 * peak, 0.3), (0.05 * peak, 1.0)),
            ((0.01 * peak, 0.3), (0.01 * peak, 1.0)),
        ),
        Form("log-rate", (Constant("amount", 0.0, -0.5, 0.5, 0.02),), ((0.05,),), ((0.01,),)),
    )
    ends = (fixed("first_s", 0.5 * step), fixed("last_s", whole))
    clock = (
        Constant("bend", 0.0, -8.0, 8.0, 1.0),
        Constant("quick", 0.0, -6.0 / context.reach, 12.0 / context.reach, 1.0),
    )
    shares = [Constant(f"g_{k}", 0.0, 0.0, 20.0, 0.1) for k in range(1, 7)]
    smooth = freely(forms, "smooth", (*ends, *clock, *shares), (0.5 * step, whole, 0.0, 0.0, *6 * (0.1,)))
    return Effect(
        id="rate",
        title="stress depends on the rate",
        not_sought=reason,
        rides_on=("rate", "time"),
        shown_by="the same cycle at two rates a factor of 16 apart, and a hold of the stretch",
        source="Fung (1981), Biomechanics, ch. 7; Taylor, Pister & Goudreau (1970), doi:10.1002/nme.1620020106; "
        "Bergstrom & Boyce (1998), doi:10.1016/S0022-5096(97)00075-6",
        forms=(*forms, smooth),
        smooth=True,
    )
