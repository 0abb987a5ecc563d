"""A fabric whose warp and weft have laws of their own: what is added to these differs too, and what then tells what."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.chapters.close_loop.extended import extend, in_terms
from hyperfab.chapters.close_loop.fabric import pose
from hyperfab.chapters.close_loop.measured_tests import Measured
from hyperfab.chapters.fabric import FabricDocument
from hyperfab.curve import TestCurve
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import FabricProblem
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.materials import bind
from hyperfab.materials.effects.elastic_law import EACH_WAY, richer

ALONG = {"warp": {"C10_MPa": 0.02, "C20_MPa": 0.01}, "weft": {"C10_MPa": 0.005, "C20_MPa": 0.001}}
PULL = np.linspace(1.0, 1.6, 41)


def pulls(*of: tuple[float, float, np.ndarray]) -> Measured:
    """Return pulls by direction [deg] and strain rate [1/s]."""
    return Measured(
        [
            TestCurve("uniaxial", PULL, stress, time_s=(PULL - 1.0) / rate, direction=angle, specimen=str(number))
            for number, (angle, rate, stress) in enumerate(of)
        ],
        "MPa",
    )


def knitted(strain: np.ndarray, stiffness: float, locks: float) -> np.ndarray:
    """Return the stress [MPa] of loops that straighten, and lock at a strain."""
    return stiffness * strain * (0.2 + 1.0 / (1.0 + np.exp(-(strain - locks) / 0.05)))


@pytest.fixture(scope="module")
def document() -> MaterialDocument:
    told = {
        "format": "hyperfab.material/1",
        "model": "yeoh-2",
        "parameters": ALONG["warp"],
        "thickness_mm": 0.8,
        "directions": {way: {"parameters": constants} for way, constants in ALONG.items()},
    }
    return parse_document(told, "knit.json", MaterialDocument)


def posed(document: MaterialDocument, *rates: float) -> FabricProblem:
    draw = np.random.default_rng(3)
    read = [
        knitted(PULL - 1.0, stiffness, locks) + 0.0004 * draw.standard_normal(len(PULL))
        for stiffness, locks in ((0.3, 0.25), (0.06, 0.45))
    ]
    return pose(document, "knit.json", pulls((0.0, rates[0], read[0]), (90.0, rates[1], read[1])))


@pytest.mark.parametrize("plain", ["smooth-strain", "smooth", "smooth-close"])
def test_each_direction_is_written_as_it_is_predicted(document: MaterialDocument, plain: str) -> None:
    problem = posed(document, 0.01, 0.01)
    form = problem.effect("elastic-law").form(f"{plain}-each-way")
    values = np.array(form.starts[0]) * np.linspace(1.0, 3.0, len(form.starts[0]))
    own = np.array([constant.value for constant in problem.own])
    terms = {"elastic-law": (form.name, values)}
    thought = problem.predict(own, terms)
    fit: Any = SimpleNamespace(x=np.concatenate([own, values]), own=len(own), terms=terms)
    again = FabricDocument(extend(document, problem, fit, problem.law), "loop.json")
    for way, stress in zip(ALONG, thought.reshape(2, -1), strict=True):
        forward = [again.material(way).uniaxial(stretch).P for stretch in PULL]
        np.testing.assert_allclose(forward, stress, rtol=1e-9, atol=1e-12)
    count = len(problem.effect("elastic-law").form(plain).constants)
    alike = problem.predict(own, {"elastic-law": (plain, values[:count])})
    assert np.all(thought.reshape(2, -1)[1, 1:] > alike.reshape(2, -1)[1, 1:])


def test_rates_that_go_with_the_direction_tell_nothing_of_the_rate(document: MaterialDocument) -> None:
    assert "one rate" in posed(document, 0.013, 0.005).effect("rate").not_sought
    twice = pulls(*((angle, rate, PULL - 1.0) for angle in (0.0, 90.0) for rate in (0.01, 0.1)))
    assert not pose(document, "knit.json", twice).effect("rate").not_sought
    # A test that states no direction is one along the warp.
    untold = [replace(one, direction=None) for one in twice.tests[:2]]
    assert not pose(document, "knit.json", Measured(untold, "MPa")).effect("rate").not_sought


def test_threads_answer_each_way_too() -> None:
    threads = {"C10_MPa": 0.004, "k1_warp_MPa": 0.02, "k1_weft_MPa": 0.001, "k2_warp": 1.0, "k2_weft": 1.0}
    sheet = MaterialDocument(model="orthotropic", parameters=threads)
    alone = pulls((0.0, 0.013, PULL - 1.0), (90.0, 0.005, PULL - 1.0))
    problem = pose(in_terms(sheet, "cloth.json", alone.tests), "cloth.json", alone)
    assert "one rate" in problem.effect("rate").not_sought


@pytest.mark.parametrize("read", [False, True])
def test_a_free_law_told_by_strips_alone_is_no_other_in_the_plane(read: bool) -> None:
    """Strips tell nothing of what an energy has beside a function of I1: terms of that made up for each other, and a
    sheet stretched alike both ways bore a thousand times what a strip does."""
    reach, random = {"warp": 1.07, "weft": 0.77}, np.random.default_rng(3)
    tests = []
    for angle, (far, toe, end, power) in zip((0.0, 90.0), ((1.07, 0.02, 0.8, 8), (0.77, 0.02, 1.5, 5)), strict=True):
        strain = np.linspace(0.0, far, 61)
        stress = 0.1 * (toe * np.tanh(strain / 0.06) + 0.5 * strain + end * (strain / far) ** power)
        stress[1:] += 0.0008 * random.standard_normal(60)
        across = (1.0 + strain) ** -0.4 if read else None
        tests.append(TestCurve("uniaxial", 1.0 + strain, stress, stretch2=across, direction=angle, specimen=f"{angle}"))
    told = {
        "format": "hyperfab.material/1",
        "model": "neo-hookean",
        "parameters": {"C10_MPa": 0.02},
        "thickness_mm": 1.0,
        "directions": {way: {"parameters": {"C10_MPa": 0.02}} for way in reach},
    }
    knit = parse_document(told, "knit.json", MaterialDocument)
    problem = pose(knit, "knit.json", Measured(tests, "MPa"))
    effect = problem.effect("elastic-law")
    (form,) = (one for one in effect.forms if one.free and one.refines and one.name.endswith(EACH_WAY))
    noise = Noise(np.where(problem.channel == 0, 0.0008, 0.05), np.inf, "stated")
    found = fit(problem, noise, {effect.id: form}, [*(one.value for one in problem.own), *form.starts[0]])
    rows = problem.channel == 0
    assert np.sqrt(np.mean(found.residual[rows] ** 2)) < 1.1
    for (way, far), own in zip(reach.items(), problem.of_own(found.x[: found.own]), strict=False):
        assert own is not None
        plain = bind("neo-hookean", {"C10_MPa": float(own[0])})
        sheet = richer(plain, form.name, form.named(found.x[found.own :]), weft=way == "weft")
        l1, l2 = np.meshgrid(*2 * (np.linspace(1.0, 1.0 + far, 25)[1:],))
        within = l1**2 + l2**2 + (l1 * l2) ** -2 <= (1.0 + far) ** 2 + 2.0 / (1.0 + far)
        plane = sheet.membrane(l1, l2)
        assert np.all((plane.A11 * plane.A22 > plane.A12**2)[within])
        alike = np.linspace(1.05, 1.3, 6)
        times = sheet.membrane(alike, alike).P1 / sheet.uniaxial(alike).P
        assert np.all((times > 1.0) & (times < 4.0))


@pytest.mark.parametrize(("near", "far"), [("warp", "weft"), ("weft", "warp")])
def test_a_direction_is_asked_for_what_it_is_tested_to_alone(near: str, far: str) -> None:
    """A limiting law of one has no answer at the strain that the other goes to, nor is it to rise as far."""
    limits = {near: {"mu_MPa": 0.05, "Im": 0.6}, far: {"mu_MPa": 0.01, "Im": 9.0}}
    ways = {near: np.linspace(1.0, 1.3, 20), far: np.linspace(1.0, 2.5, 20)}
    told = {
        "format": "hyperfab.material/1",
        "model": "gent",
        "parameters": limits[near],
        "thickness_mm": 0.8,
        "directions": {name: {"parameters": constants} for name, constants in limits.items()},
    }
    knit = parse_document(told, "knit.json", MaterialDocument)
    tests = [
        TestCurve("uniaxial", way, 0.1 * (way - 1.0), direction={"warp": 0.0, "weft": 90.0}[name], specimen=name)
        for name, way in ways.items()
    ]
    problem = pose(knit, "knit.json", Measured(tests, "MPa"))
    own = np.array([constant.value for constant in problem.own])
    material = FabricDocument(knit, "knit.json")
    forward = [material.material(name).uniaxial(stretch).P for name, way in ways.items() for stretch in way]
    np.testing.assert_allclose(problem.predict(own, {}), forward, rtol=1e-12, atol=1e-15)
    form = problem.effect("elastic-law").form("powers")
    asked = problem.forbidden(own, {"elastic-law": ("powers", np.array(form.starts[0]))})
    assert np.all(np.isfinite(list(asked.values())))


def test_no_grip_takes_part_of_what_was_read_on_the_specimens(document: MaterialDocument) -> None:
    told = pulls((0.0, 0.01, PULL - 1.0), (90.0, 0.01, PULL - 1.0))
    marked = [replace(one, on_specimen=True) for one in told.tests]
    assert not pose(document, "knit.json", told).effect("grip-slack").not_sought
    assert pose(document, "knit.json", Measured(marked, "MPa")).effect("grip-slack").not_sought
    assert not pose(document, "knit.json", Measured([*marked, told.tests[0]], "MPa")).effect("grip-slack").not_sought


def narrowed() -> Measured:
    """Return three pulls each way whose loops lock, read across too: one way narrows by half of what the other does."""
    draw, tests = np.random.default_rng(0), []
    for angle, stiffness, locks, power in ((0.0, 0.3, 0.25, 0.45), (90.0, 0.06, 0.45, 0.2)):
        for number in range(3):
            stress = knitted(PULL - 1.0, stiffness * (1.0 + 0.04 * draw.standard_normal()), locks)
            across = PULL ** (-power * (1.0 + 0.1 * draw.standard_normal()))
            test = TestCurve(
                "uniaxial",
                PULL,
                stress + 0.0004 * draw.standard_normal(len(PULL)),
                stretch2=across + 0.002 * draw.standard_normal(len(PULL)),
                direction=angle,
                specimen=f"{angle} {number}",
            )
            tests.append(test)
    return Measured(tests, "MPa")


def test_a_contraction_that_was_read_has_a_law_no_formula_quite_is(document: MaterialDocument) -> None:
    read = narrowed()
    assert pose(document, "knit.json", read).inexact == {"elastic-law", "compressibility"}
    alone = [replace(one, stretch2=None) for one in read.tests]
    assert pose(document, "knit.json", Measured(alone, "MPa")).inexact == {"elastic-law"}


@pytest.mark.slow
def test_loops_that_lock_at_another_strain_each_way_are_a_law(document: MaterialDocument) -> None:
    """Grips that give may bend each direction as its own law would: they are never named alone."""
    found = close(posed(document, 0.013, 0.005), design=False)
    assert "elastic-law" in {*found.after.ids, *(name for names in found.indistinguishable for name in names)}
    assert found.verdict in {"effect", "ambiguous"}
