"""A base law that is too poor: terms of a richer energy on top of it."""

from __future__ import annotations

import numpy as np

from hyperfab.loop.catalogue.fabric import DataContext
from hyperfab.loop.problem import Constant, Effect, Form, fixed, freely

_ALL = {"C20_MPa", "C30_MPa"}


def entry(context: DataContext) -> Effect:
    """Return the effect: higher powers of I1 - 3, ln(I2/3), an Ogden term, an exponential."""
    size = context.peak_stress
    far = (1.0 + context.reach) ** 2 + 2.0 / (1.0 + context.reach) - 3.0
    free = [
        Constant(name, 0.0, scale=0.1 * size / far**power)
        for name, power in (("C20_MPa", 1), ("C30_MPa", 2), ("C2_MPa", 0), ("C40_MPa", 3))
    ]
    square, cube, log, fourth = free
    toe = (
        Constant("D_MPa", 0.0, 0.0, scale=0.1 * size),
        Constant("at", 0.3 * far, 0.12 * far, 1.5 * far, 0.2 * far),
        Constant("width", 0.1 * far, 0.04 * far, far, 0.1 * far),
    )
    mixed = (
        Constant("C01_MPa", 0.0, scale=0.1 * size),
        Constant("C11_MPa", 0.0, scale=0.1 * size / far),
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
    forms += [
        Form(
            "ogden",
            (Constant("mu_MPa", 0.0, scale=0.1 * size), Constant("alpha", 3.0, -12.0, 25.0, 1.0)),
            ((0.05 * size, -2.0), (0.05 * size, 3.0), (0.005 * size, 9.0)),
            ((0.01 * size, -3.0), (0.01 * size, 1.0), (0.01 * size, 4.0)),
        ),
        Form(
            "exponential",
            (
                Constant("D_MPa", 0.0, 0.0, scale=0.1 * size),
                Constant("b", 1.0 / far, 0.05 / far, 30.0 / far, 1.0 / far),
            ),
            ((0.01 * size, 1.0 / far), (0.001 * size, 6.0 / far)),
            ((0.01 * size, 1.0 / far), (0.001 * size, 5.0 / far)),
        ),
        Form(
            "second-invariant",
            (
                *mixed,
                Constant("C02_MPa", 0.0, scale=0.1 * size / far),
            ),
            ((0.01 * size, 0.0, 0.0),),
            ((0.01 * size, 0.0, 0.0),),
        ),
        Form("straightening", toe, _toes(size, far), _toes(0.1 * size, far)),
        Form("straightening-log", (*toe, log), ((*_toes(size, far)[0], 0.0),), refines="straightening"),
    ]
    for name in ("ogden", "exponential"):
        simple = next(form for form in forms if form.name == name)
        start = (*simple.starts[0], 0.01 * size)
        forms.append(Form(f"{name}-log", (*simple.constants, log), (start,), refines=name))
    slopes = [Constant(f"D_{k}_MPa", 0.0, scale=0.1 * size) for k in range(1, 6)]
    both = (*slopes, mixed[0], log)
    smooth = freely(forms, "smooth", (fixed("reach", far), *both), (far, *(0.01 * size for _ in both)))
    return Effect(
        id="elastic-law",
        title="the strain-energy law is too poor",
        rides_on=("stretch", "mode"),
        shown_by="one more mode (planar shear or biaxial), and a pull farther than the product is stretched",
        source="Yeoh (1993), doi:10.5254/1.3538343; Fung (1967); Gent & Thomas (1958), doi:10.1002/pol.1958.1202811814",
        forms=(*forms, smooth),
    )


def _starts(*constants: Constant) -> tuple[tuple[float, ...], ...]:
    return (tuple(0.1 * constant.scale for constant in constants),)


def _toes(size: float, far: float) -> tuple[tuple[float, ...], ...]:
    return tuple((0.1 * size, at * far, 0.1 * far) for at in (0.2, 0.5))


def _singles(*constants: Constant) -> tuple[tuple[float, ...], ...]:
    rows = 0.2 * np.diag([constant.scale for constant in constants])
    return tuple(tuple(float(v) for v in row) for row in rows)
