"""How a specimen was held and its force read: what the grips and the load cell add."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.loop.catalogue.fabric.context import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely, tried_if

#: A load cell is off its zero by this share of the largest stress at most: more is no reading of a specimen.
MOST_OFF = 0.5


def grip_slack(context: DataContext) -> Effect:
    """What the grips take of the extension: play, with or without a rounded end, or what gives with the load.

    A specimen may have been mounted taut, and cloth may slip out of the grips for good.
    """
    reach = context.reach_of_grips
    low, high, step = -0.1 * reach, 0.6 * reach, 0.02 * reach
    slack = Constant("slack", 0.0, low, high, step)
    starts = ((0.03 * reach,), (0.1 * reach,), (-0.02 * reach,))
    forms = [Form("play", (slack,), starts, ((0.005 * reach,),))]
    count = len(context.path.curves)
    own = [Constant(f"of_test_{k}", 0.0, -0.3 * reach, high, step, curve=k - 1) for k in range(2, count + 1)]
    each = Form("each", (slack, *own), ((0.03 * reach, *(0.0 for _ in own)),), refines="play", of_each=True)
    forms += tried_if(count > 1, _alone(context, each, 0.005 * reach))
    toe = Constant("toe", 0.0, 0.0, high, step)
    forms.append(Form("toe", (slack, toe), ((0.03 * reach, 0.03 * reach),), refines="play"))
    # Play of each its own ends as roundly as that of all, or the more so the more it is, of strips mounted askew.
    for name, end, begin in (("toe", toe, 0.03 * reach), ("askew", Constant("width", 0.0, 0.0, 4.0, 0.3), 1.0)):
        whole, start = (*each.constants, end), (*each.starts[0], begin)
        rounded = Form(f"each-{name}", whole, (start,), refines=("toe", "each"), of_each=True, shared=1)
        forms += tried_if(count > 1, rounded)
    peak = context.peak_stress
    told_to = fixed("peak_MPa", peak)
    give = Constant("give", 0.0, 0.0, high, step)
    little = 0.005 * reach
    curve = Constant("curve", 0.0, 0.0, 8.0, 1.0)
    by_load = [
        Form("yields", (told_to, give), ((peak, 0.05 * reach),), ((peak, little),)),
        Form("yields-curved", (told_to, give, curve), ((peak, 0.05 * reach, 2.0),), refines="yields"),
    ]
    # Give by the load bends all curves alike, as a law of threads that is too straight would: strips cut at an angle
    # are never free of that.
    told = not len(context.slanted)
    forms += tried_if(told, *by_load)
    holds = Constant("holds_MPa", 0.2 * peak, 0.0, 0.95 * peak, 0.05 * peak)
    beginnings = tuple((peak, 0.05 * reach, share * peak) for share in (0.1, 0.5))
    slips = Form("slips", (told_to, replace(give, high=5.0 * high), holds), beginnings, ((peak, little, 0.2 * peak),))
    forms += tried_if(context.unloads, slips)
    # A specimen may be mounted taut, but no grip goes against the load: one that does is another law of the threads.
    gives = [Constant(f"give_{k}", 0.0, 0.0, high, step) for k in range(1, 7)]
    smooth, by_force, by_slip = (
        freely(forms, name, (along, *gives), (along.value, *6 * (0.03 * reach,)))
        for name, along in (("smooth", fixed("reach", reach)), ("smooth-force", told_to), ("smooth-slip", told_to))
    )
    return Effect(
        id="grip-slack",
        title="the grips take up part of the extension",
        not_sought="the stretch was read on the specimens themselves" if context.on_specimen else "",
        shown_by="the stretch from marks on the specimen beside that of the grips, close readings at the start",
        source="ASTM D638, annex A1 (toe compensation)",
        forms=(*forms, smooth, *tried_if(told, by_force), *tried_if(context.unloads, by_slip)),
        smooth=True,
    )


def load_offset(context: DataContext) -> Effect:
    """A load cell off its zero: by a constant stress, or one that drifts with time."""
    peak = context.peak_stress
    most, step = MOST_OFF * peak, 0.01 * peak
    offset = Constant("offset_MPa", 0.0, -most, most, step)
    forms = [Form("constant", (offset,), ((0.02 * peak,), (-0.02 * peak,)), ((step,),))]
    if context.path.knows_time:
        whole = context.times[1]
        # In pulls at one pace alone time goes on as the stretch does: what drifts is another law.
        told = context.unloads or context.several_rates
        drift = Constant("drift_MPa_s", 0.0, -peak / whole, peak / whole, 0.01 * peak / whole)
        drifting = Form("drift", (offset, drift), ((step, 0.01 * peak / whole),), refines="constant")
        tau = Constant("tau_s", 0.3 * whole, 0.01 * whole, 10.0 * whole, 0.3 * whole)
        rise = Constant("drift_MPa_s", 0.0, -50.0 * peak / whole, 50.0 * peak / whole, 0.05 * peak / whole)
        start = (step, 0.05 * peak / whole, 0.2 * whole)
        settling = Form("settling", (offset, rise, tau), (start,), refines="constant")
        drifts = [Constant(f"drift_{k}_MPa", 0.0, -most, most, step) for k in range(1, 4)]
        free = (fixed("whole_s", whole), offset, *drifts)
        smooth = freely((*forms, drifting, settling), "smooth", free, (whole, step, *3 * (0.0,)))
        forms += tried_if(told, drifting, settling, smooth)
    count = len(context.path.curves)
    own = [Constant(f"of_test_{k}_MPa", 0.0, -most, most, step, curve=k - 1) for k in range(2, count + 1)]
    begin = (step, *(0.0 for _ in own))
    each = Form("each", (offset, *own), (begin,), refines="constant", of_each=True)
    forms += tried_if(count > 1, _alone(context, each, step))
    if context.path.knows_time:
        most = 0.5 * MOST_OFF * peak
        drifts = [Constant(f"drift_of_{k}_MPa", 0.0, -most, most, step, curve=k - 1) for k in range(1, count + 1)]
        begin = (*begin, *(0.0 for _ in drifts))
        drifting = freely(forms, "each-drift", (offset, *own, *drifts), begin)
        warming = freely([drifting], "each-settling", (*drifting.constants, tau), (*begin, tau.value))
        # On the way out alone a drift in time is a softer or stiffer specimen.
        forms += tried_if(count > 1 and context.unloads, drifting, warming)
    return Effect(
        id="load-offset",
        title="the load cell is off its zero",
        shown_by="readings at rest, before the pull and after full unloading",
        source="ASTM E4 (zero of a testing machine)",
        forms=tuple(forms),
        smooth=True,
    )


def _alone(context: DataContext, each: Form, size: float) -> Form:
    """Return a form with a constant for each specimen: of those led alike one that needs no simpler form before it.

    They show it in what each alone differs by, of a ``size``: that of the first is what all others have less.
    """
    if not context.replicated:
        return each
    count = len(each.constants)
    alone = np.vstack([np.where(np.arange(count) == 0, 1.0, -1.0), np.eye(count)[1:]])
    return replace(each, probes=tuple(map(tuple, size * alone)), refines=None)
