"""Strain that stays when the load is gone."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely


def entry(context: DataContext) -> Effect:
    """Return the effect: a set seen on the way down, plastic flow as it happens, or a set from the second pull on."""
    share = Constant("set_share", 0.0, 0.0, 0.9, 0.02)

    def form(name: str) -> Form:
        return Form(name, (share,), ((0.04,), (0.15,)), ((0.01,),))

    power = Constant("power", 1.0, 0.2, 5.0, 0.3)
    plain = [form(name) for name in ("returned", "flow", "next-pull")]
    curved = [Form(f"{one.name}-power", (share, power), ((0.1, 1.4),), refines=one.name) for one in plain]
    reach = context.reach
    bend = Constant("bend", 0.0, -4.0 / reach, 8.0 / reach, 0.5 / reach)
    curved += [
        Form(f"{one.name}-bent", (share, bend), ((0.1, 1.0 / reach),), refines=one.name) for one in plain[:2]
    ]
    crept = Form(
        "crept",
        (share, Constant("strain", reach, 0.05 * reach, 50.0 * reach, reach)),
        ((0.1, reach),),
        ((0.01, 0.5 * reach), (0.01, 3.0 * reach)),
    )
    more = Form(
        "cycles", (share, Constant("power", 0.5, 0.0, 2.0, 0.3)), ((0.05, 0.5),), ((0.01, 0.2), (0.01, 1.0))
    )
    # The same with strains that add rather than stretches that multiply.
    sums = [
        Form(f"{one.name}-added", one.constants, one.starts, refines=one.name)
        for one in (plain[1], plain[2], crept, more)
    ]
    sums += [
        Form("flow-power-added", (share, power), ((0.1, 1.4),), refines=("flow-power", "flow-added")),
        Form("flow-bent-added", (share, bend), ((0.1, 1.0 / reach),), refines=("flow-bent", "flow-added")),
    ]
    network = form("network")
    bent = Form("network-power", (share, power), ((0.1, 0.7),), refines="network")
    forms = (*plain, *curved, crept, more, *sums, network, bent)
    sets = [Constant(f"set_{k}", 0.0, 0.0, 0.6 * reach, 0.01 * reach) for k in range(1, 4)]
    over = (Constant("strain", 0.1 * reach, 0.01 * reach, 50.0 * reach, reach), _slowly(context))
    start = (reach, 0.3 * reach, over[1].value, 0.02 * reach, 0.05 * reach, 0.1 * reach)
    smooth = freely(forms, "smooth", (fixed("reach", reach), *over, *sets), start)
    return Effect(
        id="permanent-set",
        title="part of the strain stays",
        not_sought="" if context.unloads else "no test unloads",
        rides_on=("cycle", "branch"),
        shown_by="unloading to zero force, a wait, and a second pull: the stretch at which force begins",
        source="ASTM D412 (tension set); Andrews, Tobolsky & Hanson (1946), doi:10.1063/1.1707724",
        forms=(*forms, smooth),
        smooth=True,
    )


def _slowly(context: DataContext) -> Constant:
    """Return the time over which a set creeps; none of it is known where the tests state no time."""
    if not context.path.knows_time:
        return fixed("creep_s", 1e9)
    whole = context.times[1]
    return Constant("creep_s", 100.0 * whole, 0.01 * whole, 1e4 * whole, whole)
