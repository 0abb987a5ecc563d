"""Softening below the largest stretch so far."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely


def entry(context: DataContext) -> Effect:
    """Return the effect: Ogden and Roxburgh's factor, with their beta, or damage by the largest stretch."""
    energy, reach = context.energy, context.reach
    amount = Constant("one_over_r", 0.0, 0.0, 0.98, 0.1)
    scale = Constant("m_MPa", 0.3 * energy, 0.002 * energy, 10.0 * energy, 0.3 * energy)
    forms = (
        Form(
            "pseudo-elastic",
            (amount, scale),
            ((0.2, 0.15 * energy), (0.3, 0.7 * energy)),
            ((0.03, 0.1 * energy), (0.03, 0.5 * energy)),
        ),
        Form(
            "pseudo-elastic-beta",
            (amount, scale, Constant("beta", 0.0, 0.0, 2.0, 0.1)),
            ((0.3, 0.2 * energy, 0.1),),
            refines="pseudo-elastic",
        ),
        Form(
            "strain",
            (Constant("amount", 0.0, 0.0, 0.98, 0.1), Constant("power", 1.0, 0.1, 6.0, 0.5)),
            ((0.3, 0.7), (0.3, 2.0)),
            ((0.03, 0.5), (0.03, 1.5)),
        ),
        Form(
            "strain-shape",
            (
                Constant("amount", 0.0, 0.0, 3.0, 0.1),
                Constant("power", 1.0, 0.1, 6.0, 0.5),
                Constant("outer", 1.0, 0.2, 4.0, 0.3),
                Constant("growth", 0.0, -1.0, 3.0, 0.3),
            ),
            ((0.3, 1.0, 0.9, 0.2),),
            refines="strain",
        ),
        Form(
            "strain-cycles",
            (
                Constant("amount", 0.0, 0.0, 0.98, 0.1),
                Constant("power", 1.0, 0.1, 6.0, 0.5),
                Constant("kept", 0.0, 0.0, 0.98, 0.2),
            ),
            ((0.3, 1.0, 0.3),),
            refines="strain",
        ),
        Form(
            "damage",
            (
                Constant("amount", 0.0, 0.0, 0.98, 0.1),
                Constant("strain", 0.5 * reach, 0.02 * reach, 20.0 * reach, reach),
            ),
            ((0.2, 0.3 * reach), (0.4, 2.0 * reach)),
            ((0.03, 0.3 * reach), (0.03, reach)),
        ),
        Form(
            "damage-power",
            (
                Constant("amount", 0.0, 0.0, 0.98, 0.1),
                Constant("strain", 0.5 * reach, 0.02 * reach, 20.0 * reach, reach),
                Constant("power", 1.0, 0.3, 5.0, 0.3),
            ),
            ((0.3, 0.5 * reach, 1.5),),
            refines="damage",
        ),
    )
    shape = (
        Constant("power", 1.0, 0.1, 6.0, 0.5),
        Constant("outer", 1.0, 0.2, 4.0, 0.3),
        Constant("kept", 0.0, 0.0, 0.98, 0.2),
    )
    deep = [Constant(f"depth_{k}", 0.0, -0.5, 2.0, 0.1) for k in range(1, 4)]
    lost = [Constant(f"lost_{k}", 0.0, -0.2, 0.9, 0.05) for k in range(1, 4)]
    begin = (reach, 1.0, 1.0, 0.1, 0.1, 0.15, 0.2, 0.0, 0.0, 0.0)
    smooth = freely(forms, "smooth", (fixed("reach", reach), *shape, *deep, *lost), begin)
    return Effect(
        id="mullins",
        title="softer after a first pull, up to the stretch it reached",
        not_sought="" if context.unloads else "no test unloads",
        rides_on=("cycle", "branch"),
        shown_by="two pulls to one stretch, then one beyond it: the second follows the first's way down",
        source="Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431; Simo (1987), doi:10.1016/0045-7825(87)90107-1",
        forms=(*forms, smooth),
        smooth=True,
    )
