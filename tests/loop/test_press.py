"""The press as a problem of the loop: effects at their null change nothing, and the table is the press itself."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from loop import blind_press
from loop.generators import press as caps
from scipy.special import ndtr

from hyperfab.chapters.close_loop import finalise
from hyperfab.chapters.close_loop.finalise import close_rounds
from hyperfab.chapters.close_loop.press import pose
from hyperfab.chapters.close_loop.readings import Files
from hyperfab.loop.catalogue.press import thickness_variation
from hyperfab.loop.engine import Finding
from hyperfab.loop.fitting import fit
from hyperfab.loop.judge import judge
from hyperfab.loop.press import PressProblem
from hyperfab.loop.press_reading import CONTACT_BLUR, Changes, Reading, variation
from hyperfab.loop.press_table import PressTable
from hyperfab.loop.thresholds import ALPHA
from hyperfab.pressing.mold import Pose, guide_line


def posed() -> PressProblem:
    random = np.random.default_rng(2)
    read = blind_press.as_readings(caps.measure(caps.Truth(()), random, 0.0, "rich"))
    return pose(blind_press.told(), read, 0.1, [])[0]


def test_every_effect_at_its_null_leaves_the_prediction_the_same_to_the_bit() -> None:
    problem = posed()
    own = np.array([one.value for one in problem.own])
    plain = problem.predict(own, {})
    for effect in problem.effects:
        for form in effect.forms:
            null = np.array(form.null)
            if form.name in ("in time", "stretched"):
                assert null[0] == 0.0
            assert np.array_equal(problem.predict(own, {effect.id: (form.name, null)}), plain), form.name


def test_predictions_agree_with_formulas_of_caps() -> None:
    problem = posed()
    left = problem.measured - problem.predict(np.array([one.value for one in problem.own]), {})
    for channel, size in ((0, 2e-5), (1, 2e-3), (2, 0.05), (3, 1e-12)):
        assert np.sqrt(np.mean(left[problem.channel == channel] ** 2)) < size


def test_the_table_moved_by_a_tilt_is_the_tilted_press() -> None:
    problem, closed = posed(), blind_press.told().closed
    tilt = np.array([2e-3, -1e-3])
    pose_there = Pose(closed.pose.opening, (float(tilt[0]), float(tilt[1])), closed.pose.pivot)
    exact = closed.press.at(pose_there).closing_force
    table = problem.summed.moved(Changes(tilt=tilt).settings)
    found = float(table.force(np.array([closed.pose.opening]))[0])
    assert abs(found - exact) < 3e-3 * exact


def test_the_table_moved_by_a_strain_is_the_press_of_the_grown_mold() -> None:
    """Either mold grows about the place where it is mounted; the table knows it by the gap's gradient alone."""
    problem, closed = posed(), blind_press.told().closed
    line, press, strain = guide_line(closed.case.male), closed.press, 1e-3

    def force(male: float, female: float) -> float:
        fixed = [np.array([*line, mount]) for mount in (closed.case.male.mount, press.female.mount)]
        vertices = [press.front.vertices, press.female.vertices]
        grown = [v + e * (v - f) for v, e, f in zip(vertices, (male, female), fixed, strict=True)]
        front = replace(press.front, vertices=grown[0])
        return replace(press, front=front, female=press.female.moved(grown[1])).at(closed.pose).closing_force

    def summed(*settings: float) -> float:
        table = problem.summed.moved(Changes(strain=np.array(settings)).settings)
        return float(table.force(np.array([closed.pose.opening]))[0])

    plain = force(0.0, 0.0)
    for settings in ((strain, 0.0), (0.0, strain)):
        more = force(*settings) - plain
        assert more > 0.01 * plain
        # The gap changes by more than its gradient tells.
        assert summed(*settings) - summed(0.0, 0.0) == pytest.approx(more, abs=1.5e-3 * plain)


