"""Mooney-Rivlin laws with 2, 3, 5 and 9 constants: ``W = sum Cij (I1 - 3)^i (I2 - 3)^j``, mu = 2 (C10 + C01)."""

from __future__ import annotations

from hyperfab.materials.polynomial import Polynomial

_ORDER = ((1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
_TITLES = {
    2: "the classical two constants",
    3: "with the mixed term C11",
    5: "all terms of second order",
    9: "all terms of third order; needs several modes of test",
}

LAWS = tuple(Polynomial(f"mooney-rivlin-{n}", title, *_ORDER[:n]) for n, title in _TITLES.items())
