"""Punched and draped sheets as problems of the loop, on forward models small enough to write down."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from loop.generators import drape as truths
from scipy.spatial.transform import Rotation
from scipy.special import gamma, kv

from hyperfab.chapters.close_loop import coupled
from hyperfab.chapters.close_loop.origins import another_frame, another_zero, off_the_sheet, untared
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.chapters.close_loop.words import another_unit, strange_probes
from hyperfab.loop.contact import ContactProblem, ForceDepth, Sheet, contact_problem
from hyperfab.loop.drape import Draped, DrapeProblem, Markers, drape_problem, mistracked, places, settings_of
from hyperfab.loop.emulator import _LENGTH, Axis, _matern, emulate, krige
from hyperfab.loop.engine import close
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.loop.problem import Curve
from hyperfab.loop.slack import Slack
from hyperfab.membrane.punch import Sphere

KNOTS = np.linspace(5.0, 60.0, 12)


def spring(settings: np.ndarray) -> np.ndarray:
    """Force over depth and the rim's pull of a sheet that is a spring in series with its clamp."""
    ratio, sphere, stretch, coefficient, slip = settings
    pull = 2e-3 * KNOTS * (1.0 + ratio) / (1.0 + 0.02 * slip) + 3.0 * stretch
    pull = pull * (1.0 + 0.06 * sphere * (KNOTS / 60.0) ** 2)
    return np.concatenate([pull * (1.0 + 0.1 * coefficient), pull])


def contact(slip: float = 0.0, fixed: Sequence[str] = (), prior: float = 0.1) -> ContactProblem:
    axes = [
        Axis("C01", 1.0, 0.35, 0.35, level=1, mixes=False),
        Axis("sphere", 0.0, 6.0, 6.0, level=1, mixes=False),
        Axis("prestretch", 0.0, 0.1),
        Axis("friction", 0.0, 0.8),
        Axis("slip", 0.0, 20.0),
    ]
    ones = np.ones(len(KNOTS))
    sheet = Sheet(emulate(spring, axes), KNOTS, ones, ("C10", "C01"), (True, True), ones, slip=slip)
    depth = np.linspace(6.0, 58.0, 45)
    warm = np.repeat([23.0, 50.0, 80.0], 15)
    files = [ForceDepth("f", depth, depth, warm)]
    return contact_problem(sheet, files, reference_degC=23.0, prior=prior, fixed=fixed)


def drape() -> DrapeProblem:
    names = ("law warp", "law weft", "depth", "prestretch", "weft more", "friction", "shear", "mass")
    axes = [Axis(name, 1.0, 0.3, 0.3, mixes=False) if name.startswith("law")
            else Axis(name, 0.0, 0.4, 0.4 if name in ("depth", "weft more") else 0.0) for name in names]  # fmt: skip
    base = np.array([axis.base for axis in axes])
    settings = np.stack([base, *(base + [axis.up * one.get(axis.name, 0.0) for axis in axes] for one in places(axes))])
    place = np.random.default_rng(4).standard_normal((len(names), 7 * 7 * 3))
    kriged = krige(axes, settings, settings @ place)
    draped = Draped(kriged, (7, 7), np.zeros((7, 7, 3)), (200.0, 200.0), ("warp", "weft"), (True, True), (0.0, 0.0))
    flat = np.random.default_rng(5).uniform(-90.0, 90.0, (40, 2))
    return drape_problem(draped, [Markers("m", flat, np.zeros((40, 3)))])


