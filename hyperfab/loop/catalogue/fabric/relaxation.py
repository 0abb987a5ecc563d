"""What a fabric does with time: stress that relaxes, by branches of many makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hyperfab.loop.catalogue.fabric.context import DataContext
from hyperfab.loop.catalogue.fabric.history import each_way
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely, tried_if


def rate(context: DataContext) -> Effect:
    """A level or loop that moves with the rate, of stress that relaxes: one Maxwell branch, two or three, or stiffness
    with the logarithm of the rate."""
    step, whole = context.times
    peak = context.peak_stress
    # A branch that hardly relaxes in the longest test is a spring, and its bend another law.
    low, high = 0.2 * step, 2.0 * whole
    t1, t2, t3, t4 = times = tuple(float(t) for t in np.geomspace(2.0 * step, 0.5 * whole, 4))

    def branch(k: int, start: float) -> tuple[Constant, Constant]:
        return Constant(f"g{k}", 0.0, 0.0, 20.0, 0.1), Constant(f"tau{k}_s", start, low, high, start)

    one, two, three = branch(1, t2), branch(2, t3), branch(3, t4)
    measure = Constant("measure", 0.0, -4.0, 4.0, 1.0)
    power = Constant("power", 1.0, 1.0, 8.0, 0.5)
    # One that flows the faster the more it bears may be as slow as it likes at rest.
    flows = one[0], replace(one[1], high=20.0 * whole)
    thins = Constant("flow_MPa", 100.0 * peak, 0.005 * peak, 100.0 * peak, 0.2 * peak)
    # Of power, time and stress level one is free to choose: the level.
    level = Constant("flow_MPa", 0.1 * peak, 0.1 * peak, 0.1 * peak, 0.1 * peak)
    with_strain = Constant("strain", 0.0, -1.5, 1.5, 0.2)
    bend = Constant("bend", 0.0, -8.0, 8.0, 1.0)
    spring = 0.1 * peak / context.reach
    series = tuple(
        constant
        for k, (_, time) in enumerate((one, two), 1)
        for constant in (Constant(f"mu{k}_MPa", 0.0, 0.0, 100.0 * spring, spring), time)
    )
    viscous = Constant("viscous_MPa", 0.0, 0.0, peak, 0.05 * peak)
    reason = ""
    if not (context.unloads or context.several_rates):
        several = " of a direction" if len(context.paces) > 1 else ""
        reason = f"the tests{several} have one rate, no hold and no way back"
    if not context.path.knows_time:
        reason = "not every test states its times or its rate"
    forms: tuple[Form, ...] = (
        Form("prony-1", one, tuple((0.3, t) for t in (t1, t2, t4)), tuple((0.02, t) for t in times)),
        Form(
            "prony-2",
            (*one, *two),
            ((0.2, t1, 0.2, t4), (0.2, t1, 0.1, t2)),
            refines="prony-1",
        ),
        Form("prony-3", (*one, *two, *three), ((0.2, t1, 0.2, t3, 0.1, t4),), refines="prony-2"),
        Form("prony-bent", (*one, bend), ((0.3, t2, 0.5),), refines="prony-1"),
        Form(
            "prony-2-bent",
            (*one, bend, *two),
            ((0.2, t1, 0.5, 0.2, t3), (0.2, t1, 0.5, 0.2, t1)),
            refines=("prony-bent", "prony-2"),
        ),
        Form(
            "prony-3-bent",
            (*one, bend, *two, *three),
            ((0.2, t1, 0.5, 0.2, t3, 0.2, t4),),
            refines=("prony-2-bent", "prony-3"),
        ),
        Form(
            "thinning",
            (*flows, thins),
            ((0.5, t2, 0.15 * peak), (0.5, t3, 0.15 * peak)),
            refines="prony-1",
        ),
        Form(
            "thinning-prony",
            (*flows, thins, *two),
            ((0.5, t2, 0.15 * peak, 0.1, t4),),
            refines=("thinning", "prony-2"),
        ),
        Form("thinning-bent", (*flows, thins, bend), ((0.5, t2, 0.15 * peak, 0.5),), refines="thinning"),
        Form("flow", (*flows, power, level), ((0.5, t2, 2.5, 0.1 * peak),), refines="prony-1"),
        Form(
            "flow-strain",
            (*flows, power, level, with_strain),
            ((0.5, t2, 2.5, 0.1 * peak, -0.3),),
            refines=("flow", "thinning", "thinning-bent"),
        ),
        Form("finite", series[:2], ((spring, t2), (spring, t4)), refines="prony-1"),
        Form(
            "finite-2",
            series,
            ((spring, t1, spring, t3), (spring, t2, spring, t4)),
            refines=("finite", "prony-2", "prony-bent", "prony-measure", "thinning", "flow", "flow-strain"),
        ),
        Form("prony-measure", (*one, measure), ((0.3, t2, 0.5),), refines="prony-1"),
        Form(
            "prony-2-measure",
            (*one, measure, *two),
            ((0.2, t1, 0.5, 0.2, t3),),
            refines=("prony-measure", "prony-2"),
        ),
        Form(
            "viscous",
            (viscous, Constant("power", 0.5, 0.2, 2.0, 0.2)),
            ((0.05 * peak, 0.3), (0.05 * peak, 1.0)),
            ((0.01 * peak, 0.3), (0.01 * peak, 1.0)),
        ),
        Form("log-rate", (Constant("amount", 0.0, -0.5, 0.5, 0.02),), ((0.05,),), ((0.01,),)),
    )
    # Of few branches the times are where they are, not at even parts between ends that are given.
    first, last = 0.5 * step, whole
    middle = float(np.sqrt(first * last))
    ends = Constant("first_s", first, 0.1 * first, middle, first), Constant("last_s", last, middle, 10.0 * last, last)
    quick = Constant("quick", 0.0, -6.0 / context.reach, 12.0 / context.reach, 1.0)
    start = (0.5 * step, whole, 0.0, 0.0, *6 * (0.1,))
    frees = [freely(forms, "smooth", (*ends, bend, quick, *_shares(6)), start)]
    frees += each_way(context, *frees)
    paces = context.paces
    slow, fast = (float(paces[0]), float(paces[-1])) if len(paces) > 2 else (1.0 / whole, 1.0 / step)
    more = [Constant(f"more_{k}", 0.0, -0.9, 9.0, 0.05) for k in range(1, 4)]
    by_rate = (fixed("slowest_1_s", slow), fixed("fastest_1_s", fast), *more)
    frees += tried_if(len(paces) > 2, freely(forms, "log-rate-smooth", by_rate, (slow, fast, 0.05, 0.1, 0.15)))
    shifted, free = _by_the_clock_of_the_material(context, forms, frees[0])
    # Of two temperatures, or where times are told at one alone, a shift and a softening tell the same.
    told = len(context.temperatures) > 2 and context.clocks > 1
    forms, frees = (*forms, *tried_if(told, *shifted)), frees + tried_if(told, free)
    return Effect(
        id="rate",
        title="stress depends on the rate",
        not_sought=reason,
        shown_by="the same cycle at two rates a factor of 16 apart, and a hold of the stretch",
        source="Fung (1981), Biomechanics, ch. 7; Taylor, Pister & Goudreau (1970), doi:10.1002/nme.1620020106; "
        "Bergstrom & Boyce (1998), doi:10.1016/S0022-5096(97)00075-6; Reese & Govindjee (1998), "
        "doi:10.1016/S0020-7683(97)00217-5; Williams, Landel & Ferry (1955), "
        "doi:10.1021/ja01619a008",
        forms=(*forms, *frees),
        smooth=True,
    )


def _shares(count: int, most: float = 20.0) -> list[Constant]:
    """Return the shares of the branches of a spectrum."""
    return [Constant(f"g_{k}", 0.0, 0.0, most, 0.1) for k in range(1, count + 1)]


def _by_the_clock_of_the_material(context: DataContext, forms: Sequence[Form], free: Form) -> tuple[list[Form], Form]:
    """Return Maxwell branches, and the spectrum ``free``, whose times shift with temperature."""
    kelvin = 273.15 + (float(np.mean(context.temperatures)) if len(context.temperatures) else 20.0)
    clock = Constant("shift_1_K", 0.0, 0.0, 1.0, 0.02), Constant("fall_K", kelvin, 20.0, 2000.0, 50.0)
    # At the reference times may be as much shorter or longer than the tests as the shift makes them elsewhere, and from
    # a rubber to its glass is a factor of a thousand and more in stiffness.
    widest, glass = 1e4, 1e4

    def wider(one: Constant) -> Constant:
        if one.name.startswith("tau"):
            return replace(one, low=one.low / widest, high=one.high * widest)
        return replace(one, high=glass) if one.name.startswith("g") else one

    def shifted(name: str) -> Form:
        plain = next(form for form in forms if form.name == name)
        simpler = {"prony-2": "prony-1", "prony-3": "prony-2", "prony-3-bent": "prony-2-bent"}
        before = (f"{simpler[name]}-shifted",) if name in simpler else ()
        return Form(
            f"{name}-shifted",
            (*map(wider, plain.constants), *clock),
            tuple((*plain.starts[0], shift, fall) for shift, fall in ((0.05, kelvin), (0.2, kelvin), (0.15, 100.0))),
            refines=(name, *before),
        )

    names = ("prony-1", "prony-2", "prony-3", "prony-2-bent", "prony-3-bent")
    ends = [fixed(one.name, one.value * by) for one, by in zip(free.constants[:2], (1e-4, 1e3), strict=True)]
    start = (ends[0].value, ends[1].value, 0.0, 0.0, *10 * (0.1,), 0.15, 100.0)
    found = [shifted(name) for name in names]
    spectrum = (*ends, *free.constants[2:4], *_shares(10, glass), *clock)
    return found, freely((*forms, *found), "smooth-shifted", spectrum, start)
