"""A sheet that changes its volume."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import HAS_IT, Constant, Effect, Form, fixed, freely


def entry(context: DataContext) -> Effect:
    """Return the effect: the contraction exponent; one a direction where contraction was measured along both."""
    reason = ""
    if context.law.name.startswith("blatz-ko"):
        reason = HAS_IT
    elif not context.transverse and len(np.unique(context.path.mode)) < 2:
        reason = "the tests are of one mode and state no transverse stretch"
    # A pulled sheet neither loses volume (above 0.5) nor widens (below 0).
    nu = Constant("nu", 0.5, 0.0, 0.5, 0.05)
    bend = Constant("bend", 0.0, -1.0, 1.0, 0.1)
    forms = [Form("uniform", (nu,), ((0.4,), (0.2,)), ((0.48,),))]
    forms.append(Form("slope", (nu,), ((0.4,), (0.2,)), ((0.48,),)))
    forms.append(Form("split", (nu,), ((0.4,), (0.2,)), ((0.48,),)))
    if context.transverse:
        forms.append(Form("slope-bent", (nu, bend), ((0.4, 0.05),), refines="slope"))
        forms.append(Form("uniform-bent", (nu, bend), ((0.4, 0.05),), refines="uniform"))
    if context.transverse and len(context.angles) > 1:
        across = Constant("nu_weft", 0.5, 0.0, 0.5, 0.05)
        forms.append(Form("directions", (nu, across), ((0.4, 0.4),), ((0.48, 0.5), (0.5, 0.48))))
        forms.append(Form("directions-bent", (nu, across, bend), ((0.4, 0.4, 0.05),), refines="directions"))
    free = []
    if context.transverse:
        more = [Constant(f"more_{k}", 0.0, -0.6, 0.6, 0.05) for k in range(1, 4)]
        both, start = (fixed("reach", context.reach), nu, *more), (context.reach, 0.4, 0.0, 0.0, 0.0)
        free = [freely(forms, f"{kind}-smooth", both, start) for kind in ("uniform", "slope")]
    return Effect(
        id="compressibility",
        title="the sheet does not keep its volume",
        not_sought=reason,
        rides_on=("mode", "transverse stretch"),
        shown_by="the transverse stretch of a uniaxial test, or uniaxial and biaxial tests of one sheet",
        source="Blatz & Ko (1962), doi:10.1122/1.548937; Flory (1961), doi:10.1039/tf9615700829",
        forms=(*forms, *free),
    )