def test_foam_shrinks_in_time_and_a_row_at_a_time() -> None:
    """What was read at once is of the whole foam, what was read late of the shrunk one."""
    problem = posed()
    own = np.array([one.value for one in problem.own])
    timed = next(one for one in problem.files if one.time_s is not None and one.stroke is not None)
    assert timed.stroke is not None
    times = np.array([1e-6, 30.0, 1e6])
    stroke = np.full(3, float(np.max(timed.stroke)))
    read = [replace(timed, name=f"{t}.csv", values=np.zeros(3), stroke=stroke, time_s=np.full(3, t)) for t in times]
    every = replace(timed, name="all.csv", values=np.zeros(3), stroke=stroke, time_s=times)
    problem = replace(problem, files=[every, *read])
    term = {"foam-shrinkage": ("in time", np.array([0.1, 30.0]))}
    together, *apart = problem.shown(own, term)
    np.testing.assert_allclose(together, [rows[0] for rows in apart], rtol=1e-3)
    for rows, lost in zip(apart, (0.0, 0.1 * (1.0 - np.exp(-1.0)), 0.1), strict=True):
        alone = replace(problem, files=[read[0]]).shown(own, {"foam-shrinkage": ("share", np.array([lost]))})
        np.testing.assert_allclose(rows, alone[0], rtol=1e-6)
    assert together[2] < 0.99 * together[0]


@pytest.mark.slow
def test_a_floating_female_turns_in_the_loop_as_it_does_in_the_press() -> None:
    options = ("--force", "40N", "--float")
    level = blind_press.told("", options)
    turned = blind_press.told("variation = { x = 0.08, y = -0.03 }\n", options).closed
    read = blind_press.as_readings(caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "film"))
    problem = pose(level, read, 0.1, [])[0]
    own = {one.name: one.value for one in problem.own}
    wedge = {"thickness-variation": ("wedge", np.array([0.08, -0.03]))}
    none, tilt = (problem._set(problem._moved(own, problem.changes(one)), own).hangs.turn for one in ({}, wedge))
    assert np.abs(none).max() < 1e-12
    assert np.abs(tilt - turned.pose.tilt).max() < 0.05 * np.hypot(*turned.pose.tilt)
    plain = problem.predict(np.array(list(own.values())), {})
    given = problem.predict(np.array(list(own.values())), {"tilt": ("rotation", np.array([0.1, 0.0]))})
    assert np.array_equal(plain, given)


def test_a_thickness_varies_by_a_polynomial_alike_along_both_axes() -> None:
    plan = np.array([[0.5, -2.0], [-1.5, 3.0]])
    found = variation(plan, {"x": 0.1, "xyy": 0.02})
    np.testing.assert_allclose(found, [0.05 + 0.02 * 2.0, -0.15 - 0.02 * 13.5])
    assert variation(plan, {}) == 0
    for form in thickness_variation().forms:
        names = [one.name for one in form.constants]
        turned = {"".join(sorted(name.translate({120: 121, 121: 120}))) for name in names}
        assert len(set(names)) == len(names)
        assert turned == set(names)


def test_between_openings_a_cubic_is_met_and_beyond_them_the_last_one_holds() -> None:
    openings = np.linspace(-2.0, 3.0, 11)
    table = SimpleNamespace(openings=openings, step=0.5)
    values = np.stack([openings**3 - openings, 2.0 * openings**2], axis=1)
    at = np.array([-2.0, -1.83, 0.1, 2.9, 3.0, 3.4, 4.5, -2.7])
    inside = np.clip(at, -2.0, 3.0)
    expected = np.stack([inside**3 - inside, 2.0 * inside**2], axis=1)
    np.testing.assert_allclose(PressTable.at(table, at, values), expected, rtol=1e-12, atol=1e-12)


#: An entry, what looks like it, and the reading of the extras that the one moves and the other does not.
TELLING = [
    ("tilt", "rotation", [0.1, 0.05], "lateral-shift", "displacement", [0.2, -0.1], "mounting"),
    ("fabric-compression", "linear", [20.0], "foam-shrinkage", "share", [0.05], "fabric"),
    ("foam-softening", "exponential", [0.003], "foam-relaxation", "share", [0.2], "cold"),
]


@pytest.mark.parametrize(
    ("one", "form", "values", "other", "simple", "like", "kind"), TELLING, ids=[row[-1] for row in TELLING]
)
def test_what_is_measured_next_shows_one_entry_and_not_its_look_alike(
    one: str, form: str, values: list[float], other: str, simple: str, like: list[float], kind: str
) -> None:
    read = blind_press.as_readings(caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "rich"))
    problem = pose(blind_press.told(*blind_press.HOT), read, 0.1, [])[0]
    own, rows = np.array([constant.value for constant in problem.own]), len(problem.measured)
    extra = next(
        extra.problem
        for extra in problem.extras()
        if (kind == "cold" and "temperature_degC" in extra.details) or extra.details["reading"] == kind
    )

    def moved(name: str, form: str, values: list[float]) -> float:
        there = extra.predict(own, {name: (form, np.array(values))})[rows:]
        return float(np.max(np.abs(there - extra.predict(own, {})[rows:])))

    # A shift is nothing to the mounting face, thinner foam nothing to the fabrics, and softening nothing to the cold.
    apart = moved(one, form, values), moved(other, simple, like)
    assert min(apart) == pytest.approx(0.0, abs=1e-9 * max(apart))
    assert max(apart) > 0.0