def test_a_membrane_is_held_against_all_markers_of_a_net(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fifth of the markers is 6 mm above a sheet at rest, the others lie on it: 6 mm / sqrt(5 axes 3) in all."""
    problem = drape()
    line = np.linspace(-100.0, 100.0, 7)
    nodes = np.stack([*np.meshgrid(line, line, indexing="ij"), np.zeros((7, 7))], axis=2)
    membrane = SimpleNamespace(names=("warp", "weft"), nodes=lambda *_: nodes)
    monkeypatch.setattr(coupled, "membrane_of", lambda _: membrane)
    flat = np.concatenate([one.flat for one in problem.files])
    above = np.where(np.argsort(np.argsort(flat[:, 0])) >= 32, 6.0, 0.0)
    net: Any = SimpleNamespace(material=(), sheet=SimpleNamespace(n=7, m=7, membrane=None))
    missed = SimpleNamespace(fit=SimpleNamespace(predicted=problem.measured + 6.0))
    finding: Any = SimpleNamespace(verdict="unexplained", after=missed)
    left = coupled.misses(net, problem, [Markers("m", flat, np.column_stack([flat, above]))], finding)
    unused: Any = None
    found = coupled.InsteadOfNet(net, unused, unused, unused, unused, left).said(finding)
    assert float(found[0].split("misses by ")[1].split()[0]) == pytest.approx(6.0 / np.sqrt(15.0), rel=1e-2)


def test_a_finer_run_is_met_where_it_was_run_and_changes_nothing_where_no_effect_is() -> None:
    problem = drape()
    own, more = np.array([1.1, 0.95, 0.02]), np.array([1.0, 1.0, 0.0])
    form = problem.effect("pretension").forms[0]
    terms = {"pretension": (form.name, np.array([0.1]))}
    settings = settings_of(problem.draped, own, problem.amounts(terms))
    line = np.linspace(-100.0, 100.0, 21)
    nodes = np.stack([*np.meshgrid(line, line, indexing="ij"), np.zeros((21, 21))], axis=2)
    finer = problem.on(replace(problem.draped, finer=((settings, nodes),)))
    there = np.concatenate([np.append(one.flat.T.ravel(), np.zeros(len(one.flat))) for one in problem.files])
    assert np.allclose(finer.predict(own, terms)[: len(there)], there, atol=1e-3)
    assert np.allclose(finer.predict(more, {}), problem.predict(more, {}), rtol=0.0, atol=1e-5)
    extra = finer.extras()[0].problem
    assert len(extra.measured) > len(problem.measured)


def test_a_sheet_stiffer_and_heavier_by_as_much_rests_as_before() -> None:
    problem = drape()
    mass = problem.effect("gravity").forms[0]
    light = problem.predict(np.array([1.0, 1.0, 0.05]), {"gravity": (mass.name, np.array([0.1]))})
    heavy = problem.predict(np.array([1.2, 1.2, 0.05]), {"gravity": (mass.name, np.array([0.12]))})
    assert np.allclose(light[:-3], heavy[:-3], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("problem", [contact(), contact(slip=4.0), drape()], ids=["contact", "slipping", "drape"])
def test_every_effect_at_its_null_leaves_the_prediction_the_same_to_the_bit(
    problem: ContactProblem | DrapeProblem,
) -> None:
    own = np.array([one.value for one in problem.own])
    plain = problem.predict(own, {})
    for effect in problem.effects:
        for form in effect.forms:
            null = problem.predict(own, {effect.id: (form.name, np.array(form.null))})
            assert np.array_equal(null, plain), (effect.id, form.name)
            moved = problem.predict(own, {effect.id: (form.name, np.array(form.starts[0]))})
            assert np.max(np.abs(moved - plain)) > 1e-6, (effect.id, form.name)


@pytest.mark.parametrize(
    ("off", "wave", "told"), [(0.3, 0.0, True), (-0.3, 0.0, True), (0.0, 0.0, False), (0.3, 0.3, False)]
)
def test_markers_on_a_face_of_the_cloth_are_told(off: float, wave: float, told: bool) -> None:
    """Not where they are where the sheet is, nor where that is not all that is missed."""
    problem, line = drape(), np.linspace(-100.0, 100.0, 21)
    x, y = np.meshgrid(line, line, indexing="ij")
    sheet = np.stack([x, y, 40.0 * np.exp(-((x / 60.0) ** 2) - (y / 60.0) ** 2)], axis=2)
    problem = problem.on(replace(problem.draped, base=sheet))
    rng, read = np.random.default_rng(7), []
    for one in problem.files:
        x, y = one.flat.T
        height = 40.0 * np.exp(-((x / 60.0) ** 2) - (y / 60.0) ** 2)
        up = np.stack([2.0 * x / 60.0**2 * height, 2.0 * y / 60.0**2 * height, np.ones_like(x)])
        read.append((off * up / np.linalg.norm(up, axis=0) + wave * np.sin(0.1 * x)).ravel())
    shown = np.concatenate(read)
    problem.measured = problem.delivered.copy()
    problem.measured[: len(shown)] += shown + 0.02 * rng.standard_normal(len(shown))
    noise = Noise(np.full(len(problem.measured), 0.02), np.inf, "stated")
    before = SimpleNamespace(fit=fit(problem, noise, {}, problem.given))
    lines = off_the_sheet(problem, SimpleNamespace(verdict="unexplained", noise=noise, before=before, after=before))
    assert bool(lines) is told
    for said in lines:
        assert float(re.search(r"markers (\S+) mm", said)[1]) == pytest.approx(abs(off), abs=0.03)
        assert ("above" if off > 0.0 else "below") in said


@pytest.mark.parametrize(
    ("turned", "scale", "hand", "told"),
    [(0.4, 1.0, 1, True), (0.0, 1.0, 1, False), (0.4, 1.01, 1, True), (0.0, 0.98, 1, True), (0.4, 1.0, -1, True)],
)
def test_markers_read_in_another_frame_are_told(turned: float, scale: float, hand: int, told: bool) -> None:
    """A shift and a turn of all of them, a camera's scale, and z downwards; as they are thought nothing is said of a
    frame."""
    problem = drape()
    line = np.linspace(-100.0, 100.0, 7)
    x, y = np.meshgrid(line, line, indexing="ij")
    sheet = np.stack([x, y, 40.0 * np.exp(-((x / 60.0) ** 2) - (y / 60.0) ** 2)], axis=2)
    problem = problem.on(replace(problem.draped, base=sheet))
    axis, rng = problem.states["axis"], np.random.default_rng(7)
    given = problem.delivered
    places = np.stack([given[: len(axis)][axis == way] for way in range(3)], axis=1)
    about = np.deg2rad(turned) * np.array([0.6, 0.0, 0.8])
    moved = scale * Rotation.from_rotvec(about).apply(places * [1.0, 1.0, hand]) + turned * np.array([1.0, -2.0, 0.5])
    problem.measured = given.copy()
    for way in range(3):
        problem.measured[np.flatnonzero(axis == way)] = moved[:, way] + 0.02 * rng.standard_normal(len(moved))
    found = close(problem, noise=0.02, design=False)
    lines = another_frame(problem, found)
    assert bool(lines) == told
    # The sheet's own constants take a little of it.
    for line in lines:
        assert ("frame, mirrored (z the other way)" in line) == (hand < 0)
        assert float(re.search(r"turned by (\d+\.?[\de-]*) deg", line)[1]) == pytest.approx(turned, abs=0.08), line
        grown = re.search(r"all (\S+) % too (large|small)", line)
        sign = 0.0 if grown is None else 1.0 if grown[2] == "large" else -1.0
        assert sign * float(grown[1] if grown else 0.0) == pytest.approx(100.0 * (scale - 1.0), abs=0.1), line


@pytest.mark.parametrize("digits", [0, 1])
def test_no_reading_is_surer_than_its_last_digit(digits: int) -> None:
    """Markers near each other on a smooth sheet are rounded alike, and what they differ by says less."""
    flat = np.stack(np.meshgrid(np.arange(-90.0, 91.0, 20.0), np.arange(-90.0, 91.0, 20.0)), axis=-1).reshape(-1, 2)
    height = 2.0 * 0.1**digits * np.exp(-np.sum((flat / 70.0) ** 2, axis=1))
    read = Markers("m", flat, np.round(np.column_stack([flat, height]), digits))
    problem = drape_problem(drape().draped, [read])
    rows = problem.rows_of("m")
    sd = Files([read]).noise(problem, problem.measured).sd[rows]
    assert np.min(sd) >= 0.99 * 10.0**-digits / np.sqrt(12.0)


def _found(problem, truth, sd_N, wave_N):
    """Return what is found in forces of a test that are true but for noise and a wave along the depth."""
    depth = problem.files[0].depth
    rows = len(depth)
    off = sd_N * np.random.default_rng(2).standard_normal(rows) + wave_N * np.sin(depth)
    problem.measured[:rows] = truth[:rows] + off
    noise = Noise(np.where(np.arange(len(problem.measured)) < rows, sd_N, 1.0), np.inf, "stated")
    return close(problem, noise=noise, design=False)


@pytest.mark.parametrize(
    ("zero", "wave_N", "told"), [(1.2, 0.0, True), (-0.8, 0.0, True), (0.2, 0.0, False), (0.2, 0.3, False)]
)
def test_a_depth_counted_from_elsewhere_is_told(zero: float, wave_N: float, told: bool) -> None:
    """Not where that is no farther off than is known, nor where it is not all that is missed."""
    problem = contact()
    own = np.array([*(one.value for one in problem.own[:-1]), zero])
    lines = another_zero(problem, _found(problem, problem.predict(own, {}), 0.01, wave_N))
    assert bool(lines) is told
    for line in lines:
        said = re.search(r"depth.zero (-?[\d.]+) mm, though known to 0.1 mm", line)
        assert said is not None
        assert float(said[1]) == pytest.approx(zero, abs=0.05)


@pytest.mark.parametrize(("verdict", "told"), [("effect", 1), ("ambiguous", 1), ("unexplained", 0)])
def test_a_zero_that_leaves_what_was_taken_for_little_is_told(verdict: str, told: int) -> None:
    """Noise that is a sixth louder than was thought is left with an effect as with a zero."""
    problem = contact()
    own = np.array([*(one.value for one in problem.own[:-1]), 0.5])
    rows = len(problem.files[0].depth)
    truth = problem.predict(own, {})
    truth[:rows] += 0.16 * 0.01 * np.random.default_rng(2).standard_normal(rows)  # as ``_found`` draws it
    found = replace(_found(problem, truth, 0.01, 0.0), verdict=verdict)
    assert len(another_zero(problem, found)) == told


def _off(line: str, said: str) -> float:
    """Return by how much a line says that a load cell is off [N], in the words ``said``."""
    found = re.search(said, line)
    assert found is not None
    return float(found[1]) * (1.0 if found[2] == "high" else -1.0)


@pytest.mark.parametrize(
    ("offset_N", "stretch", "wave_N", "told"),
    [(0.3, 0.0, 0.0, True), (-0.3, 0.0, 0.0, True), (0.0, 0.03, 0.0, False), (0.3, 0.0, 0.3, False)],
)
def test_a_load_cell_off_its_zero_is_told(offset_N: float, stretch: float, wave_N: float, told: bool) -> None:
    """Not of a sheet mounted taut, nor where it is not all that is missed."""
    problem = contact()
    taut = problem.predict(np.array([1.0, 1.0, 0.0]), {"pretension": ("even", np.array([stretch]))})
    lines = untared(problem, _found(problem, taut + offset_N, 0.02, wave_N))
    assert bool(lines) is told
    assert [_off(line, r"load cell ([\d.]+) N too (high|low)") for line in lines] == pytest.approx(
        [offset_N] * len(lines), abs=0.03
    )


@pytest.mark.parametrize(
    ("drift_N", "compliance", "wave_N", "told"),
    [(0.6, 0.0, 0.0, True), (-0.6, 0.0, 0.0, True), (0.0, 0.4, 0.0, False), (0.6, 0.0, 0.3, False)],
)
def test_a_load_cell_that_drifts_is_told(drift_N: float, compliance: float, wave_N: float, told: bool) -> None:
    """By what it has gone at the last reading; not of a machine that yields, nor where it is not all that is missed."""
    problem = contact(fixed=["depth.zero"])  # of a sheet that is a spring it is a drift
    yields = problem.predict(np.array([1.0, 1.0, 0.0]), {"frame-compliance": ("spring", np.array([compliance]))})
    rows = len(problem.files[0].depth)
    drifted = yields[:rows] + np.linspace(0.0, drift_N, rows)
    lines = untared(problem, _found(problem, drifted, 0.02, wave_N))
    assert bool(lines) is told
    assert [_off(line, r"drift, ([\d.]+) N too (high|low) at the last reading") for line in lines] == pytest.approx(
        [drift_N] * len(lines), abs=0.05
    )


@pytest.mark.parametrize(
    ("prior", "fixed", "sought"),
    [(0.1, [], True), (0.13, [], False), (0.13, ["C01"], True), (0.13, ["depth.zero"], False)],
)
def test_another_sphere_is_sought_where_constants_do_not_take_it_up(
    prior: float, fixed: list[str], sought: bool
) -> None:
    """Of a sphere 6 mm larger this sheet pushes back 36 % more."""
    effect = contact(fixed=fixed, prior=prior).effect("sphere-size")
    assert (bool(effect.forms), not effect.not_sought) == (sought, sought)


def test_a_sphere_of_another_radius_is_told_with_the_constants_that_could_be_off() -> None:
    problem = contact(prior=0.02)
    truth = problem.predict(np.array([1.0, 1.0, 0.0]), {"sphere-size": ("radius", np.array([-3.0]))})
    found = _found(problem, truth, 0.02, 0.0)
    assert found.after.ids == ("sphere-size",)
    assert found.after.fit.terms["sphere-size"][1] == pytest.approx([-3.0], abs=0.3)


def test_a_slack_sheet_over_another_sphere_bears_where_the_way_over_that_is_as_long_as_it() -> None:
    slack = Slack(40.0, 100.0, 60.0)
    problem = contact()
    sheet = replace(problem.sheet, slack=slack)
    depth = np.linspace(1.0, 50.0, 491)
    for larger in (0.0, 5.0):
        force = sheet.force(np.ones(2), np.array([-0.04, 0.0, 0.0, 0.0, 0.0, larger]), depth)
        ways = np.array([Sphere(40.0 + larger).way(100.0, float(one)) for one in depth])
        assert np.array_equal(force != 0.0, 0.96 * ways > 100.0)


def test_a_stiffer_sheet_slips_as_one_on_a_softer_clamp() -> None:
    problem = contact()
    depth = np.array([30.0])
    stiff = problem.sheet.force(np.array([2.0, 2.0]), np.array([0.0, 0.0, 3.0, 0.0, 0.0, 0.0]), depth)
    soft = problem.sheet.force(np.array([1.0, 1.0]), np.array([0.0, 0.0, 6.0, 0.0, 0.0, 0.0]), depth)
    assert stiff == pytest.approx(2.0 * soft, rel=1e-12)


def test_a_clamp_slips_by_what_it_does_not_hold() -> None:
    # u = c (N - hold) with N = k / (1 + 0.02 u / N): N + 0.02 c (N - hold) = k.
    problem, c, hold = contact(), 10.0, 0.08
    k = 2.0 * 2e-3 * KNOTS
    pull = np.where(k > hold, (k + 0.02 * c * hold) / (1.0 + 0.02 * c), k)
    found = problem.sheet.force(np.ones(2), np.array([0.0, 0.0, c, hold, 0.0, 0.0]), KNOTS) / KNOTS
    assert found == pytest.approx(pull, rel=2e-3)


def test_a_machine_that_yields_reads_the_depth_of_the_punch_and_its_own() -> None:
    """The model's own compliance and an added one, with a clamp that gives and softening at three temperatures."""
    problem, soft = contact(slip=4.0), np.repeat([1.0, 0.9, 0.7], 4)
    punch = np.tile(np.linspace(8.0, 50.0, 4), 3)
    force = problem.sheet.force(np.ones(2), np.array([0.01, 0.1, 3.0, 0.0, 0.0, 0.0]), punch, soft)
    yielding = replace(problem.sheet, frame=0.5)
    found = yielding.force(np.ones(2), np.array([0.01, 0.1, 3.0, 0.0, 1.5, 0.0]), punch + 2.0 * force, soft)
    assert found == pytest.approx(force, rel=1e-9)


def test_an_oiled_punch_does_not_rub() -> None:
    problem = contact()
    own = np.array([one.value for one in problem.own])
    oiled = ForceDepth("oiled", np.array([20.0, 40.0]), np.zeros(2), friction=0.0)
    wider = problem.with_reading(oiled)
    rubbed = wider.predict(own, {"friction": ("Coulomb", np.array([0.5]))})
    assert np.array_equal(rubbed[-2:], wider.predict(own, {})[-2:])
    assert rubbed[0] > wider.predict(own, {})[0]


def test_temperatures_row_by_row_are_those_of_files_of_their_own() -> None:
    problem = contact()
    effects, depth = np.array([0.0, 0.0, 8.0, 0.0, 0.0, 0.0]), np.linspace(10.0, 50.0, 9)
    soft = np.linspace(1.0, 0.7, 9)
    mixed = problem.sheet.force(np.ones(2), effects, depth, soft)
    alone = [float(problem.sheet.force(np.ones(2), effects, depth[i : i + 1], soft[i : i + 1])[0]) for i in range(9)]
    assert mixed == pytest.approx(np.array(alone), rel=1e-3)


def test_no_sheet_is_draped_beyond_the_reach_of_an_axis() -> None:
    """Shares of the reach, and on the other side of the base no further than the axis goes there."""
    axes = [Axis("law warp", 1.0, 0.3, 0.3, mixes=False), Axis("depth", 0.0, 2.0, 2.0, mixes=False)]
    axes += [Axis("prestretch", 0.0, 0.4, 0.1)]
    axes += [
        Axis("weft more", 0.0, 0.4, 0.4),
        *(Axis(name, 0.0, 1.0) for name in ("shear", "mass", "friction")),
    ]
    found = places(axes)
    for axis in axes:
        shares = [one.get(axis.name, 0.0) for one in found]
        assert max(shares) == 1.0
        assert min(shares) >= -axis.down / axis.up
    assert min(one.get("prestretch", 0.0) for one in found) == pytest.approx(-0.25)


def test_what_is_between_the_runs_is_as_smooth_as_materns_five_halves() -> None:
    places = np.random.default_rng(3).uniform(-1.0, 1.0, (5, 4))
    away = np.linalg.norm(places[:, None, :] - places, axis=2) / _LENGTH
    r = np.sqrt(5.0) * away + np.eye(5)
    expected = np.where(np.eye(5) > 0.0, 1.0, r**2.5 * kv(2.5, r) / (2.0**1.5 * gamma(2.5)))
    np.testing.assert_allclose(_matern(places, places), expected, rtol=1e-12)


@pytest.mark.parametrize("factor", [1000.0, 1e-3, 1.0 / 9.80665, 25.4])
def test_readings_in_another_unit_than_stated_are_asked_about(factor: float) -> None:
    problem = contact()
    given = problem.delivered
    problem.measured = given * factor
    [told] = another_unit(problem)
    assert f"{factor:.3g} times" in told
    problem.measured = given * 1.8  # as much stiffer as no unit is
    assert another_unit(problem) == []
    problem.measured = np.zeros(len(given))
    assert another_unit(problem) == []
    # A law beyond its tests: right where it is small, a thousand times too much where it is large.
    problem.measured = np.where(np.abs(given) > 0.3 * np.abs(given).max(), 1e-3 * given, given)
    assert np.mean(problem.measured == given) > 0.1
    assert another_unit(problem) == []


@pytest.mark.parametrize("low", [1.0, 0.5])
def test_noise_that_is_known_badly_and_guessed_too_low_is_nothing_else(low: float) -> None:
    """Where the verdict is noise, something else may not be likely beside it, however loud the noise turned out."""
    problem = contact()
    sd = np.ones(len(problem.measured))
    sd[:45] = 0.02
    problem.measured = problem.delivered
    problem.measured[:45] += 0.02 * np.random.default_rng(1).standard_normal(45)
    found = close(problem, noise=Noise(low * sd, 2.0, "a guess"), design=False)
    assert found.verdict == "noise"
    assert found.belief is not None
    assert found.belief.something_else <= 1.0 / (2.0 + len(problem.effects)) + 1e-9


@pytest.mark.parametrize(
    ("third", "told"),
    [
        (lambda warm: 0.9 * warm, False),
        (lambda warm: np.full(len(warm), 21.4), True),  # it hangs in the air
        (lambda warm: np.where(warm > 120.0, 1372.0, warm), True),  # its wire broke
        (lambda warm: 1.8 * warm + 32.0, True),  # degF
    ],
)
def test_a_thermocouple_at_fault_is_told_from_the_others(third: Callable[[np.ndarray], np.ndarray], told: bool) -> None:
    warm = np.linspace(20.0, 200.0, 30)
    curves = tuple(Curve(name, 30 * k, 30 * k + 30, warm) for k, name in enumerate(("a", "b", "c")))
    given = np.tile(warm, 3)
    problem: Any = SimpleNamespace(
        states={"probe": given}, curves=curves, delivered=given,
        measured=np.concatenate([1.1 * warm, 1.05 * warm, third(warm)]),
    )  # fmt: skip
    said = strange_probes(problem)
    assert [one.split()[0] for one in said] == (["c"] if told else [])


def test_a_thermocouple_that_stays_cold_is_not_at_fault_for_its_noise() -> None:
    warm = np.linspace(20.0, 200.0, 30)
    curves = tuple(Curve(name, 30 * k, 30 * k + 30, warm) for k, name in enumerate(("a", "b", "c")))
    cold = 20.0 + 0.001 * warm
    given = np.concatenate([warm, warm, cold])
    noise = 0.3 * np.random.default_rng(2).standard_normal(30)
    problem: Any = SimpleNamespace(
        states={"probe": given}, curves=curves, delivered=given,
        measured=np.concatenate([1.1 * warm, 1.05 * warm, cold + noise]),
    )  # fmt: skip
    assert strange_probes(problem) == []


@pytest.mark.parametrize("effects", [(), ("friction",), ("gravity", "pretension"), ("crease",), ("lens",)])
@pytest.mark.parametrize("protocol", ["rich", "poor", "top"])
def test_a_marker_that_was_lost_is_told_from_what_a_model_lacks(effects: tuple[str, ...], protocol: str) -> None:
    """What a plain net leaves of sheets that another program drapes; then one marker is taken for another's place."""
    random = np.random.default_rng(5)
    truth = truths.draw(random, effects)
    flat, found = truths.measure(truth, np.random.default_rng(6), 0.05, protocol)
    left = found - truths.measure(truths.Truth(()), np.random.default_rng(6), 0.0, protocol)[1]
    assert len(mistracked(flat, left)) == 0
    left[11] += [0.0, 4.0, -4.0]
    assert mistracked(flat, left).tolist() == [11]
    if protocol == "rich":
        left[[40, 41]] += [[20.0, 0.0, 0.0], [0.0, 8.0, 0.0]]
        assert mistracked(flat, left).tolist() == [11, 40, 41]
        left[::3] += 9.0 * random.standard_normal(left[::3].shape)  # nothing left that could be called usual
        assert len(mistracked(flat, left)) == 0
