"""Two effects of one size hide each other: neither pays until the other is there, but each foretells tests left out."""

from __future__ import annotations

import numpy as np
import pytest
from loop.blind import case

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials import law

TIMES, SHARES = 10.0 ** np.arange(-3, 4), np.array([8.0, 5.0, 3.0, 1.6, 0.9, 0.5, 0.3])


def pulled(celsius: float, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return stretches and stresses [MPa] of a tacky elastomer: Maxwell branches whose clock is Williams, Landel and
    Ferry's, on chains of limited length that stiffen as entropy does."""
    stretch = np.concatenate([np.linspace(1.0, 3.0, 24), np.linspace(3.0, 1.3, 24)[1:]])
    step = np.abs(np.diff(stretch)) / rate
    clock = 10.0 ** (-8.0 * (celsius - 20.0) / (100.0 + celsius)) * TIMES
    driving = 0.02 * (stretch - stretch**-2)
    stress = driving * (273.0 + celsius) / 293.0 / (1.0 - (stretch**2 + 2.0 / stretch - 3.0) / 60.0)
    held = np.zeros(len(TIMES))
    for k, wait in enumerate(step, 1):
        kept = np.exp(-wait / clock)
        held = held * kept + SHARES * (driving[k] - driving[k - 1]) * (1.0 - kept) * clock / wait
        stress[k] += held.sum()
    return stretch, stress


@pytest.mark.slow
def test_temperature_and_rate_are_named_though_neither_pays_alone() -> None:
    random = np.random.default_rng(4)
    tests = []
    for celsius in (20.0, 50.0, 80.0):
        for rate in (0.03, 0.1, 0.3):
            stretch, stress = pulled(celsius, rate)
            stress = stress + random.normal(0.0, 0.004 * stress.max(), len(stress))
            rows = np.ones(len(stretch))
            name = f"{celsius:g} degC, {rate:g} 1/s"
            tests.append(
                TestCurve("uniaxial", stretch, stress, source=name, specimen=name,
                          temperature_degC=celsius * rows, rate_1_s=rate * rows)
            )  # fmt: skip
    found = close(fabric_problem(law("neo-hookean"), [0.02], tests), design=False)
    assert {"thermal-softening", "rate"} <= set(found.after.ids)
    measured = np.concatenate([test.stress for test in tests])
    before, after = (
        float(np.sqrt(np.mean((measured - one.fit.predicted) ** 2))) for one in (found.before, found.after)
    )
    assert after < 0.45 * before


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_wrong_gauge_is_no_pair(seed: int) -> None:
    """Two names that only describe would pass for it; of tests left out each says worse than nothing."""
    problem, *_ = case(seed, ("one-gain",), poor=False)
    assert close(problem, design=False).after.ids == ()