def test_molds_have_grown_by_what_heat_made_of_them_as_warm_as_they_were_read() -> None:
    """A strain found on hot molds is none on cold ones, and half of it half-way: as the expansion that is written."""
    told = blind_press.told(*blind_press.HOT)
    hot, cold = caps.HOT_DEGC, told.reference
    read = blind_press.as_readings(caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "film"))[0]
    at = [replace(read, name=f"{t}.csv", temperature=t) for t in (hot, cold, 0.5 * (hot + cold))]
    problem = pose(told, at, 0.1, [])[0]
    own = np.array([one.value for one in problem.own])

    def grown(strain: float) -> list[np.ndarray]:
        found = problem.predict(own, {"thermal-expansion": ("both molds", np.array([strain]))})
        return [found[problem.rows_of(one.name)] for one in at]

    plain, whole, half = grown(0.0), grown(4e-3), grown(2e-3)
    np.testing.assert_array_equal(whole[1], plain[1])
    np.testing.assert_allclose(whole[2], half[0], atol=1e-12)
    assert np.abs(whole[0] - plain[0]).max() > 1e-3


def test_foam_that_is_told_by_several_laws_is_as_stiff_as_at_the_temperature_of_a_reading() -> None:
    """Read with the molds at another temperature: between the laws, and the molds have shrunk by what they grew."""
    laws = [
        f'{{ law = "linear", modulus = "{stiff} MPa", temperature = "{at} degC" }}'
        for at, stiff in ((20, 0.1), (200, 0.05))
    ]
    foam = "\n".join(line for line in caps.FOAM_TOML.splitlines() if not line.startswith("compression"))
    told = blind_press.told(f"compression = [{', '.join(laws)}]\n", blind_press.HOT[1], foam=f"{foam}\n")
    read = blind_press.as_readings(caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "stroke"))
    problem = pose(told, [replace(read[0], temperature=110.0)], 0.1, [])[0]
    warmth = problem.files[0].warmth
    assert warmth is not None
    assert warmth.law is not None
    assert warmth.law.stress(0.3) == pytest.approx(0.3 * 0.075)
    hot, here = ([float(one.strain(t)) for one in told.model.files.expansions] for t in (200.0, 110.0))
    assert warmth.grown == pytest.approx(np.array(here) - hot)
    assert next(e for e in problem.effects if e.id == "foam-softening").not_sought


def test_foam_that_is_not_equally_hot_everywhere_is_pressed_as_the_press_does_it() -> None:
    """With a dwell each place has the law of its own temperature: thin places are warm through, thick ones are not."""
    laws = (
        '[{ law = "linear", modulus = "0.1 MPa", temperature = "20 degC" }, '
        '{ law = "linear", modulus = "0.05 MPa", temperature = "200 degC" }]'
    )
    foam = "\n".join(line for line in caps.FOAM_TOML.splitlines() if not line.startswith("compression"))
    warm = 'conductivity = "0.05 W/m/K"\nspecific_heat = "1045 J/kg/K"\ndensity = "30 kg/m^3"\n'
    told = blind_press.told(
        f"compression = {laws}\nvariation = {{ x = 0.2 }}\n{warm}",
        (*blind_press.HOT[1], "--dwell", "2s"),
        foam=f"{foam}\n",
    )
    closed, some = told.closed, np.arange(0, len(told.closed.cold), 40)
    assert np.ptp(closed.press.sandwich.law.stress(0.3)) > 1e-4
    read = Reading("film.csv", "pressure", np.zeros(len(some)), places=told.frame.outward(closed.cold[some]))
    problem = pose(told, [read], 0.1, [])[0]
    found = problem.predict(np.array([one.value for one in problem.own]), {})
    order = np.concatenate([part.index for part in problem.files]).astype(int)
    most = closed.contact.pressure.max()
    assert found[: len(some)] == pytest.approx(closed.contact.pressure[some][order], abs=2e-3 * most)


