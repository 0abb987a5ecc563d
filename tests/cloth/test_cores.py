"""The drape on several cores: the same bits as on one, however the work is parted."""

from __future__ import annotations

import os
from unittest import mock

import pytest
from cloth_molds import ball, punch

from hyperfab.cloth import Sheet, drape, mold_of, tabulate
from hyperfab.cloth.law import SpringLaw
from hyperfab.cloth.shear import linear_shear
from hyperfab.numerics import threads

SOFT = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
MOLDS = {"ball": (ball(4), (0.0, 0.0, 20.0)), "edges": (punch(24), (0.0, 0.0, 15.0))}


@pytest.mark.parametrize("shear", [None, linear_shear(0.05)])
@pytest.mark.parametrize("name", MOLDS)
def test_cores_and_blocks_change_no_bit(name: str, shear: SpringLaw | None) -> None:
    surface, shift = MOLDS[name]
    sheet = Sheet(41, 33, (200.0, 170.0), 1.0, SOFT, SOFT, shear=shear)
    found = set()
    for nodes, number in ((10**9, 1), (100, 1), (100, 2), (333, 3), (1, 3)):
        with (
            mock.patch.object(threads, "NODES", nodes),
            mock.patch.dict(os.environ, {threads.LIMIT: str(number)}),
        ):
            answer = drape(sheet, mold_of(surface, shift))
        assert answer.converged
        state = answer.state
        found.add((state.x.tobytes(), state.slot.tobytes(), answer.force.tobytes(), answer.energy))
    assert len(found) == 1
