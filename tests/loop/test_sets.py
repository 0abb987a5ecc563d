"""Sets of cloth that flows: by plasticity at finite strain, not by a form of the catalogue."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import uniaxial_pull
from hyperfab.materials.registry import law, laws

C = (0.15, 0.02, 0.01)


def pulled(mode: str, stretch: Array | float) -> Array:
    """Return the nominal stress of Yeoh's law in a mode."""
    lam = np.asarray(stretch)
    side = lam**-0.5 if mode == "uniaxial" else 1.0
    x = lam**2 + side**2 + (lam * side) ** -2 - 3.0
    return 2.0 * (lam - 1.0 / (lam**3 * side**2)) * (C[0] + 2.0 * C[1] * x + 3.0 * C[2] * x * x)


def flowed(mode: str, stretch: Array, yields: float, hardens: float) -> Array:
    """Return the nominal stress of a sheet whose stretch is elastic times plastic, at constant volume.

    It flows where the true stress is more than ``yields + hardens ln(lp)``, and is slack where it would push.
    """
    lp, found = 1.0, np.empty_like(stretch)
    for row, lam in enumerate(stretch):

        def beyond(new: float, lam: float = lam) -> float:
            return float(pulled(mode, lam / new)) * lam / new - yields - hardens * np.log(new)

        if lam > lp and beyond(lp) > 0.0:
            lp = brentq(beyond, lp, lam)
        found[row] = float(pulled(mode, max(lam / lp, 1.0))) / lp
    return found


def way(*turns: float) -> Array:
    """Return stretches from rest by way of turns, 40 steps each."""
    ends = (1.0, *turns)
    return np.concatenate([[1.0], *(np.linspace(a, b, 41)[1:] for a, b in zip(ends, turns, strict=False))])


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "yields"), [pytest.param(1, 0.15, marks=pytest.mark.slow), (2, 0.25)])
def test_a_sheet_that_flows_has_a_set_and_no_softening(seed: int, yields: float) -> None:
    """It is slack after each pull, which no softening makes it, and thinner by what it flowed.

    Cloth that slips out of the grips by as much, and wears by as much, may be told beside.
    """
    random, top = np.random.default_rng(seed), float(pulled("uniaxial", 1.6))
    steps = way(1.33, 1.0, 1.33, 1.0, 1.6, 1.0, 1.6, 1.0)
    tests = []
    for number, (mode, stretch) in enumerate([("uniaxial", steps)] * 3 + [("shear", way(1.6, 1.0))]):
        stress = flowed(mode, stretch, yields * top, 10.0 * top) + 0.008 * top * random.standard_normal(len(stretch))
        time = 60.0 * np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stretch)))])
        tests.append(TestCurve(mode, stretch, stress, time_s=time, source=f"{number}", specimen=f"{number}"))
    found = close(fabric_problem(law("yeoh-3"), (0.1, 0.02, 0.01), tests), design=False)
    assert found.verdict in ("effect", "ambiguous")
    assert found.after.ids == ("permanent-set",)


def test_what_a_set_that_flowed_gives_back_is_its_energy() -> None:
    """At constant volume the work on the way back is what the law stores in the elastic stretch, to slackness."""
    share, peak = 0.2, 1.8
    rest = share * (peak - 1.0)
    back = np.linspace(peak, 1.0 + rest, 4001)
    fabric = Fabric(law("yeoh-3"), uniaxial_pull(back), 20.0)

    def work(contraction: float) -> float:
        stress = fabric.stress(np.array(C), None, {"permanent-set": ("flow", np.array([share, contraction]))})
        return float(np.trapezoid(stress, -back))

    lam = np.linspace(1.0, peak / (1.0 + rest), 4001)
    stored = float(np.trapezoid(pulled("uniaxial", lam), lam))
    assert work(1.0) == pytest.approx(stored, rel=1e-6)
    # Threads that lie farther apart, no thinner, bear as before.
    assert work(0.0) == pytest.approx((1.0 + rest) * stored, rel=1e-6)


@pytest.mark.parametrize(
    ("form", "values", "beyond"),
    [
        ("strain-shape", (0.9, 0.5, 1.0, 0.0), 0.0),
        ("strain-shape", (0.9, 0.5, 1.0, 1.0), 0.9 * 1.2 - 0.98),
        ("smooth", (0.6, 1.0, 1.0, 0.0, 0.5, 0.6, 0.7, 0.1, 0.2, 0.25), 0.0),
        ("smooth", (0.6, 1.0, 1.0, 0.0, 0.5, 0.6, 0.9, 0.1, 0.2, 0.3), 1.2 - 0.98),
        ("smooth", (0.6, 1.0, 1.0, 0.5, 0.5, 0.6, 1.2, 0.1, 0.2, 0.3), 0.9 + 0.3 - 0.98),
        ("pseudo-elastic", (0.9, 0.1), 0.0),
    ],
)
def test_softening_leaves_no_specimen_slack(form: str, values: tuple[float, ...], beyond: float) -> None:
    """Two returns, from a strain of 0.6 the last: near rest all of the load is not taken."""
    stretch = way(1.3, 1.0, 1.6, 1.0)
    problem = fabric_problem(laws()["yeoh-3"], C, [TestCurve("uniaxial", stretch, pulled("uniaxial", stretch))])
    asked = problem.forbidden(np.array(C), {"mullins": (form, np.array(values))})
    assert max(asked["load that softening takes"], 0.0) == pytest.approx(beyond, abs=1e-12)


@pytest.mark.parametrize("form", ["smooth", "smooth-energy"])
def test_a_specimen_is_no_stiffer_after_it_was_pulled(form: str) -> None:
    """Softening as far the other way as it may be, ``lost`` being 0: else it is another law by that name."""
    stretch = way(1.3, 1.0, 1.6, 1.0)
    problem = fabric_problem(laws()["yeoh-3"], C, [TestCurve("uniaxial", stretch, pulled("uniaxial", stretch))])
    told = problem.effect("mullins").form(form)
    least = [
        one.low if one.name.startswith("depth") else null for one, null in zip(told.constants, told.null, strict=True)
    ]
    plain = problem.predict(np.array(C), {})
    assert np.all(problem.predict(np.array(C), {"mullins": (form, np.array(least))}) <= plain + 1e-12)