def test_what_stays_is_taken_off_what_the_press_pressed() -> None:
    """Half of the strain stays: an opened press is half way between the closed one and the sandwich as it was."""
    read = blind_press.as_readings(caps.measure(caps.Truth(()), np.random.default_rng(2), 0.0, "rich"))
    thick = next(one for one in read if one.kind == "thickness")
    there = [replace(thick, kind=kind) for kind in ("thickness", "formed")]
    problem = pose(blind_press.told(), there, 0.1, [])[0]
    own = np.array([one.value for one in problem.own])
    pressed, whole, half, stretched = (
        problem.predict(own, terms)[problem.channel == channel]
        for channel, terms in (
            (0, {}),
            (1, {}),
            (1, {"set": ("share", np.array([0.5]))}),
            (1, {"set": ("with strain", np.array([0.5, -0.2]))}),
        )
    )
    np.testing.assert_allclose(whole, 4.5, rtol=1e-12)
    np.testing.assert_allclose(half, 0.5 * (pressed + 4.5), rtol=1e-12)
    strain = (4.5 - pressed) / 3.5
    np.testing.assert_allclose(stretched, 4.5 - (0.5 - 0.2 * strain) * strain * 3.5, rtol=1e-12)


def of_contact(effects: tuple[str, ...], seed: int) -> Finding:
    """Return what is found of ones and zeros at 120 places of caps that have ``effects``."""
    truth = caps.draw(np.random.default_rng([seed, 5]), effects)
    case = blind_press.posed(truth, 1.0, ["next contact"], seed)
    return close_rounds(case.problem, case.noise, design=False)[1]


@pytest.mark.parametrize("seed", [pytest.param(3, marks=pytest.mark.slow), 4])
def test_an_edge_of_contact_that_lies_elsewhere_is_no_noise(seed: int) -> None:
    """Of spherical caps a tilt is a shift, and much like a wedge of foam: one stands for the others."""
    found = of_contact(("tilt",), seed)
    assert found.verdict == "ambiguous"
    assert "tilt" in found.indistinguishable[0]


@pytest.mark.slow
def test_ones_and_zeros_of_a_press_as_it_is_are_noise_at_the_edge_alone() -> None:
    for seed in range(4):
        found = of_contact((), seed)
        assert (found.verdict, found.after.ids) == ("noise", ())
        sd = found.noise.sd[: len(found.after.problem.states["x_mm"])]
        assert np.median(sd) < 0.11
        assert sd.max() > 0.3


@pytest.mark.parametrize("astray", [0, 20])
def test_of_many_places_so_many_are_astray_as_the_readings_show(astray: int) -> None:
    """Where none of 2000 is, one hundredth would hide an edge that lies elsewhere."""
    gap = np.linspace(-1.0, 1.0, 2000)
    read = (gap < 0.0).astype(float)
    read[np.random.default_rng(1).choice(500, astray, replace=False)] = 0.0
    places = np.stack([gap, gap**2, 0.0 * gap], axis=1)
    rows = Reading("paste.csv", "contact", read, places=places).guess(ndtr(-gap / CONTACT_BLUR)).rows
    assert rows is not None
    assert rows[0] == pytest.approx(0.0995 if astray else np.sqrt(5e-4), rel=0.02)


def test_noise_is_lowered_as_long_as_an_entry_points_at_less(monkeypatch: pytest.MonkeyPatch) -> None:
    """The entry takes a richer form in less noise, and only that one's leaves so little that it is named."""

    def close(problem: object, *, noise: SimpleNamespace, **_: object) -> SimpleNamespace:
        named = noise.sd[0] < 1.5
        after = SimpleNamespace(ids=("tilt",) if named else (), fit=SimpleNamespace(predicted=np.zeros(1)))
        return SimpleNamespace(verdict="effect" if named else "noise", after=after, noise=noise, scores={"tilt": 10.0})

    def halved(problem: object, found: SimpleNamespace, noise: object) -> SimpleNamespace:
        return SimpleNamespace(sd=0.5 * found.noise.sd)

    monkeypatch.setattr(finalise, "close", close)
    monkeypatch.setattr(finalise, "_pointed", halved)
    found: Any = close_rounds(None, lambda problem, predicted: SimpleNamespace(sd=np.array([4.0])))[1]  # type: ignore
    assert (found.verdict, found.noise.sd[0]) == ("effect", 1.0)


