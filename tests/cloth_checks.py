"""What holds for every sheet, for the cloth's tests."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.cloth import Mold, Sheet
from hyperfab.cloth.linear import Tangent, apply
from hyperfab.cloth.membrane import Membrane


def derivatives_hold(sheet: Sheet, far: Mold) -> None:
    """Hold forces of a membrane of 7 by 6 nodes against its energy, and its tangent against them, by differences.

    It stands in waves, with taut, wrinkled and slack cells; ``far`` is a mold that it does not meet.
    """
    i, j = np.mgrid[:7, :6]
    x = sheet.flat() * [1.15, 0.95, 1.0]
    x[:, :, 0] += 0.8 * np.sin(1.3 * i + 0.7 * j)
    x[:, :, 2] = 6 * np.sin(np.pi * i / 6) * np.sin(np.pi * j / 5) + 0.5 * np.cos(2.0 * i * j)
    model, clear, f, plus, minus = Membrane(sheet, far), np.zeros((7, 6)), *np.zeros((3, 7, 6, 3))
    model.forces(x, clear, f)
    tangent, turned = Tangent.empty(7, 6, 4), np.zeros_like(x)
    model.tangent(x, 0.0, tangent)
    tangent.q[:] = [1, 0, 0, 1, 0, 1]
    d, h = np.random.default_rng(1).normal(size=x.shape), 1e-6
    apply(tangent, d, turned)
    rise = model.forces(x + h * d, clear, plus)[0] - model.forces(x - h * d, clear, minus)[0]
    assert rise / (2 * h) == pytest.approx(-(f * d).sum(), rel=1e-6)
    assert np.allclose(turned, -(plus - minus) / (2 * h), atol=1e-5 * np.abs(turned).max())
