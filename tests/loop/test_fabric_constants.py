"""A law of nine constants that cancel, as a fit to one pull leaves them, judged by tests that tell more."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.materials.identification.design import Problem as LawProblem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.rows import Rows
from hyperfab.materials.registry import law

LAW, ROWS, NOISE = law("mooney-rivlin-9"), 60, 2e-3


def read(mode: str, random: np.random.Generator, softer: float = 0.0, celsius: float = 23.0) -> TestCurve:
    """Return a pull of a sheet that no polynomial is exactly: W = 0.15 MPa (exp(I1 - 3) - 1), softer when it is hot."""
    stretch = np.linspace(1.0, 1.7 if mode == "uniaxial" else 1.5, ROWS)
    second = {"uniaxial": stretch**-0.5, "shear": np.ones(ROWS), "biaxial": stretch}[mode]
    third = 1.0 / (stretch * second)
    first = stretch**2 + second**2 + third**2 - 3.0
    stress = 0.3 * np.exp(first) * (stretch - third**2 / stretch) * (1.0 - softer)
    return TestCurve(
        mode,
        stretch,
        stress + NOISE * random.standard_normal(ROWS),
        temperature_degC=np.full(ROWS, celsius),
        source=f"{mode} {celsius}",
    )


def constants_of_one_pull() -> list[float]:
    """Return what a fit to one pull leaves: constants of ten times the stress and more that cancel."""
    pull = read("uniaxial", np.random.default_rng(5))
    weighted = TestCurve("uniaxial", pull.stretch, pull.stress, np.full(ROWS, 1.0))
    found = fit_law(LawProblem(LAW, Rows.of([weighted])))
    assert found is not None
    return [found.material.parameters[name] for name in LAW.names]


def posed(modes: tuple[str, ...] = ("uniaxial", "shear", "biaxial"), hot: float = 0.0) -> FabricProblem:
    """Return the problem of tests in these modes, one more of each at 80 degC where they soften by the heat."""
    random = np.random.default_rng(6)
    tests = [read(mode, random) for mode in modes]
    tests += [read(mode, random, hot, 80.0) for mode in modes if hot]
    return fabric_problem(LAW, constants_of_one_pull(), tests)


def test_the_refitted_law_misses_no_more_than_least_squares() -> None:
    problem = posed()
    assert max(map(abs, constants_of_one_pull())) > 1e3
    columns = [problem.fabric.stress(one, None, {}) for one in np.eye(9)]
    unit = 1.0 / np.linalg.norm(columns, axis=1)
    matrix = np.array(columns).T * unit
    best = matrix @ np.linalg.lstsq(matrix, problem.measured, rcond=1e-15)[0]
    least = float(np.sum((problem.measured - best) ** 2)) / NOISE**2
    noise = Noise(np.full(len(problem.measured), NOISE), np.inf, "known")
    starts = ([one.value for one in problem.own], *problem.starts)
    found = min((fit(problem, noise, {}, start) for start in starts), key=lambda one: one.cost)
    assert found.chi2 == pytest.approx(least, rel=1e-3)


def test_combinations_are_told_as_the_constants_of_the_document() -> None:
    given = dict(zip(LAW.names, constants_of_one_pull(), strict=True))
    problem = posed()
    own = np.array([one.value for one in problem.own])
    assert problem.as_stated(own) == pytest.approx(given, rel=1e-9)
    twice = problem.as_stated(problem.scaled(own, 2.0))
    assert twice == pytest.approx({name: 2.0 * value for name, value in given.items()}, rel=1e-9)
    wider = problem.remake([*problem.tests, *problem.tests[:1]])
    assert wider.as_stated(own) == problem.as_stated(own)


def test_what_the_tests_do_not_tell_stays_of_the_size_that_the_document_has() -> None:
    """Constants known from three kinds of tests, refitted to pulls alone."""
    random = np.random.default_rng(7)
    sane = [0.15, 0.0, 0.0, 0.075, 0.0, 0.025, 0.0, 0.0, 0.0]  # the first powers of the exponential
    problem = fabric_problem(LAW, sane, [read("uniaxial", random), read("uniaxial", random)])
    noise = Noise(np.full(len(problem.measured), NOISE), np.inf, "known")
    found = fit(problem, noise, {}, problem.starts[0])
    assert found.chi2 / len(found.residual) < 1.3
    made = np.linalg.norm([problem.fabric.stress(one, None, {}) for one in np.eye(9)], axis=1)
    refitted = np.array(list(problem.as_stated(found.x).values()))
    assert np.max(np.abs(refitted) * made) < 30.0 * np.max(np.abs(sane) * made)


def test_softening_is_named_beside_constants_that_cancel() -> None:
    found = close(posed(hot=0.2), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("thermal-softening",))
    assert close(posed(), design=False).verdict == "noise"