NEW = [
    ("rich", "fabric-compression"),
    ("gauged", "lateral-shift"),
    ("hot", "foam-softening"),
    ("opened", "set"),
]


def test_a_film_shows_nothing_below_the_least_it_can() -> None:
    """Of pressures that fall off to nothing a film with a floor lacks those below it; one that has none reads them."""
    read = np.linspace(-0.5, 1.0, 91)
    assert Reading("film", "pressure", np.where(read < read[43], 0.0, read)).least == read[43]
    assert Reading("fine", "pressure", np.maximum(read, 0.0)).least == 0.0
    assert Reading("all", "pressure", 0.2 + np.abs(read)).least == 0.0
    assert Reading("paste", "contact", (read > 0.2).astype(float)).least == 0.0


@pytest.mark.parametrize(("count", "assumed"), [(7, True), (12, True), (60, False)])
def test_few_places_make_no_film_louder_than_is_usual(count: int, assumed: bool) -> None:
    """What few places differ by is what presses there; many that have no field show what the film scatters by."""
    random = np.random.default_rng(count)
    values = np.append(random.uniform(0.2, 1.8, count), np.zeros(20))
    film = Reading("film", "pressure", values, places=random.uniform(-50.0, 50.0, (count + 20, 3)))
    guess = film.guess(np.ones(count + 20))
    assert guess.is_assumed is assumed
    assert (guess.size > 0.2) is not assumed


@pytest.mark.parametrize(("share", "noise"), [(1.0, True), (0.5, False)])
def test_places_that_nothing_presses_hide_no_misfit_of_the_few_that_are_pressed(share: float, noise: bool) -> None:
    random = np.random.default_rng(5)
    whole = blind_press.as_readings(caps.measure(caps.Truth(()), random, 0.0, "film"))[0]
    shown, none = np.flatnonzero(whole.values > 0.2 * np.max(whole.values))[:6], np.flatnonzero(whole.values == 0.0)
    film = whole.rows(np.concatenate([shown[::2], none[:20]]))
    problem = pose(blind_press.told(), [replace(film, values=share * film.values)], 0.1, [])[0]
    level = Files(problem.files).noise(problem, None)
    judged = judge(problem, level, fit(problem, level, {}, problem.given), [])
    assert (judged.p_lack_of_fit > ALPHA / 3.0) is noise


def off_axis() -> tuple[Reading, Reading]:
    """A press whose molds stand off each other's axis, as a film reads it, and as one does that has a floor."""
    random = np.random.default_rng([2, sum(map(ord, "lateral-shift"))])
    truth = caps.draw(random, ("lateral-shift",), 1.0)
    whole = blind_press.as_readings(caps.measure(truth, np.random.default_rng([2, 0, 1]), 1.0, "film"))[0]
    floor = 0.2 * float(np.max(whole.values))
    return whole, replace(whole, values=np.where(whole.values < floor, 0.0, whole.values))


def test_where_a_film_reads_nothing_its_floor_may_press() -> None:
    whole, film = (pose(blind_press.told(), [one], 0.1, [])[0] for one in off_axis())
    least = off_axis()[1].least
    assert least > 0.0
    shown = np.where(film.measured == 0.0, np.maximum(whole.delivered - least, 0.0), whole.delivered)
    assert film.delivered == pytest.approx(shown, abs=1e-12)
    assert np.any(shown < whole.delivered)


@pytest.mark.slow
def test_what_a_film_cannot_show_speaks_for_no_effect() -> None:
    """The zeros below its floor, taken as they stand, say tilt."""
    film = off_axis()[1]
    problem = pose(blind_press.told(), [film], 0.1, [])[0]
    _, found = close_rounds(problem, Files([film]).noise)
    assert found.after.ids == ("lateral-shift",)


@pytest.mark.slow
@pytest.mark.parametrize(("protocol", "effect"), NEW, ids=[row[1] for row in NEW])
def test_a_truth_by_other_formulas_is_named(protocol: str, effect: str) -> None:
    case = blind_press.case((effect,), 0, protocol, 1.0, 0.7)
    _, found = close_rounds(case.problem, case.noise)
    assert (found.verdict, found.after.ids) == ("effect", (effect,))
