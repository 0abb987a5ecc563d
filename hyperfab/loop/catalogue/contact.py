"""What the model of a punched sheet lacks on its force over depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.loop.catalogue import softening
from hyperfab.loop.problem import Constant, Effect, Form


@dataclass(frozen=True)
class DataContext:
    """The temperatures met [degC], how far prestretch (down, up), friction and slip
    [mm per N/mm] may go, the pull of the rim [N/mm] and what the sheet ``yields`` by [mm/N] at the deepest, and how
    much ``larger`` or smaller [mm] the sphere's radius may be; whether constants of the law, as they are known, have
    ``taken_up`` what that does."""

    temperatures: tuple[float, ...]
    reference_degC: float
    prestretch: tuple[float, float]
    friction: float
    slip: float
    pull: float
    yields: float
    larger: float = 0.0
    taken_up: bool = False


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data."""
    return (
        frame_compliance(context),
        friction(context),
        pretension(context),
        rim_slip(context),
        thermal_softening(context),
        sphere_size(context),
    )


def frame_compliance(context: DataContext) -> Effect:
    """A machine that yields in series with the sheet, ``--frame-stiffness``: load cell, frame and rod shorten what it
    reads as depth in proportion to the force, in addition to what the model's own does."""
    whole = context.yields
    compliance = Constant("compliance_mm_N", 0.0, 0.0, whole, 0.005 * whole, places=("frame",))
    return Effect(
        id="frame-compliance",
        added=True,
        title="the machine yields with the load",
        shown_by="the depth read at the punch itself (a dial gauge), or force over depth against a rigid block",
        source="a linear spring in series",
        forms=(Form("spring", (compliance,), ((0.02 * whole,), (0.1 * whole,)), ((0.01 * whole,),)),),
    )


def friction(context: DataContext) -> Effect:
    """Coulomb friction between sheet and punch, ``--friction``: a coefficient, added to the model's own."""
    mu = Constant("mu", 0.0, 0.0, max(context.friction, 1e-9), 0.05, places=("friction",))
    return Effect(
        id="friction",
        added=True,
        title="the sheet rubs on the punch",
        not_sought="" if context.friction else "the model's sheet sticks to the punch where it touches",
        shown_by="the same test with the punch oiled, or powdered",
        source="Coulomb's law",
        forms=(Form("Coulomb", (mu,), ((0.2,), (0.5,)), ((0.1,),)),) if context.friction else (),
    )


def pretension(context: DataContext) -> Effect:
    """A sheet mounted taut or slack, ``--prestretch``: stretch of the rim, added to the model's own."""
    down, up = context.prestretch
    slack, less = (((-0.4 * down,),), ((-min(0.003, 0.1 * down),),)) if down > 0.0 else ((), ())
    added = Constant("added_stretch", 0.0, -down, up, 0.005, places=("prestretch",))
    return Effect(
        id="pretension",
        added=True,
        title="the sheet was mounted taut or slack",
        shown_by="the first tenth of the depth, read closely: a taut sheet resists at once, a slack one not at all",
        source="a rim held at a multiple of its place",
        forms=(Form("even", (added,), ((0.01,), (0.04,), *slack), ((0.003,), *less)),),
    )


def rim_slip(context: DataContext) -> Effect:
    """A clamp that gives, ``--rim-slip``: the rim creeps inward in proportion to the pull, or to what of it the clamp
    does not hold."""
    most, pull = context.slip, context.pull
    slip = Constant("slip_mm2_N", 0.0, 0.0, most, 0.02 * most, places=("slip",))
    past = Constant("slip_mm2_N", 0.0, 0.0, 4.0 * most, 0.02 * most, places=("slip",))
    hold = Constant("hold_N_mm", 0.0, 0.0, 0.9 * pull, 0.02 * pull, places=("hold",))
    some = ((0.3 * most, 0.2 * pull), (0.8 * most, 0.5 * pull))
    return Effect(
        id="rim-slip",
        title="the sheet slips in its clamp",
        shown_by="marks on the sheet along the rim, before and after",
        source="a linear spring in the plane of the clamp, or one that dry friction holds at first",
        forms=(
            Form("spring", (slip,), ((0.1 * most,), (0.5 * most,)), ((0.03 * most,),)),
            Form("past a hold", (past, hold), some, ((0.05 * most, 0.3 * pull),)),
        ),
    )


def thermal_softening(context: DataContext) -> Effect:
    """Stiffness that falls, or rises, with temperature, ``temperatures`` of the material document and
    ``--temperature``: exponential in temperature; with three temperatures also its curvature."""
    met = context.temperatures
    away = max((abs(v - context.reference_degC) for v in met), default=0.0)
    span = max(away, float(np.ptp(met)) if met else 0.0, 10.0)
    return Effect(
        id="thermal-softening",
        title="stiffness changes with temperature",
        not_sought="" if met else "no file states its temperature",
        shown_by="the same test at two temperatures 30 K or more apart",
        source="Ferry (1980), Viscoelastic Properties of Polymers, ch. 11",
        forms=tuple(softening(span, len(met))),
    )


def sphere_size(context: DataContext) -> Effect:
    """A sphere of another radius than is stated, ``--sphere-radius``: more, or less, of it."""
    most = context.larger
    added = Constant("added_radius_mm", 0.0, -most, most, 0.02 * most, places=("sphere",))
    form = Form("radius", (added,), ((0.3 * most,), (-0.3 * most,)), ((0.05 * most,),))
    return Effect(
        id="sphere-size",
        title="the sphere is larger or smaller than is stated",
        shown_by="the sphere's diameter, by a calliper",
        source="geometry",
        forms=(form,) if most and not context.taken_up else (),
        not_sought="it is no sphere, or nearly as large as the clamp"
        if not most
        else "the law's constants take it up, as far as they are known (--prior 2%)"
        if context.taken_up
        else "",
        of_document=True,
    )
