"""What a fabric remembers whatever the pace: how far it was pulled before, and which way it goes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.loop.catalogue.fabric.context import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely, tried_if
from hyperfab.materials.effects.permanent_set import FORMS as SETS

#: Softening takes this share of the load at most, however near a specimen is to rest: one that bears none has a set.
MOST_TAKEN = 0.98


def hysteresis(context: DataContext) -> Effect:
    """A loop at one rate, of friction between yarns, or a pseudo-elastic loop that closes at each turn: friction that
    grows with the load, constant friction, a pseudo-elastic or a bent way down."""
    reach, peak, energy = context.reach, context.peak_stress, context.energy
    turn = Constant("turn_strain", 0.1 * reach, 0.002 * reach, 2.0 * reach, 0.1 * reach)
    again = Constant("turn_strain_2", 0.3 * reach, 0.002 * reach, 5.0 * reach, 0.1 * reach)
    rub = Constant("friction", 0.0, 0.0, 0.9, 0.1)
    rub_more = Constant("friction_2", 0.0, 0.0, 0.9, 0.1)
    dry = Constant("friction_MPa", 0.0, 0.0, peak, 0.05 * peak)
    dry_more = Constant("friction_2_MPa", 0.0, 0.0, peak, 0.05 * peak)
    stop = Constant("turn_MPa", 0.1 * peak, 0.002 * peak, 3.0 * peak, 0.1 * peak)
    stop_more = Constant("turn_2_MPa", 0.3 * peak, 0.002 * peak, 3.0 * peak, 0.1 * peak)
    amount = Constant("amount", 0.0, 0.0, 0.98, 0.1)
    work = Constant("energy_MPa", 0.3 * energy, 0.005 * energy, 10.0 * energy, 0.3 * energy)
    power = Constant("power", 1.0, 0.05, 6.0, 0.5)
    forms = (
        Form(
            "friction",
            (rub, turn),
            ((0.1, 0.05 * reach), (0.15, 0.3 * reach)),
            ((0.02, 0.03 * reach), (0.02, 0.15 * reach), (0.02, 0.5 * reach)),
        ),
        Form(
            "dry",
            (dry, turn),
            ((0.05 * peak, 0.05 * reach), (0.05 * peak, 0.3 * reach)),
            ((0.01 * peak, 0.03 * reach), (0.01 * peak, 0.15 * reach)),
        ),
        Form(
            "pseudo-elastic",
            (amount, work),
            ((0.2, 0.15 * energy), (0.3, 0.7 * energy)),
            ((0.03, 0.1 * energy), (0.03, 0.5 * energy)),
        ),
        Form("returning", (amount, power), ((0.2, 0.7), (0.3, 2.0)), ((0.03, 0.5), (0.03, 1.5))),
        Form(
            "friction-dry",
            (rub, turn, dry, again),
            ((0.1, 0.05 * reach, 0.02 * peak, 0.2 * reach),),
            refines="friction",
        ),
        Form(
            "friction-two",
            (rub, turn, rub_more, again),
            ((0.1, 0.05 * reach, 0.05, 0.3 * reach),),
            refines="friction",
        ),
        Form(
            "dry-two",
            (dry, turn, dry_more, again),
            ((0.05 * peak, 0.05 * reach, 0.03 * peak, 0.3 * reach),),
            refines="dry",
        ),
        Form(
            "stop",
            (dry, stop),
            ((0.05 * peak, 0.05 * peak), (0.05 * peak, 0.3 * peak)),
            ((0.01 * peak, 0.03 * peak), (0.01 * peak, 0.2 * peak)),
        ),
        Form(
            "stop-two",
            (dry, stop, dry_more, stop_more),
            ((0.05 * peak, 0.05 * peak, 0.03 * peak, 0.3 * peak),),
            refines="stop",
        ),
        Form("bent", (Constant("power", 0.0, 0.0, 5.0, 0.1),), ((0.3,), (1.0,)), ((0.05,),)),
    )
    shares = [Constant(f"share_{k}", 0.0, 0.0, 0.9, 0.1) for k in range(1, 5)]
    levels = [Constant(f"friction_{k}_MPa", 0.0, 0.0, peak, 0.05 * peak) for k in range(1, 5)]
    grow = [Constant(name, 0.0, -4.0, 4.0, 0.5) for name in ("growth", "widening")]
    yarns = (fixed("reach", reach), *shares, *levels, *grow)
    smooth = freely(forms, "smooth", yarns, (reach, *4 * (0.03,), *4 * (0.01 * peak,), 0.0, 0.0))
    return Effect(
        id="hysteresis",
        title="loading and unloading differ, whatever the rate",
        not_sought="" if context.unloads else "no test unloads",
        shown_by="three cycles to one amplitude at two rates: a loop of the same width every time",
        source="Dahl (1968), TOR-158; Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431",
        forms=(*forms, smooth, *each_way(context, smooth)),
        smooth=True,
    )


def mullins(context: DataContext) -> Effect:
    """Softening below the largest stretch so far: Ogden and Roxburgh's factor, with their beta, or damage by that
    stretch."""
    energy, reach = context.energy, context.reach
    one_over_r = Constant("one_over_r", 0.0, 0.0, MOST_TAKEN, 0.1)
    scale = Constant("m_MPa", 0.3 * energy, 0.002 * energy, 10.0 * energy, 0.3 * energy)
    beta = Constant("beta", 0.0, 0.0, 2.0, 0.1)
    amount = Constant("amount", 0.0, 0.0, MOST_TAKEN, 0.1)
    power = Constant("power", 1.0, 0.1, 6.0, 0.5)
    outer = Constant("outer", 1.0, 0.2, 4.0, 0.3)
    kept = Constant("kept", 0.0, 0.0, 0.98, 0.2)
    strain = Constant("strain", 0.5 * reach, 0.02 * reach, 20.0 * reach, reach)
    shape = (Constant("power", 1.0, 0.3, 5.0, 0.3),)
    way = Constant("way", reach, 0.02 * reach, 100.0 * reach, reach)
    wider = (Constant("amount", 0.0, 0.0, 3.0, 0.1), power, outer, Constant("growth", 0.0, -1.0, 3.0, 0.3))
    forms = (
        Form(
            "pseudo-elastic",
            (one_over_r, scale),
            ((0.2, 0.15 * energy), (0.3, 0.7 * energy)),
            ((0.03, 0.1 * energy), (0.03, 0.5 * energy)),
        ),
        Form(
            "pseudo-elastic-beta",
            (one_over_r, scale, beta),
            ((0.3, 0.2 * energy, 0.1),),
            refines="pseudo-elastic",
        ),
        Form("strain", (amount, power), ((0.3, 0.7), (0.3, 2.0)), ((0.03, 0.5), (0.03, 1.5))),
        Form("strain-shape", wider, ((0.3, 1.0, 0.9, 0.2),), refines="strain"),
        Form("strain-cycles", (amount, power, kept), ((0.3, 1.0, 0.3),), refines="strain"),
        Form(
            "damage",
            (amount, strain),
            ((0.2, 0.3 * reach), (0.4, 2.0 * reach)),
            ((0.03, 0.3 * reach), (0.03, reach)),
        ),
        Form(
            "damage-power",
            (amount, strain, *shape),
            ((0.3, 0.5 * reach, 1.5),),
            refines="damage",
        ),
        Form(
            "damage-way",
            (amount, strain, *shape, way),
            tuple((0.3, 0.5 * reach, 1.5, far * reach) for far in (0.3, 3.0)),
            refines=("damage", "damage-power"),
        ),
    )
    deep = [Constant(f"depth_{k}", 0.0, 0.0, 2.0, 0.1) for k in range(1, 4)]
    lost = [Constant(f"lost_{k}", 0.0, -0.2, 0.9, 0.05) for k in range(1, 4)]
    begin = (1.0, 1.0, 0.1, 0.1, 0.15, 0.2, 0.0, 0.0, 0.0)
    smooth = [
        freely(forms, name, (fixed(along, far), power, outer, kept, *deep, *lost), (far, *begin))
        for name, along, far in (("smooth", "reach", reach), ("smooth-energy", "reach_MPa", energy))
    ]
    return Effect(
        id="mullins",
        title="softer after a first pull, up to the stretch it reached",
        not_sought="" if context.unloads else "no test unloads",
        shown_by="two pulls to one stretch, then one beyond it: the second follows the first's way down",
        source="Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431; Simo (1987), doi:10.1016/0045-7825(87)90107-1",
        forms=(*forms, *smooth, *each_way(context, *smooth)),
        smooth=True,
    )


def permanent_set(context: DataContext) -> Effect:
    """Strain that stays when the load is gone: a set seen on the way down, plastic flow as it happens, or a set from
    the second pull on."""
    share = Constant("set_share", 0.0, 0.0, 0.9, 0.02)

    def form(name: str) -> Form:
        return Form(name, (share,), ((0.04,), (0.15,)), ((0.01,),))

    power = Constant("power", 1.0, 0.2, 5.0, 0.3)
    plain = [form(name) for name in ("returned", "flow", "next-pull")]
    curved = [Form(f"{one.name}-power", (share, power), ((0.1, 1.4),), refines=one.name) for one in plain]
    reach = context.reach
    bend = Constant("bend", 0.0, -4.0 / reach, 8.0 / reach, 0.5 / reach)
    curved += [Form(f"{one.name}-bent", (share, bend), ((0.1, 1.0 / reach),), refines=one.name) for one in plain[:2]]
    crept = Form(
        "crept",
        (share, Constant("strain", reach, 0.05 * reach, 50.0 * reach, reach)),
        ((0.1, reach),),
        ((0.01, 0.5 * reach), (0.01, 3.0 * reach)),
    )
    more = Form("cycles", (share, Constant("power", 0.5, 0.0, 2.0, 0.3)), ((0.05, 0.5),), ((0.01, 0.2), (0.01, 1.0)))
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
    fine = [Constant(f"set_{k}", 0.0, 0.0, 0.6 * reach, 0.01 * reach) for k in range(1, 6)]
    sets = fine[:3]
    over = (Constant("strain", 0.1 * reach, 0.01 * reach, 50.0 * reach, reach), _slowly(context))
    start = (0.3 * reach, over[1].value, 0.02 * reach, 0.05 * reach, 0.1 * reach)
    closer = tuple(share * reach for share in (0.01, 0.025, 0.045, 0.07, 0.1))
    smooth = [
        freely(forms, name, (fixed("reach", reach), *over, *sets), (reach, *start))
        for name in ("smooth", "smooth-flow")
    ]
    # One that begins late, or comes at once, bends more than thirds of the reach tell: then what flows shows too.
    smooth += [
        replace(
            freely(forms, f"{one.name}-close", (fixed("reach", reach), *over, *fine), (reach, *start[:2], *closer)),
            refines=(one.name, f"{other.name}-close"),
        )
        for one, other in (smooth, smooth[::-1])
    ]
    smooth.append(freely(forms, "smooth-returned", (fixed("reach", reach), *fine), (reach, *closer)))
    # A sheet pulled both ways bears more at the same strain.
    pull = 1.0 + reach - (1.0 + reach) ** -2.0
    by_load = [
        freely(forms, f"{name}-load", (fixed("reach_of_load", pull), *over, *sets), (pull, *start))
        for name in ("smooth", "smooth-flow")
    ]
    by_load.append(freely(forms, "smooth-returned-load", (fixed("reach_of_load", pull), *fine), (pull, *closer)))
    return Effect(
        id="permanent-set",
        title="part of the strain stays",
        not_sought="" if context.unloads else "no test unloads",
        shown_by="unloading to zero force, a wait, and a second pull: the stretch at which force begins",
        source="ASTM D412 (tension set); Andrews, Tobolsky & Hanson (1946), doi:10.1063/1.1707724",
        forms=tuple(_contracting(context, form) for form in (*forms, *smooth, *each_way(context, *by_load))),
        smooth=True,
    )


def _contracting(context: DataContext, form: Form) -> Form:
    """Return a set that contracts the strip as a pull to its length does, to a power: 0 is not at all.

    Where nobody measured across, nothing is known of it but by the section that is left, which a formula takes for that
    of what has flowed, and a smooth law finds.
    """
    if form.name not in SETS:
        return form
    told = context.transverse or (form.free and SETS[form.name].flows)
    width = Constant("contraction", 1.0, 0.0, 1.5, 0.2) if told else fixed("contraction", 1.0)
    powers = (1.0, 0.0) if context.transverse else (1.0,)
    return replace(
        form,
        constants=(*form.constants, width),
        starts=tuple((*one, 1.0) for one in form.starts),
        probes=tuple((*one, power) for power in powers for one in form.probes),
    )


def each_way(context: DataContext, *smooth: Form) -> list[Form]:
    """Return smooth laws of which there is more in one direction or mode than in another.

    They are tried where several are tested, and let go again: on the way out alone that is a stiffness of each.
    """
    several, modes = len(context.angles) > 1, len(np.unique(context.path.mode)) > 1
    weft = Constant("weft", 0.0, -0.95, 5.0, 0.3) if several else fixed("weft", 0.0)
    more = Constant("modes", 0.0, -3.0, 3.0, 0.5) if modes else fixed("modes", 0.0)
    found = [
        Form(
            f"{one.name}-each-way",
            (*one.constants, weft, more),
            ((*one.starts[0], 0.0, 0.0),),
            refines=(one.name, *one.simpler),
            free=True,
        )
        for one in smooth
    ]
    return tried_if(context.unloads and (several or modes), *found)


def _slowly(context: DataContext) -> Constant:
    """Return the time over which a set creeps; none of it is known where the tests state no time."""
    if not context.path.knows_time:
        return fixed("creep_s", 1e9)
    whole = context.times[1]
    return Constant("creep_s", 100.0 * whole, 0.01 * whole, 1e4 * whole, whole)
