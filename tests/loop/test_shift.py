"""Relaxation that heat quickens: a polymer over 100 K, whose spectrum is no form of the catalogue."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.judge import Candidate
from hyperfab.materials.registry import law

#: The shift of Williams, Landel and Ferry about 20 degC: decades and K.
C1, C2, REFERENCE = 8.0, 110.0, 20.0
TIMES = np.logspace(-8.0, 6.0, 100)
SHARES = np.exp(-0.5 * ((np.log10(TIMES) + 1.0) / 2.2) ** 2)


def decades(celsius: float) -> float:
    """How many times as slow all is as at the reference, in decades."""
    return -C1 * (celsius - REFERENCE) / (C2 + celsius - REFERENCE)


def pulled(celsius: float, rate: float, random: np.random.Generator, whole: float) -> TestCurve:
    """A strip pulled to three times its length and let go: a hundred relaxation times beside an entropic law, together
    ``whole`` times as stiff."""
    lam = np.concatenate([np.linspace(1.0, 3.0, 17), np.linspace(3.0, 1.0, 17)[1:]])
    time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(lam)) / rate)])
    still = 0.02 * (celsius + 273.15) / 293.15 * (lam - lam**-2)
    branches = np.zeros(len(TIMES))
    nominal = [0.0]
    for step in range(1, len(lam)):
        gone = (time[step] - time[step - 1]) / (TIMES * 10.0 ** decades(celsius))
        grown = np.where(gone > 1e-9, -np.expm1(-gone) / np.maximum(gone, 1e-12), 1.0)
        branches = branches * np.exp(-gone) + grown * (still[step] - still[step - 1])
        nominal.append(still[step] + whole * float(SHARES @ branches) / SHARES.sum())
    noise = random.standard_normal((2, len(lam)))
    return TestCurve(
        "uniaxial",
        lam,
        np.array(nominal) * (1.0 + 0.004 * noise[0]) + 0.0004 * noise[1],
        time_s=time,
        temperature_degC=np.full_like(lam, celsius),
        source=f"{celsius:g} degC",
        specimen=f"{rate:g} 1/s",
    )


def problem(whole: float = 4.0) -> FabricProblem:
    random = np.random.default_rng(5)
    tests = [pulled(celsius, rate, random, whole) for celsius in (-20.0, 0.0, 20.0, 50.0, 80.0) for rate in (0.03, 0.1)]
    return fabric_problem(law("neo-hookean"), (0.05,), tests, reference_degC=REFERENCE)


def missed(candidate: Candidate) -> float:
    measured = candidate.problem.measured
    return float(np.sqrt(np.mean((measured - candidate.fit.predicted) ** 2) / np.mean(measured**2)))


@pytest.mark.slow
def test_from_rubber_to_glass_the_branches_are_hundreds_of_times_as_stiff() -> None:
    found = close(problem(600.0), design=False)
    assert "rate" in found.after.ids
    assert missed(found.before) > 0.7
    assert missed(found.after) < 0.01


@pytest.mark.slow
def test_relaxation_that_heat_quickens_is_told_with_its_shift() -> None:
    found = close(problem(), design=False)
    assert found.verdict == "effect"
    assert set(found.after.ids) == {"rate", "thermal-softening"}
    assert missed(found.before) > 0.4
    assert missed(found.after) < 0.01  # the noise
    told = {
        name: form.named(found.after.fit.x[found.after.fit.place(name)]) for name, form in found.after.fit.forms.items()
    }
    for celsius in (-20.0, 0.0, 50.0):
        rise = celsius - REFERENCE
        shift = -told["rate"]["shift_1_K"] * rise / (1.0 + rise / told["rate"]["fall_K"]) / np.log(10.0)
        assert shift == pytest.approx(decades(celsius), abs=0.15)
    # The law itself stiffens with the absolute temperature.
    assert told["thermal-softening"]["softening_1_K"] == pytest.approx(-1.0 / 293.15, abs=1e-3)


@pytest.mark.slow
def test_a_simpler_form_stays_where_a_richer_one_misses_readings_set_apart_by_more() -> None:
    found = close(problem(), design=False, apart=lambda fitted: float(any(form.free for form in fitted.forms.values())))
    assert "rate" in found.after.ids
    assert found.worse == ()
    assert not any(form.free for form in found.after.fit.forms.values())
    assert found.after.fit.forms["rate"].name.endswith("-shifted")
