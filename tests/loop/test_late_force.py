"""A load cell whose amplifier smooths is told as that: the force comes later than the stretch it belongs to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.chapters.close_loop.origins import late_force
from hyperfab.curve import TestCurve
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.materials import law

#: The time [s] that the amplifier's filter takes.
_TAKES = 0.2


def filtered(time: Array, force: Array) -> Array:
    """Return what a filter of the first order shows of a force that is straight between readings."""
    shown = force.copy()
    for i in range(1, len(force)):
        rate = (force[i] - force[i - 1]) / (time[i] - time[i - 1])
        behind = shown[i - 1] - force[i - 1] + rate * _TAKES
        shown[i] = force[i] - rate * _TAKES + behind * np.exp((time[i - 1] - time[i]) / _TAKES)
    return shown


def pulled(late: bool, lossy: bool) -> tuple[FabricProblem, Any]:
    """Return strips that were pulled three times each, at two rates, and what is found where no entry explains them."""
    random, tests = np.random.default_rng(4), []
    for number, rate in enumerate((0.05, 0.3)):
        stretch = 1.0 + 0.4 * np.abs(1.0 - np.abs(np.linspace(0.0, 6.0, 241) % 2.0 - 1.0))
        time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stretch)))]) / rate
        stress = 0.2 * (stretch - stretch**-2)
        if lossy:  # what came in the last second bears half as much again
            stress = stress + 0.5 * (stress - np.interp(time - 1.0, time, stress))
        read = filtered(time, stress) if late else stress
        noisy = read + 0.0005 * random.standard_normal(len(read))
        tests.append(TestCurve("uniaxial", stretch, noisy, source=f"{number}", specimen=f"{number}", time_s=time))
    problem = fabric_problem(law("neo-hookean"), [0.08], tests)
    noise = Noise(np.full(len(problem.measured), 0.0005), np.inf, "stated")
    after = SimpleNamespace(fit=fit(problem, noise, {}, problem.given))
    return problem, SimpleNamespace(verdict="unexplained", noise=noise, after=after)


def test_a_force_that_comes_late_is_told_with_its_size() -> None:
    problem, found = pulled(late=True, lossy=False)
    [line] = late_force(problem, found)
    assert abs(float(line.split(" s later")[0].rsplit(" ", 1)[1]) - _TAKES) < 0.03


@pytest.mark.parametrize("lossy", [False, True])
def test_no_other_force_is_late(lossy: bool) -> None:
    assert late_force(*pulled(late=False, lossy=lossy)) == []
