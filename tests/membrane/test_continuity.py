"""Force and stress follow every constant of a fabric evenly, also where warp and weft change places as the stiffer."""

from __future__ import annotations

from functools import cache

import pytest
from cloth_molds import ball

from hyperfab.cloth import Sheet, answers, drape, mold_of, raised
from hyperfab.cloth.law import spring_law
from hyperfab.materials import bind
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.membrane.measures import fields
from hyperfab.membrane.orthotropic import fibre_sheet, orthotropic_sheet
from hyperfab.membrane.outline import Square
from hyperfab.membrane.relaxed import RelaxedSheet
from hyperfab.membrane.sphere_contact import SphereTest, run

DEPTH, RADIUS, SIDE = 60.0, 40.0, 200.0
KNIT = {
    "C10_MPa": 0.1, "C20_MPa": 0.03, "C30_MPa": 0.01, "C2_MPa": 0.02, "k1_warp_MPa": 0.2, "k1_weft_MPa": 0.1,
    "k1_bias_MPa": 0.15, "G_MPa": 0.3, "nu": 0.3, "k2_warp": 0.5, "k2_weft": 0.2, "k2_bias": 0.7, "bias_deg": 35.0,
}  # fmt: skip
EVEN = {**KNIT, "k1_weft_MPa": KNIT["k1_warp_MPa"], "k2_weft": KNIT["k2_warp"], "bias_deg": 45.0}
#: Curves of warp and weft that cross: the stiffer at rest is the softer further on.
CROSSING = {"warp C10": 0.0501, "warp C20": 0.0, "weft C10": 0.05, "weft C20": 0.06}
ALIKE = {"warp C10": 0.05, "warp C20": 0.02, "weft C10": 0.05, "weft C20": 0.02}
FIBRES = {"C10_MPa": 0.1, "k1_along_MPa": 0.2, "k1_across_MPa": 0.2, "k2_along": 0.4, "k2_across": 0.4}


def _two(constants):
    return orthotropic_sheet(
        *(
            bind("yeoh-2", {f"{name}_MPa": constants[f"{way} {name}"] for name in ("C10", "C20")})
            for way in ("warp", "weft")
        )
    )


def _fibres(constants):
    warp = bind("fabric-fibres", constants, anisotropic=True)
    return fibre_sheet(bind("neo-hookean", {"C10_MPa": constants["C10_MPa"]}), warp, warp.turned())


SHEETS = {
    "knit": (KNIT, lambda c: RelaxedSheet(Orthotropic.of(c))),
    "even": (EVEN, lambda c: RelaxedSheet(Orthotropic.of(c))),
    "crossing": (CROSSING, _two),
    "alike": (ALIKE, _two),
    "fibres": (FIBRES, _fibres),
}
_BALL = raised(mold_of(ball(4, RADIUS), (0.0, 0.0, -RADIUS)), DEPTH)


@cache
def _figures(which: str, name: str, factor: float) -> dict[str, float]:
    """Force [N] and largest Cauchy stress [MPa] on the mold and on the sphere, of a constant times ``factor``."""
    constants, sheet_of = SHEETS[which]
    law = sheet_of({**constants, name: constants[name] * factor})
    threads = spring_law(bind("neo-hookean", {"C10_MPa": 0.2}))
    sheet = Sheet(25, 25, (SIDE, SIDE), 1.0, threads, threads, membrane=law)
    found = drape(sheet, _BALL, 1e-8)
    assert found.converged
    draped = answers(sheet, _BALL, found)
    assert draped.cells is not None
    test = SphereTest(Square(SIDE, quarter=True), law, 1.0, RADIUS, mesh_size=14.0)
    solved = run([test], [0.5 * DEPTH, DEPTH], 1e-2)[0].solved[-1]
    stress = fields(solved.press.sheet, solved.state.places).cauchy.max()
    return {
        "draped force": draped.press_force,
        "draped stress": float(draped.cells.cauchy.max()),
        "force": solved.state.force,
        "stress": float(stress),
    }


CASES = [(which, name) for which, (constants, _) in SHEETS.items() for name in constants if constants[name] != 0.0]


@pytest.mark.slow
@pytest.mark.parametrize(("which", "name"), CASES)
def test_a_thousandth_of_a_constant_moves_force_and_stress_by_three_thousandths_at_most(which, name):
    own = _figures(which, next(iter(SHEETS[which][0])), 1.0)
    for factor in (0.999, 1.001):
        for what, value in _figures(which, name, factor).items():
            assert abs(value / own[what] - 1.0) <= 3e-3, (what, factor)
