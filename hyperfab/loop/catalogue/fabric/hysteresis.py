"""A loop at one rate: friction between yarns, or a pseudo-elastic loop that closes at each turn."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely


def entry(context: DataContext) -> Effect:
    """Return the effect: friction that grows with the load, constant friction, a pseudo-elastic or a bent way down."""
    reach, peak, energy = context.reach, context.peak_stress, context.energy
    turn = Constant("turn_strain", 0.1 * reach, 0.002 * reach, 2.0 * reach, 0.1 * reach)
    again = Constant("turn_strain_2", 0.3 * reach, 0.002 * reach, 5.0 * reach, 0.1 * reach)
    forms = (
        Form(
            "friction",
            (Constant("friction", 0.0, 0.0, 0.9, 0.1), turn),
            ((0.1, 0.05 * reach), (0.15, 0.3 * reach)),
            ((0.02, 0.03 * reach), (0.02, 0.15 * reach), (0.02, 0.5 * reach)),
        ),
        Form(
            "dry",
            (Constant("friction_MPa", 0.0, 0.0, peak, 0.05 * peak), turn),
            ((0.05 * peak, 0.05 * reach), (0.05 * peak, 0.3 * reach)),
            ((0.01 * peak, 0.03 * reach), (0.01 * peak, 0.15 * reach)),
        ),
        Form(
            "pseudo-elastic",
            (
                Constant("amount", 0.0, 0.0, 0.98, 0.1),
                Constant("energy_MPa", 0.3 * energy, 0.005 * energy, 10.0 * energy, 0.3 * energy),
            ),
            ((0.2, 0.15 * energy), (0.3, 0.7 * energy)),
            ((0.03, 0.1 * energy), (0.03, 0.5 * energy)),
        ),
        Form(
            "returning",
            (Constant("amount", 0.0, 0.0, 0.98, 0.1), Constant("power", 1.0, 0.05, 6.0, 0.5)),
            ((0.2, 0.7), (0.3, 2.0)),
            ((0.03, 0.5), (0.03, 1.5)),
        ),
        Form(
            "friction-dry",
            (
                Constant("friction", 0.0, 0.0, 0.9, 0.1),
                turn,
                Constant("friction_MPa", 0.0, 0.0, peak, 0.05 * peak),
                again,
            ),
            ((0.1, 0.05 * reach, 0.02 * peak, 0.2 * reach),),
            refines="friction",
        ),
        Form(
            "friction-two",
            (
                Constant("friction", 0.0, 0.0, 0.9, 0.1),
                turn,
                Constant("friction_2", 0.0, 0.0, 0.9, 0.1),
                again,
            ),
            ((0.1, 0.05 * reach, 0.05, 0.3 * reach),),
            refines="friction",
        ),
        Form(
            "dry-two",
            (
                Constant("friction_MPa", 0.0, 0.0, peak, 0.05 * peak),
                turn,
                Constant("friction_2_MPa", 0.0, 0.0, peak, 0.05 * peak),
                again,
            ),
            ((0.05 * peak, 0.05 * reach, 0.03 * peak, 0.3 * reach),),
            refines="dry",
        ),
        Form(
            "stop",
            (
                Constant("friction_MPa", 0.0, 0.0, peak, 0.05 * peak),
                Constant("turn_MPa", 0.1 * peak, 0.002 * peak, 3.0 * peak, 0.1 * peak),
            ),
            ((0.05 * peak, 0.05 * peak), (0.05 * peak, 0.3 * peak)),
            ((0.01 * peak, 0.03 * peak), (0.01 * peak, 0.2 * peak)),
        ),
        Form(
            "stop-two",
            (
                Constant("friction_MPa", 0.0, 0.0, peak, 0.05 * peak),
                Constant("turn_MPa", 0.1 * peak, 0.002 * peak, 3.0 * peak, 0.1 * peak),
                Constant("friction_2_MPa", 0.0, 0.0, peak, 0.05 * peak),
                Constant("turn_2_MPa", 0.3 * peak, 0.002 * peak, 3.0 * peak, 0.1 * peak),
            ),
            ((0.05 * peak, 0.05 * peak, 0.03 * peak, 0.3 * peak),),
            refines="stop",
        ),
        Form("bent", (Constant("power", 0.0, 0.0, 5.0, 0.1),), ((0.3,), (1.0,)), ((0.05,),)),
    )
    shares = [Constant(f"share_{k}", 0.0, 0.0, 0.9, 0.1) for k in range(1, 5)]
    levels = [Constant(f"friction_{k}_MPa", 0.0, 0.0, peak, 0.05 * peak) for k in range(1, 5)]
    yarns = (fixed("reach", reach), *shares, *levels, Constant("growth", 0.0, -4.0, 4.0, 0.5))
    smooth = freely(forms, "smooth", yarns, (reach, *4 * (0.03,), *4 * (0.01 * peak,), 0.0))
    return Effect(
        id="hysteresis",
        title="loading and unloading differ, whatever the rate",
        not_sought="" if context.unloads else "no test unloads",
        rides_on=("branch",),
        shown_by="three cycles to one amplitude at two rates: a loop of the same width every time",
        source="Dahl (1968), TOR-158; Ogden & Roxburgh (1999), doi:10.1098/rspa.1999.0431",
        forms=(*forms, smooth),
        smooth=True,
    )
