"""The report's own relaxation: near the equilibrium, never at it."""

from __future__ import annotations

import numpy as np
from cloth_molds import ball

from hyperfab.cloth import Sheet, drape, mold_of, tabulate
from hyperfab.cloth.march import relax
from hyperfab.cloth.start import lowered

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)


def test_the_residual_of_the_relaxation_floors_near_one_over_c():
    mold = mold_of(ball(5), (0.0, 0.0, 20.0))
    sheet = Sheet(21, 21, (200.0, 200.0), 1.0, SOFT, SOFT)
    exact = drape(sheet, mold)
    floors, state = [], lowered(sheet, mold)
    for c in (50.0, 200.0, 800.0):
        found = relax(sheet, mold, state, c, largest=800)
        state = found.state
        assert not found.converged
        floors.append(np.median([step.residual for step in found.history[-20:]]))
        assert abs(found.energy / exact.energy - 1) < 1 / c
    slope = np.log(floors[0] / floors[2]) / np.log(16.0)
    assert 0.7 < slope < 1.3
