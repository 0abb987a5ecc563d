"""Sets that begin beyond a strain, and sets seen on the way down that the load makes, by formulas of no entry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import pytest
from loop.test_honest import posed

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close

Stretched = Callable[[Array, Array, str], tuple[Array, Array | float]]


def bears(lam: Array, mode: str) -> Array:
    """Nominal stress [MPa] of a Knowles solid."""
    side = lam if mode == "biaxial" else lam**-0.5
    first = lam**2 + side**2 + (lam * side) ** -2.0
    return np.asarray(0.3 * (1.0 + 0.5 * (first - 3.0)) ** 0.2 * (lam - lam**-3.0 * side**-2.0))


def late(lam: Array, most: Array, mode: str) -> tuple[Array, Array | float]:
    """Return the elastic stretch and the section where a quarter of the strain beyond 0.25 flows."""
    kept = 1.0 + 0.25 * np.maximum(most - 1.25, 0.0)
    return lam / kept, 1.0 / kept


def late_to_show(lam: Array, most: Array, mode: str) -> tuple[Array, Array | float]:
    """Return the elastic stretch where as much stays, seen on the way down alone."""
    return seen(lam, most, 0.25 * np.maximum(most - 1.25, 0.0))


def by_stress(lam: Array, most: Array, mode: str) -> tuple[Array, Array | float]:
    """Return the elastic stretch where a set goes as the largest stress, and shows on the way down."""
    return seen(lam, most, 0.35 * bears(most, mode))


def seen(lam: Array, most: Array, kept: Array) -> tuple[Array, float]:
    """Return the elastic stretch that runs from a set to the largest stretch, and the whole section."""
    return 1.0 + (lam - 1.0 - kept) * (most - 1.0) / np.maximum(most - 1.0 - kept, 1e-9), 1.0


def led(stretched: Stretched, tops: Sequence[float], mode: str, seed: int) -> TestCurve:
    """Return a test to each of some stretches and back, as long as the strip bears, 0.5 % of noise."""
    turns = [1.0, *(at for top in tops for at in (top, 1.0))]
    lam = np.concatenate([np.linspace(a, b, 19)[1:] for a, b in pairwise(turns)])
    elastic, section = stretched(lam, np.maximum.accumulate(lam), mode)
    bearing = elastic > 1.01
    stress = bears(np.maximum(elastic, 1.0), mode) * section
    stress = stress * (1.0 + 0.005 * np.random.default_rng(seed).standard_normal(len(lam)))
    time = np.cumsum(np.abs(np.diff(lam, prepend=1.0))) / 0.01
    name = f"{mode} {seed}"
    return TestCurve(mode, lam[bearing], stress[bearing], time_s=time[bearing], source=name, specimen=name)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stretched", "modes"),
    [
        pytest.param(late, ("uniaxial", "uniaxial"), marks=pytest.mark.slow),
        (late_to_show, ("uniaxial", "uniaxial")),
        pytest.param(by_stress, ("uniaxial", "biaxial"), marks=pytest.mark.slow),
    ],
)
def test_a_set_that_no_formula_has_is_named_alone(stretched: Stretched, modes: Sequence[str]) -> None:
    tops = {"uniaxial": (1.2, 1.4, 1.6, 1.9), "biaxial": (1.3, 1.5)}
    tests = [led(stretched, tops[mode], mode, seed) for seed, mode in enumerate(modes)]
    found = close(posed(tests), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("permanent-set",))
