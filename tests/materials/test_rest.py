"""Stiffness at rest: one isotropic law has Young's modulus between twice and three times the shear modulus."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.rest import beyond_isotropy


def strip_and_shear(nu: float, stiffer: float, seed: int) -> list[TestCurve]:
    drawn, law = np.random.default_rng(seed), Hyperfoam((0.1, 0.05), (6.0, -3.0), (nu, nu))
    found = []
    for mode, at, factor in (("uniaxial", 1.0, stiffer), ("simple-shear", 0.0, 1.0)):
        stretch = at + np.linspace(0.0, 0.3, 40)
        read = factor * law.stress(mode, stretch) * (1.0 + 0.02 * drawn.standard_normal(40))
        found.append(TestCurve(mode, stretch, read))
    return found


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
def test_tests_of_one_isotropic_law_are_not_told_apart(nu: float) -> None:
    assert [beyond_isotropy(strip_and_shear(nu, 1.0, seed)) for seed in range(50)] == [None] * 50


def test_what_asks_for_more_than_a_half_is_told_with_both_moduli() -> None:
    told = beyond_isotropy(strip_and_shear(0.3, 1.6, 1))  # E/G of 2.6 by 1.6 is 4.2
    assert told is not None
    assert "E/G = 4.2" in told
    assert beyond_isotropy(strip_and_shear(0.3, 1.6, 1)[:1]) is None
