"""Dynamic relaxation: no tangent, no line search, no coarser grid, and the same equilibrium as Newton's."""

from __future__ import annotations

import numpy as np
import pytest
from cloth_molds import ball

from hyperfab.cloth import Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.start import lowered, settled

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
STIFF = tabulate(lambda lam: (1.0 * (lam - lam**-2), 1.0 * (1 + 2 * lam**-3)), 4.0)
N = 41


@pytest.fixture(scope="module")
def mold():
    return mold_of(ball(6), (0.0, 0.0, 20.0))


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
        assert answers(sheet, mold, found).node_penetration <= 1e-9


def test_it_says_where_it_stopped_short(mold):
    sheet = Sheet(N, N, (200.0, 200.0), 1.0, SOFT, STIFF)
    found = swing(sheet, mold, lowered(sheet, mold), 1e-8, largest=50)
    assert not found.converged
    assert found.status == "no equilibrium within the allowed steps"
    assert found.residual_relative > 1e-8
