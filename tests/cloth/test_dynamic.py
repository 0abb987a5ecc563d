"""Dynamic relaxation: no tangent, no line search, no coarser grid, and the same equilibrium as Newton's."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball, saddle, under

from hyperfab.cloth import Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.balance import Balance
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.law import spring_law
from hyperfab.cloth.march import relax
from hyperfab.cloth.start import lowered, settled
from hyperfab.materials import bind

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
STIFF = tabulate(lambda lam: (1.0 * (lam - lam**-2), 1.0 * (1 + 2 * lam**-3)), 4.0)
N = 41


@pytest.fixture(scope="module")
def mold():
    return mold_of(ball(6), (0.0, 0.0, 20.0))


@pytest.mark.slow
def test_two_solvers_and_three_starts_end_in_the_same_energy(mold):
    sheet = Sheet(N, N, (200.0, 200.0), 1.0, SOFT, STIFF)
    newton = drape(sheet, mold, 1e-10)
    flat = lowered(sheet, mold)
    i, j = np.mgrid[:N, :N] / (N - 1.0)
    bulge = np.sin(np.pi * i) * np.sin(np.pi * j)
    high, aside = flat.x.copy(), flat.x.copy()
    high[:, :, 2] += 60.0 * bulge
    aside[:, :, 0] += 15.0 * bulge
    for start in (flat, settled(high, mold, sheet), settled(aside, mold, sheet)):
        found = swing(sheet, mold, start, 1e-8)
        assert found.converged
        assert found.energy == pytest.approx(newton.energy, rel=1e-8)
        assert answers(sheet, mold, found).cut.node <= 1e-9


def test_it_says_where_it_stopped_short(mold):
    sheet = Sheet(N, N, (200.0, 200.0), 1.0, SOFT, STIFF)
    found = swing(sheet, mold, lowered(sheet, mold), 1e-8, largest=50)
    assert not found.converged
    assert found.status == "no equilibrium within the allowed steps"
    assert found.residual_relative > 1e-8


STIFFENING = {
    "locks": ("gent", {"mu_MPa": 0.1, "Im": 1.0}),
    "stiffens": ("yeoh-3", {"C10_MPa": 0.01, "C20_MPa": 0.002, "C30_MPa": 0.2}),
}


@pytest.mark.parametrize("law", ["locks", pytest.param("stiffens", marks=pytest.mark.slow)])
def test_a_sheet_that_stiffens_in_a_swing_does_not_fly_apart(law):
    surface = saddle()
    mold = mold_of(surface, under(surface, 55.0))
    model, constants = STIFFENING[law]
    law = spring_law(bind(model, constants))
    sheet = Sheet(31, 31, (180.0, 180.0), 1.0, law, law)
    start = lowered(sheet, mold)
    found = swing(sheet, mold, start, 1e-6, 300)
    assert np.isfinite(found.state.x).all()
    assert np.abs(found.state.x).max() < 300.0
    assert (
        0.0
        < found.energy
        < 0.1 * Balance(sheet, mold, 1e-6).model.forces(start.x, start.clear, np.zeros_like(start.x))[0]
    )


def test_a_relaxation_that_diverges_ends_with_a_word_and_finite_numbers(mold):
    sheet = Sheet(N, N, (200.0, 200.0), 1.0, SOFT, STIFF)
    found = relax(sheet, mold, lowered(sheet, mold), 0.05, 1e-6, 400)
    assert not found.converged
    assert "flew apart" in found.status
    assert np.isfinite(found.state.x).all()
    assert np.isfinite(answers(sheet, mold, found).stretch_warp).all()
