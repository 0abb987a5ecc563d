"""Warp and weft with constants of their own: ``directions`` of the material document."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import HAS_IT, Constant, Effect, Form
from hyperfab.materials.effects.threads import GROUND


def entry(context: DataContext) -> Effect:
    """Return the effect: one ratio for all constants, all constants free, fibres, and a sheet of threads."""
    reason = ""
    if context.directions:
        reason = HAS_IT
    elif len(context.angles) < 2:
        reason = "the tests state one direction at most"
    law = context.law
    c = np.array(context.constants)
    linear = np.array([name in law.stresses for name in law.names])
    size = max(float(np.max(np.abs(c[linear]))), 1e-12)
    away = []
    for index, name in enumerate(law.names):
        if linear[index]:
            away.append(Constant(f"weft-warp {name}", 0.0, scale=max(abs(c[index]), 0.1 * size)))
        else:
            away.append(Constant(f"weft-warp {name}", 0.0, scale=max(abs(c[index]), 0.1)))
    softer, stiffer, little = (
        tuple(float(v) for v in np.where(linear, factor * c, 0.0)) for factor in (-0.5, 1.0, 0.05)
    )
    singles = [
        tuple(float(0.05 * size) if i == k else 0.0 for i in range(len(c))) for k in np.flatnonzero(linear)
    ]
    forms = [
        Form("ratio", (Constant("weft/warp", 1.0, 0.01, 100.0),), ((0.5,), (2.0,)), ((1.05,),)),
        Form("constants", tuple(away), (softer, stiffer), (little, *singles)),
    ]
    far = (1.0 + context.reach) ** 2 - 1.0
    stiff = context.peak_stress / (2.0 * far * (1.0 + context.reach))
    warp, across = (Constant(f"k1_{way}_MPa", 0.0, 0.0, scale=0.1 * stiff) for way in ("warp", "weft"))
    growth = Constant("k2", 0.0, 0.0, 20.0 / far**2, 0.3 / far**2)
    starts = ((0.2 * stiff, 0.1 / far**2), (0.1 * stiff, 1.5 / far**2))
    for way, one in (("warp", warp), ("weft", across)):
        forms.append(Form(f"{way}-fibres", (one, growth), starts, ((0.02 * stiff, 0.0),)))
    # What lies between warp and weft is no mean of both: a strip shears as well.
    off_axis = bool(np.any((context.angles % 90.0) > 1.0)) and set(law.names) <= GROUND
    both = (*away, warp, across, growth)
    beside = (*softer, 0.1 * stiff, 0.1 * stiff, 0.1 / far**2)
    forms.append(Form("constants-fibres", both, (beside,), refines=() if off_axis else "constants"))
    if set(law.names) <= GROUND:
        shear = Constant("G_MPa", 0.0, 0.0, scale=0.1 * stiff)
        start = (0.3 * stiff, 0.3 * stiff, 0.1 / far**2, 0.05 * stiff)
        # A strip along the threads contracts otherwise than one across: where that was read it tells them too.
        simpler = tuple(form.name for form in forms) if context.transverse else ()
        simpler = ("warp-fibres", "weft-fibres") if off_axis else simpler
        threads = (warp, across, growth, shear)
        forms.append(Form("threads", threads, (start,), refines=simpler, free=not off_axis))
    return Effect(
        id="anisotropy",
        title="warp and weft differ",
        not_sought=reason,
        rides_on=("direction",),
        shown_by="the same pull along warp and weft, each with a replicate",
        source="Spencer (1984), Continuum Theory of the Mechanics of Fibre-Reinforced Composites; "
        "Holzapfel, Gasser & Ogden (2000), doi:10.1023/A:1010835316564",
        forms=tuple(forms),
    )
