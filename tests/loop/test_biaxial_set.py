"""A sheet pulled along two axes keeps a set along each, and is shorter than at rest along one without hanging slack."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials.registry import law

MU, SET, NOISE = 0.1, 0.1, 4e-4
#: Strains along the first and second axis at the peak of each of three pulls.
PEAKS = ((0.3, 0.3), (0.3, 0.15), (0.15, 0.3), (0.3, -0.06), (0.3, 0.0))


def pulled(peaks: tuple[float, float]) -> TestCurve:
    """Return three pulls of a neo-Hookean sheet that from the second on keeps a share of each axis' strain."""
    up = np.linspace(0.0, 1.0, 25)
    once = np.concatenate([up, up[-2::-1]])
    strain = np.outer(np.tile(once, 3), peaks)
    rest = np.where(np.arange(len(strain)) < len(once), 0.0, SET)[:, None] * np.maximum(peaks, 0.0)
    one, two = ((1.0 + strain) / (1.0 + rest)).T
    random = np.random.default_rng(4)
    read = [
        np.maximum(MU * (a - 1.0 / (a**3 * b**2)), 0.0) + random.normal(0.0, NOISE, len(a))
        for a, b in ((one, two), (two, one))
    ]
    name = f"{peaks[0]:g} to {peaks[1]:g}"
    return TestCurve(
        "biaxial-general",
        1.0 + strain[:, 0],
        read[0],
        stretch2=1.0 + strain[:, 1],
        stress2=read[1],
        time_s=np.arange(len(strain)),
        direction=0.0,
        source=name,
        specimen=name,
    )


def test_a_set_along_both_axes_is_found_alone_with_its_share() -> None:
    tests = [pulled(peaks) for peaks in PEAKS]
    problem = fabric_problem(law("yeoh-3"), (0.04, 0.0, 0.0), tests)
    found = close(problem, design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("permanent-set",))
    fit = found.after.fit
    assert fit.forms["permanent-set"].name == "next-pull"
    assert fit.x[3] == pytest.approx(SET, rel=0.02)
    assert np.sqrt(np.mean((fit.predicted - problem.measured) ** 2)) < 1.1 * NOISE


def test_what_is_added_to_threads_is_that_of_the_present_set() -> None:
    """The law beyond the sheet's is kept from one question to the next: not for another set."""
    made = fabric_problem(law("yeoh-3"), (0.05, 0.0, 0.0), [pulled(PEAKS[0])]).fabric
    warp = np.array([0.05, 0.01, 0.0])
    threads, more = ("threads", np.array([0.1, 0.05, 1.0, 0.02])), ("exponential", np.array([0.02, 3.0]))

    def asked(share: float) -> np.ndarray:
        kept = ("next-pull", np.array([share]))
        return made.stress(warp, None, {"anisotropy": threads, "elastic-law": more, "permanent-set": kept})

    asked(0.05)
    again = asked(0.1)
    made._bases.clear()
    np.testing.assert_array_equal(again, asked(0.1))
