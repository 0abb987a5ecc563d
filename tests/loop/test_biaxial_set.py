"""Sheets pulled along two axes: a set along each, shorter than at rest along one, an axis that answers the other."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.registry import law

MU, SET, NOISE = 0.1, 0.1, 4e-4
#: A knit's scale [MPa] and the exponents of its strains along the axes and of their product.
KNIT, ALONG, BETWEEN = 0.05, (16.0, 8.0), 5.0
#: Strains along the first and second axis at the peak of each of three pulls.
PEAKS = ((0.3, 0.3), (0.3, 0.15), (0.15, 0.3), (0.3, -0.06), (0.3, 0.0))


def rubber(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return the nominal stress [MPa] along the first axis of a neo-Hookean sheet."""
    return MU * (one - 1.0 / (one**3 * two**2))


def knit(one: np.ndarray, two: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return the same of a sheet whose energy is an exponential of a quadratic form of the Green-Lagrange strains.

    Fung, Fronek & Patitucci (1979), doi:10.1152/ajpheart.1979.237.5.H620.
    """
    own, other = 0.5 * (one**2 - 1.0), 0.5 * (two**2 - 1.0)
    grown = np.exp(ALONG[axis] * own**2 + ALONG[1 - axis] * other**2 + 2.0 * BETWEEN * own * other)
    return KNIT * one * grown * (ALONG[axis] * own + BETWEEN * other)


def pulled(peaks: tuple[float, float], pulls: int = 3, knitted: bool = False) -> list[TestCurve]:
    """Return what both axes read of pulls after the first of which a share of each axis' strain stays.

    What stays has flowed at constant volume: the nominal stress is the derivative of the energy by the whole stretch.
    """
    up = np.linspace(0.0, 1.0, 17)
    once = np.concatenate([up, up[-2::-1]])
    strain = np.outer(np.concatenate([once, *[once[1:]] * (pulls - 1)]), peaks)
    rest = 1.0 + np.where(np.arange(len(strain)) < len(once), 0.0, SET)[:, None] * np.maximum(peaks, 0.0)
    one, two = ((1.0 + strain) / rest).T
    random = np.random.default_rng(4)
    stress = (knit(one, two), knit(two, one, 1)) if knitted else (rubber(one, two), rubber(two, one))
    noise = 5.0 * NOISE if knitted else NOISE
    stress = tuple(along / own for along, own in zip(stress, rest.T, strict=True))
    read = [np.maximum(along, 0.0) + random.normal(0.0, noise, len(along)) for along in stress]
    name = f"{peaks[0]:g} to {peaks[1]:g}"
    return [
        TestCurve(
            "biaxial-general",
            1.0 + strain[:, axis],
            read[axis],
            stretch2=1.0 + strain[:, 1 - axis],
            time_s=np.arange(len(strain)),
            direction=90.0 * axis,
            source=f"{name}, axis {axis + 1}",
            specimen=name,
        )
        for axis in (0, 1)
    ]


def test_a_set_along_both_axes_is_found_alone_with_its_share() -> None:
    tests = [test for peaks in PEAKS for test in pulled(peaks)]
    problem = fabric_problem(law("yeoh-3"), (0.04, 0.0, 0.0), tests)
    found = close(problem, design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("permanent-set",))
    fit = found.after.fit
    assert fit.forms["permanent-set"].name == "next-pull"
    assert fit.x[3] == pytest.approx(SET, rel=0.02)
    assert np.sqrt(np.mean((fit.predicted - problem.measured) ** 2)) < 1.1 * NOISE


@pytest.mark.slow
def test_a_sheet_whose_axes_answer_to_each_other_is_told_with_its_set() -> None:
    ratios = ((1.0, 1.0), (1.0, 0.5), (0.5, 1.0), (1.0, 0.0), (0.0, 1.0))
    tests = [test for one, two in ratios for test in pulled((0.22 * one, 0.22 * two), 2, knitted=True)]
    found = close(fabric_problem(law("yeoh-3"), (0.1, 0.1, 0.1), tests), design=False)
    assert (found.verdict, set(found.after.ids)) == ("effect", {"anisotropy", "permanent-set"})
    fit = found.after.fit
    assert fit.forms["anisotropy"].name == "bias-threads"
    place = 3 + [one for name in found.after.ids for one in fit.forms[name].constants].index(
        fit.forms["permanent-set"].constants[0]
    )
    assert fit.x[place] == pytest.approx(SET, rel=0.05)


def test_what_is_added_to_threads_is_that_of_the_present_set() -> None:
    """What sheet and law answer is kept from one question to the next: not for another set."""
    used, fresh = (fabric_problem(law("yeoh-3"), (0.05, 0.0, 0.0), pulled(PEAKS[0])).fabric for _ in range(2))
    warp = np.array([0.05, 0.01, 0.0])
    threads, more = ("threads", np.array([0.1, 0.05, 1.0, 0.02])), ("exponential", np.array([0.02, 3.0]))

    def asked(fabric: Fabric, share: float) -> np.ndarray:
        kept = ("next-pull", np.array([share]))
        return fabric.stress(warp, None, {"anisotropy": threads, "elastic-law": more, "permanent-set": kept})

    asked(used, 0.05)
    # An equilibrium that begins where another ended is that one but for rounding.
    np.testing.assert_allclose(asked(used, 0.1), asked(fresh, 0.1), rtol=1e-9, atol=1e-12)
