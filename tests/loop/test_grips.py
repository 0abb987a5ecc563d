"""Grips that give with the load, by a law of their own: found from tests of several modes."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import close
from hyperfab.loop.fabric import fabric_problem
from hyperfab.materials import law
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.grip_slack import given
from hyperfab.materials.effects.path import Path

#: Stress of a neo-Hookean sheet over its modulus, by mode.
STRESS = {
    "uniaxial": lambda s: s - s**-2,
    "shear": lambda s: s - s**-3,
    "biaxial": lambda s: s - s**-5,
}


@pytest.mark.parametrize(
    ("gives", "form"),
    [
        (lambda share: share, "yields"),
        (lambda share: -np.expm1(-share / 0.25), "yields-curved"),
    ],
    ids=["evenly", "less and less"],
)
def test_grips_that_give_with_the_load_are_found_with_their_law(gives, form) -> None:
    random = np.random.default_rng(3)
    stretch = np.linspace(1.0, 1.6, 40)
    top = max(stress(1.6) for stress in STRESS.values())
    tests = []
    for mode, stress in STRESS.items():
        for number in range(2):
            load = stress(stretch)
            read = stretch + 0.04 * gives(load / top)
            noisy = load * (1.0 + random.normal(0.0, 0.002)) + random.normal(0.0, 0.002, len(load))
            tests.append(TestCurve(mode, read, noisy, source=f"{mode} {number}", specimen=f"{mode} {number}"))
    found = close(fabric_problem(law("neo-hookean"), [0.5], tests), design=False)
    assert found.after.ids == ("grip-slack",)
    told = found.after.fit.forms["grip-slack"]
    assert told.name == form
    constants = told.named(found.after.fit.x[found.after.fit.place("grip-slack")])
    assert constants["give"] == pytest.approx(0.04 * gives(1.0), rel=0.1)


def test_specimens_each_mounted_with_a_slack_of_their_own_are_told_by_what_they_differ_by() -> None:
    """A slack that all had would be another law of so soft a start: it does not show, what they differ by does."""
    random, slack = np.random.default_rng(6), [0.002, 0.028, 0.014, 0.04]
    lam = np.linspace(1.0, 1.5, 40)
    tests = []
    for number, own in enumerate(slack):
        e = np.maximum(lam - 1.0 - own, 0.0)
        toe = np.logaddexp(0.0, (e - 0.2) / 0.06) - np.log1p(np.exp(-0.2 / 0.06))
        stress = 0.05 * (1.0 + 0.02 * random.standard_normal()) * toe + 2e-4 * random.standard_normal(40)
        tests.append(TestCurve("uniaxial", lam, stress, source=f"{number}", specimen=f"{number}"))
    found = close(fabric_problem(law("yeoh-3"), (0.02, 0.02, 0.01), tests), design=False)
    assert found.verdict == "effect"
    form, values = found.after.fit.terms["grip-slack"]
    assert form == "each"
    assert values[1:] == pytest.approx(np.array(slack[1:]) - slack[0], abs=0.006)


@pytest.mark.parametrize(("seed", "width", "noise"), [(2, 0.012, 0.001), (1, 0.02, 0.002)])
def test_play_of_each_specimen_ends_as_roundly_as_that_of_all(seed: int, width: float, noise: float) -> None:
    """Another length hangs loose of each, and is taken up over a strain: no law of the cloth has to make up for it."""
    random, tests = np.random.default_rng(seed), []
    loose = random.uniform(0.01, 0.05, 6)
    for number, slack in enumerate(loose):
        mode = "uniaxial" if number < 4 else "shear"
        strain = np.linspace(0.0, 0.5, 60)
        pulled = width * (np.logaddexp(0.0, (strain - slack) / width) - np.log1p(np.exp(-slack / width)))
        load = 0.4 * STRESS[mode](1.0 + pulled) * (1.0 + 0.5 * pulled)
        noisy = load + random.normal(0.0, noise, len(load))
        tests.append(TestCurve(mode, 1.0 + strain, noisy, source=f"{number}", specimen=f"{number}"))
    found = close(fabric_problem(law("yeoh-3"), [0.2, 0.01, 0.01], tests), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("grip-slack",))
    form, values = found.after.fit.terms["grip-slack"]
    assert form == "each-toe"
    # So far as it is above the width: a shorter one is half taken up at rest.
    assert values[1:-1] == pytest.approx(loose[1:] - loose[0], abs=0.25 * width + 0.002)


@pytest.mark.parametrize("seed", range(3))
def test_strips_mounted_askew_are_taut_the_later_and_the_more_slowly_the_more_they_are(seed: int) -> None:
    """One edge is taut before the other: threads across the width begin to bear one after another."""
    random, tests = np.random.default_rng(seed), []
    askew = 0.1 * random.rayleigh(0.7, 6)
    strain, across = np.linspace(0.0, 0.5, 60), (np.arange(50) + 0.5) / 50.0
    for number, longer in enumerate(askew):
        pulled = np.maximum(1.0 + strain[:, None] - longer * across, 1.0)
        load = 0.4 * np.mean(STRESS["uniaxial"](pulled) * (0.5 + 0.5 * pulled), axis=1)
        noisy = load + random.normal(0.0, 0.0005, len(load))
        tests.append(TestCurve("uniaxial", 1.0 + strain, noisy, source=f"{number}", specimen=f"{number}"))
    found = close(fabric_problem(law("yeoh-3"), [0.2, 0.01, 0.01], tests), design=False)
    assert (found.verdict, found.after.ids) == ("effect", ("grip-slack",))
    form, values = found.after.fit.terms["grip-slack"]
    assert form == "each-askew"
    assert values[1:-1] == pytest.approx(0.5 * (askew[1:] - askew[0]), abs=0.006)


def test_a_specimen_is_not_let_go_while_its_grips_part() -> None:
    """Whatever a smooth law has the grips give: the strain of the specimen does not fall as that read rises, but for
    what a law bends by between two of the 401 places it is asked at; where it rises by itself it is left as it is."""
    reach, stretch = 0.6, np.linspace(1.0, 1.8, 5000)
    falls = []
    for random in map(np.random.default_rng, range(200)):
        values = random.uniform(-0.1, 0.6, 6) * reach
        falls.append(np.min(np.diff(given(stretch, reach, values))) / reach)
    assert min(falls) > -1e-3
    slack = 0.05 * np.arange(1, 7) / 6.0
    place = np.log1p(20.0 * (stretch - 1.0) / reach) / np.log1p(20.0)
    np.testing.assert_allclose(
        given(stretch, reach, slack), 1.0 + np.maximum(stretch - 1.0 - 0.05 * place, 0.0), atol=1e-12
    )


@pytest.mark.parametrize(("lengths", "verdict"), [((50.0, 200.0), "effect"), ((50.0, 50.0), "ambiguous")])
def test_what_grips_give_is_a_length_which_specimens_of_two_lengths_tell_from_another_law(
    lengths: tuple[float, float], verdict: str
) -> None:
    """Rubber faces that give 3 mm, less and less: 6 % of strips of 50 mm, 1.5 % of strips of 200 mm."""
    random = np.random.default_rng(5)
    lam, tests = np.linspace(1.0, 1.5, 50), []
    for number, length in enumerate((*lengths, *lengths)):
        load = 0.2 * STRESS["uniaxial"](lam)
        read = lam + 3.0 / length * -np.expm1(-load / 0.07)
        noisy = load * (1.0 + 0.01 * random.standard_normal()) + 8e-4 * random.standard_normal(50)
        name = f"{number}"
        tests.append(TestCurve("uniaxial", read, noisy, gauge_length_mm=length, source=name, specimen=name))
    found = close(fabric_problem(law("neo-hookean"), [0.1], tests), design=False)
    assert found.verdict == verdict
    assert "grip-slack" in {*found.after.ids, *(name for one in found.indistinguishable for name in one)}
    if verdict == "effect":
        assert found.after.ids == ("grip-slack",)
        # One law of what they give for both lengths, with no slack of each.
        assert not found.after.fit.forms["grip-slack"].of_each, found.after.fit.terms


def test_play_is_a_length_and_a_zero_of_the_cell_a_force() -> None:
    """Of the first specimen whose size is stated: the second is four times as long and twice as thick."""
    stretch, unknown = np.array([1.05, 1.3, 1.05, 1.3]), np.full(4, np.nan)
    pulls = Path(
        (0, 2, 4), np.zeros(4, int), stretch, unknown, unknown, unknown, unknown, np.ones(4, int),
        lengths_mm=(50.0, 200.0), sections=(10.0, 20.0),
    )  # fmt: skip
    fabric = Fabric(law("neo-hookean"), pulls)

    def at(slack: float, offset: float) -> np.ndarray:
        terms = {"grip-slack": ("play", np.array([slack])), "load-offset": ("constant", np.array([offset]))}
        return fabric.stress(np.array([0.5]), None, terms)

    own = np.array([1.01, 1.26, 1.04, 1.29])
    np.testing.assert_allclose(at(0.04, 0.02), own - own**-2 + np.array([0.02, 0.02, 0.01, 0.01]), rtol=1e-12)


@pytest.mark.parametrize("form", ["smooth", "smooth-force", "smooth-slip"])
def test_grips_take_nothing_back_while_the_pull_goes_on(form) -> None:
    """What rises with a rising load does not fall: one that does is another law of the specimen."""
    up = np.linspace(1.0, 1.5, 30)
    lam = np.concatenate([up, up[-2::-1]])
    problem = fabric_problem(law("neo-hookean"), (0.2,), [TestCurve("uniaxial", lam, lam - lam**-2)])

    def back(gives) -> float:
        along = problem.effect("grip-slack").form(form).constants[0].value
        asked = problem.forbidden(np.array([0.2]), {"grip-slack": (form, np.array([along, *gives]))})
        return max(beyond for name, beyond in asked.items() if "take back" in name)

    assert back((0.0, 0.01, 0.02, 0.02, 0.03, 0.04)) <= 0.0
    # 0.05 less than before, of a strain of 0.5.
    assert back((0.02, 0.04, 0.1, 0.05, 0.06, 0.07)) == pytest.approx(0.1)
