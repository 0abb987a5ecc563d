"""What one pull shows: the energy's shape, the directions, the volume, the temperature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hyperfab.loop.catalogue import softening
from hyperfab.loop.catalogue.fabric.context import DataContext
from hyperfab.loop.problem import HAS_IT, Constant, Effect, Form, fixed, freely, tried_if
from hyperfab.materials.effects.elastic_law import EACH_WAY, FORMS, STRAINS, of_weft
from hyperfab.materials.effects.threads import GROUND
from hyperfab.materials.hyperfoam import ORDERS, HyperfoamLaw

_ALL = {"C20_MPa", "C30_MPa"}


def anisotropy(context: DataContext) -> Effect:
    """Warp and weft with constants of their own, ``directions`` of the material document: one ratio for all constants,
    all constants free, fibres, a sheet of threads, and smooth functions of angle and stretch."""
    reason = ""
    if context.directions:
        reason = HAS_IT
    elif isinstance(context.law, HyperfoamLaw):
        reason = "the law of a foam is one of all its directions"
    elif len(context.angles) < 2:
        reason = "the tests state one direction at most"
    law = context.law
    c = np.array(context.constants)
    linear = np.array([name in law.stresses for name in law.names])
    size = max(float(np.max(np.abs(c[linear]))), 1e-12)
    away = [
        Constant(f"weft-warp {name}", 0.0, scale=max(abs(value), 0.1 * size if stress else 0.1))
        for name, value, stress in zip(law.names, c, linear, strict=True)
    ]
    softer, stiffer, little = (
        tuple(float(v) for v in np.where(linear, factor * c, 0.0)) for factor in (-0.5, 1.0, 0.05)
    )
    singles = [tuple(float(0.05 * size) if i == k else 0.0 for i in range(len(c))) for k in np.flatnonzero(linear)]
    ratio, between = Constant("weft/warp", 1.0, 0.01, 100.0), Constant("bias-mean", 0.0, -1.0, 100.0, 0.1)
    forms = [
        Form("ratio", (ratio,), ((0.5,), (2.0,)), ((1.05,),)),
        *tried_if(
            len(context.slanted) > 0, Form("ratios", (ratio, between), ((0.5, -0.3), (2.0, -0.3)), refines="ratio")
        ),
        Form("constants", tuple(away), (softer, stiffer), (little, *singles)),
    ]
    far = (1.0 + context.reach) ** 2 - 1.0
    stiff = context.peak_stress / (2.0 * far * (1.0 + context.reach))
    warp, across = (Constant(f"k1_{way}_MPa", 0.0, 0.0, scale=0.1 * stiff) for way in ("warp", "weft"))
    # Threads of the direction that gives least are straight before those of the other: their growth is by its reach.
    near = (1.0 + context.least_reach) ** 2 - 1.0
    growth = Constant("k2", 0.0, 0.0, 20.0 / near**2, 0.3 / far**2)
    starts = ((0.2 * stiff, 0.1 / far**2), (0.1 * stiff, 1.5 / far**2))
    for way, one in (("warp", warp), ("weft", across)):
        forms.append(Form(f"{way}-fibres", (one, growth), starts, ((0.02 * stiff, 0.0),)))
    # What lies between warp and weft is no mean of both: a strip shears as well.
    slanted = context.slanted if set(law.names) <= GROUND else np.empty(0)
    both = (*away, warp, across, growth)
    beside = (*softer, 0.1 * stiff, 0.1 * stiff, 0.1 / far**2)
    forms.append(Form("constants-fibres", both, (beside,), refines=() if len(slanted) else "constants"))
    turns = context.tells_coupling or len(context.slanted) > 3
    if set(law.names) <= GROUND:
        shear = Constant("G_MPa", 0.0, 0.0, scale=0.1 * stiff)
        start = (0.3 * stiff, 0.3 * stiff, 0.1 / far**2, 0.05 * stiff)
        # A strip along the threads contracts otherwise than one across: where that was read it tells them too.
        simpler = tuple(form.name for form in forms) if context.transverse else ()
        simpler = ("warp-fibres", "weft-fibres") if len(slanted) else simpler
        threads = Form(
            "threads",
            (warp, across, growth, shear),
            (start,),
            refines=simpler,
            free=not len(slanted),
            takes_over=True,
        )
        forms.append(threads)
        growths = [replace(growth, name=f"k2_{way}") for way in ("warp", "weft")]
        begin = (*start[:3], *start[2:])
        each = Form(
            "threads-each",
            (warp, across, *growths, shear),
            (begin,),
            refines=("threads", *simpler),
            takes_over=True,
        )
        forms += tried_if(len(slanted) > 0, each)
        bias = _bias_threads(warp, across, growth, stiff, far, turns)
        forms += tried_if(context.tells_coupling or len(slanted) > 1, bias)
        # What a law of the whole sheet already has beside its ground.
        own = Form("sheet", (*bias.constants, shear), tuple((*start, 0.05 * stiff) for start in bias.starts))
        forms += tried_if(False, own)
    elif law.carries_simple_shear:
        bias = _bias_threads(warp, across, growth, stiff, far, turns)
        nearest = replace(
            freely(forms, "bias-threads-nearest", (*bias.constants, fixed("reach", context.reach)), bias.starts[0]),
            starts=tuple((*start, context.reach) for start in bias.starts),
            takes_over=True,
        )
        forms += tried_if(context.tells_coupling or len(context.slanted) > 1, nearest)
    forms += _smooth_in_angle(context, tuple(forms))
    return Effect(
        id="anisotropy",
        title="warp and weft differ",
        not_sought=reason,
        shown_by="the same pull along warp and weft, each with a replicate",
        source="Spencer (1984), Continuum Theory of the Mechanics of Fibre-Reinforced Composites; "
        "Holzapfel, Gasser & Ogden (2000), doi:10.1023/A:1010835316564",
        forms=tuple(forms),
    )


def _smooth_in_angle(context: DataContext, formulas: Sequence[Form]) -> list[Form]:
    """Return smooth functions of angle and stretch, in place of ``formulas``: tried with so many of the angle as tell
    all directions there are apart."""
    told = min(len(context.ways) - 1, 4)
    at = [Constant(f"g{way}_{k}", 0.0, -5.0, 5.0, 0.1) for way in range(1, 5) for k in range(4)]
    found: list[Form] = []
    for count in range(1, 5):
        constants = (fixed("reach", context.reach), *at[: 4 * count])
        start = (context.reach, *count * (-0.1, 0.0, 0.0, 0.0))
        found += tried_if(count == told, freely(formulas, f"smooth-{count}", constants, start))
    return found


def _bias_threads(warp: Constant, across: Constant, growth: Constant, stiff: float, far: float, turns: bool) -> Form:
    """Return threads along warp and weft and a pair between them: what is pulled along one answers along the other.

    Where the data tell how the pair is inclined, it ``turns``.
    """
    growths = [replace(growth, name=f"k2_{way}") for way in ("warp", "weft", "bias")]
    pair = Constant("k1_bias_MPa", 0.0, 0.0, scale=0.1 * stiff)
    angle = Constant("bias_deg", 45.0, 10.0, 80.0, 5.0) if turns else fixed("bias_deg", 45.0)
    return Form(
        "bias-threads",
        (warp, across, *growths[:2], pair, growths[2], angle),
        tuple(
            (0.1 * stiff, 0.1 * stiff, 0.3 / far**2, 0.3 / far**2, 0.1 * stiff, 1.0 / far**2, a)
            for a in ((35.0, 50.0) if turns else (45.0,))
        ),
        refines=("warp-fibres", "weft-fibres", "constants-fibres", "threads-each"),
        takes_over=True,
    )


def compressibility(context: DataContext) -> Effect:
    """A sheet that changes its volume: the contraction exponent; one a direction where contraction was measured along
    both, and what it is more between them where strips were cut at an angle."""
    reason = ""
    if context.law.compressible:
        reason = HAS_IT
    elif not context.transverse and len(np.unique(context.path.mode)) < 2:
        reason = "the tests are of one mode and state no transverse stretch"
    # A pulled sheet neither loses volume (above 0.5) nor widens (below 0).
    nu = Constant("nu", 0.5, 0.0, 0.5, 0.05)
    bend = Constant("bend", 0.0, -1.0, 1.0, 0.1)
    forms = [Form(name, (nu,), ((0.4,), (0.2,)), ((0.48,),)) for name in ("uniform", "slope", "split")]
    across = Constant("nu_weft", 0.5, 0.0, 0.5, 0.05)
    bent = [Form(f"{name}-bent", (nu, bend), ((0.4, 0.05),), refines=name) for name in ("slope", "uniform")]
    each = [
        Form("directions", (nu, across), ((0.4, 0.4),), ((0.48, 0.5), (0.5, 0.48))),
        Form("directions-bent", (nu, across, bend), ((0.4, 0.4, 0.05),), refines="directions"),
    ]
    widths = [
        Form("width", (nu,), ((0.4,),), refines=("uniform", "slope", "split")),
        Form("width-bent", (nu, bend), ((0.4, 0.05),), refines=("width", "slope-bent", "uniform-bent")),
    ]
    width_each = Form("width-directions", (nu, across), ((0.4, 0.4),), refines=("width", "directions"))
    formulas = [*forms, *bent, *each, *widths, width_each]
    more = [Constant(f"more_{k}", 0.0, -0.6, 0.6, 0.05) for k in range(1, 4)]
    both, start = (fixed("reach", context.reach), nu, *more), (context.reach, 0.4, 0.0, 0.0, 0.0)
    smooth = [freely(formulas, f"{kind}-smooth", both, start) for kind in ("uniform", "slope", "width")]
    weft = [across, *(replace(one, name=f"{one.name}_weft") for one in more)]
    smooth_each = [
        freely(formulas, name, (*both, *weft), (*start, *start[1:]))
        for name in ("directions-smooth", "width-directions-smooth")
    ]
    # A strip cut across the threads turns these: it may become narrower than any that keeps its volume.
    bias = Constant("nu_bias", 0.0, -0.5, 1.0, 0.05)
    slanted = Form("slanted", (nu, across, bias), ((0.4, 0.4, 0.1),), refines="directions")
    between = [bias, *(replace(one, name=f"{one.name}_bias") for one in more)]
    smooth_slanted = freely(
        [*formulas, slanted], "slanted-smooth", (*both, *weft, *between), (*start, *start[1:], 0.1, *3 * (0.0,))
    )
    # How a sheet contracts is read, or it is not told.
    read, read_each = context.transverse, context.transverse and len(context.angles) > 1
    read_slanted = context.transverse and len(context.slanted) > 0
    return Effect(
        id="compressibility",
        title="the sheet does not keep its volume",
        not_sought=reason,
        shown_by="the transverse stretch of a uniaxial test, or uniaxial and biaxial tests of one sheet",
        source="Blatz & Ko (1962), doi:10.1122/1.548937; Flory (1961), doi:10.1039/tf9615700829",
        forms=(
            *forms,
            *tried_if(read, *bent, *widths),
            *tried_if(read_each, *each, width_each),
            *tried_if(read, *smooth),
            *tried_if(read_each, *smooth_each),
            *tried_if(read_slanted, slanted, smooth_slanted),
        ),
    )


def elastic_law(context: DataContext) -> Effect:
    """A base law that is too poor, with terms of a richer energy on top of it: higher powers of I1 - 3, ln(I2/3), an
    Ogden term, an exponential."""
    if isinstance(context.law, HyperfoamLaw):
        return _more_of_a_foam(context, ORDERS[context.law.name])
    size = context.peak_stress
    far = _x(context.reach)
    # How large a modulus is by the power of I1 - 3 it stands before.
    square, cube, log, fourth = (
        Constant(name, 0.0, scale=0.1 * size / far**power)
        for name, power in (("C20_MPa", 1), ("C30_MPa", 2), ("C2_MPa", 0), ("C40_MPa", 3))
    )
    mixed = (Constant("C01_MPa", 0.0, scale=0.1 * size), Constant("C11_MPa", 0.0, scale=0.1 * size / far))
    level = Constant("D_MPa", 0.0, 0.0, scale=0.1 * size)
    toe = (
        level,
        Constant("at", 0.3 * far, 0.12 * far, 1.5 * far, 0.2 * far),
        Constant("width", 0.1 * far, 0.04 * far, far, 0.1 * far),
    )
    forms = []
    if not set(context.law.linear) >= _ALL:
        forms += [
            Form("powers", (square, cube), _starts(square, cube), _singles(square, cube)),
            Form("powers-log", (square, cube, log), _starts(square, cube, log), refines="powers"),
            Form("powers-mixed", (square, cube, *mixed), _starts(square, cube, *mixed), refines="powers"),
        ]
    else:
        forms.append(Form("high-powers", (fourth, log), _starts(fourth, log), _singles(fourth, log)))
    ogden = Form(
        "ogden",
        (Constant("mu_MPa", 0.0, scale=0.1 * size), Constant("alpha", 3.0, -12.0, 25.0, 1.0)),
        ((0.05 * size, -2.0), (0.05 * size, 3.0), (0.005 * size, 9.0)),
        ((0.01 * size, -3.0), (0.01 * size, 1.0), (0.01 * size, 4.0)),
    )
    exponential = Form(
        "exponential",
        (level, Constant("b", 1.0 / far, 0.05 / far, 30.0 / far, 1.0 / far)),
        ((0.01 * size, 1.0 / far), (0.001 * size, 6.0 / far)),
        ((0.01 * size, 1.0 / far), (0.001 * size, 5.0 / far)),
    )
    both = (*mixed, Constant("C02_MPa", 0.0, scale=0.1 * size / far))
    little = ((0.01 * size, 0.0, 0.0),)
    forms += [
        ogden,
        exponential,
        Form("second-invariant", both, little, little),
        Form("second-invariant-log", (*both, log), ((*little[0], 0.0),), refines="second-invariant"),
        Form("straightening", toe, _toes(size, far), _toes(0.1 * size, far)),
        Form("straightening-log", (*toe, log), ((*_toes(size, far)[0], 0.0),), refines="straightening"),
    ]
    for one in (ogden, exponential):
        start = (*one.starts[0], 0.01 * size)
        forms.append(Form(f"{one.name}-log", (*one.constants, log), (start,), refines=one.name))
    # What an energy has beside a function of I1 is told by tests of several kinds; of one kind it would be anything.
    beside, single = (mixed[0], Constant("mu_MPa", 0.0, scale=0.1 * size)), context.led_alike
    two_axes, several = context.has_one_mode and not single, not (context.has_one_mode or single)
    smooths = []
    for name, count, more, tried in (
        ("smooth-strain", len(STRAINS), (), single),
        ("smooth-close", 6, (*beside, log), two_axes),
        ("smooth", 5, (*beside, log), several),
        ("smooth-mixed", 5, (*beside, *both[1:], log), several),
    ):
        free = (*(Constant(f"D_{k}_MPa", 0.0, scale=0.1 * size) for k in range(1, count + 1)), *more)
        alike = freely(forms, name, (fixed("reach", far), *free), (far, *len(free) * (0.01 * size,)))
        smooths += tried_if(tried, alike)
        if f"{name}{EACH_WAY}" in FORMS:
            ends = [fixed("reach", far)]
            if not more:  # each way to where it was pulled itself: beyond that nothing tells a value
                ways = {"reach": False, of_weft("reach"): True}
                ends = [fixed(end, _x(context.reach_along(weft))) for end, weft in ways.items()]
            weft = (replace(constant, name=of_weft(constant.name)) for constant in free)
            each = (ends[0], *free, *ends[1:], *weft)
            start = tuple(constant.value or 0.01 * size for constant in each)
            smooths += tried_if(tried and context.directions, freely([*forms, alike], f"{name}{EACH_WAY}", each, start))
    return Effect(
        id="elastic-law",
        title="the strain-energy law is too poor",
        shown_by="one more mode (planar shear or biaxial), and a pull farther than the product is stretched",
        source="Yeoh (1993), doi:10.5254/1.3538343; Fung (1967); Gent & Thomas (1958), doi:10.1002/pol.1958.1202811814",
        forms=(*forms, *smooths),
    )


def _x(strain: float) -> float:
    """Return I1 - 3 of a strip pulled to a strain."""
    return (1.0 + strain) ** 2 + 2.0 / (1.0 + strain) - 3.0


def _more_of_a_foam(context: DataContext, n: int) -> Effect:
    """The law of a foam with a term more, or two: what it then is stands in the document."""
    size, most = 0.1 * context.peak_stress, max(ORDERS.values())

    def term(k: int) -> tuple[Constant, ...]:
        ends = HyperfoamLaw(k).bounds
        return (
            Constant(f"mu{k}_MPa", 0.0, scale=size),
            Constant(f"alpha{k}", 4.0, *ends[f"alpha{k}"], 2.0),
            Constant(f"nu{k}", 0.2, *ends[f"nu{k}"], 0.1),
        )

    starts = tuple((size, alpha, nu) for alpha in (-6.0, -1.0, 6.0, 15.0) for nu in (0.02, 0.35))
    probes = tuple((0.1 * size, alpha, 0.2) for alpha in (-4.0, 3.0, 12.0))
    forms = [Form(f"term-{n + 1}", term(n + 1), starts, probes)] if n < most else []
    if n + 2 <= most:
        two = tuple((*one, *other) for one, other in zip(starts, starts[3:], strict=False))
        forms.append(Form(f"terms-{n + 1}-{n + 2}", (*term(n + 1), *term(n + 2)), two, refines=f"term-{n + 1}"))
    return Effect(
        id="elastic-law",
        title="the strain-energy law is too poor",
        not_sought="" if forms else f"{most} terms are the most that a foam's law has",
        shown_by="compression, tension and simple shear, and the stretch across a tension test",
        source="Storakers (1986), doi:10.1016/0022-5096(86)90033-5",
        forms=tuple(forms),
    )


def _starts(*constants: Constant) -> tuple[tuple[float, ...], ...]:
    return (tuple(0.1 * constant.scale for constant in constants),)


def _toes(size: float, far: float) -> tuple[tuple[float, ...], ...]:
    return tuple((0.1 * size, at * far, 0.1 * far) for at in (0.2, 0.5))


def _singles(*constants: Constant) -> tuple[tuple[float, ...], ...]:
    rows = 0.2 * np.diag([constant.scale for constant in constants])
    return tuple(tuple(float(v) for v in row) for row in rows)


def thermal_softening(context: DataContext) -> Effect:
    """Stiffness that falls, or rises, with temperature: exponential; with three temperatures also its curvature, with
    four a step towards glass."""
    several, bends = len(context.temperatures) > 1, len(context.temperatures) > 2
    known = context.temperatures if several else np.array([20.0, 50.0])
    low, high = float(np.min(known)), float(np.max(known))
    span = high - low
    forms = softening(span, len(context.temperatures))
    linear = forms[0].constants[0]
    step = (
        linear,
        Constant("step", 0.0, 0.0, 8.0, 0.2),
        Constant("at_degC", low + 0.3 * span, low - 0.5 * span, high, 0.1 * span),
        Constant("width_K", 0.1 * span, 0.02 * span, 0.5 * span, 0.05 * span),
    )
    colder = (0.05 / span, 1.0, low + 0.3 * span, 0.1 * span), (0.05 / span, 3.0, low, 0.15 * span)
    glass = Form("glass", step, colder, colder[:1], refines=("exponential", "curved"))
    forms += tried_if(len(context.temperatures) > 3, glass)
    curvature = forms[1].constants[1] if bends else fixed("softening_1_K2", 0.0)
    reach = fixed("reach", context.reach)
    more = [Constant(f"with_strain_{k}_1_K", 0.0, -5.0 / span, 5.0 / span, 0.1 / span) for k in (1, 2)]
    start = (context.reach, 0.2 / span, *3 * (0.0,))
    smooth = freely(forms, "smooth", (reach, linear, curvature, *more), start)
    parts = min(max(len(context.temperatures) - 1, 2), 4)
    softened = [Constant(f"softened_{k}", 0.0, -8.0, 8.0, 0.1) for k in range(1, parts + 1)]
    ends = fixed("coldest_degC", low), fixed("hottest_degC", high)
    falls = (context.reach, low, high, 0.0, 0.0, *(0.3 * k / parts for k in range(1, parts + 1)))
    by_heat = freely(forms, "smooth-heat", (reach, *ends, *more, *softened), falls)
    return Effect(
        id="thermal-softening",
        title="stiffness changes with temperature",
        not_sought="" if several else "the tests state one temperature at most",
        shown_by="the same pull at two temperatures 30 K or more apart",
        source="Ferry (1980), Viscoelastic Properties of Polymers, ch. 11",
        forms=(*forms, smooth, *tried_if(len(context.temperatures) > 3 and not context.each_at_its_own_heat, by_heat)),
    )
