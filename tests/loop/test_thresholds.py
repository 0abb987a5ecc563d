"""Each number the loop decides by: a case below it and one above it, and a page that says what it stands for."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from loop.test_honest import posed, pulled, rubber
from loop.test_kernels import DESIGN, SD, WHITE, X, line
from scipy.optimize import brentq
from scipy.stats import chi2, norm

from hyperfab.chapters.close_loop import readings
from hyperfab.chapters.close_loop.domain import Given
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.loop import (
    confounding,
    doubt,
    engine,
    fabric_tests,
    fewest,
    heldout,
    judge,
    replicates,
    scatter,
    thresholds,
    upstream,
)
from hyperfab.loop.belief import belief, outweighs_something_else
from hyperfab.loop.design import NextMeasurement
from hyperfab.loop.heldout import HeldOut, Help, help_of
from hyperfab.loop.judge import Evidence, Judgement
from hyperfab.loop.noise import Noise
from hyperfab.loop.noise_estimate import estimate_noise
from hyperfab.loop.problem import Constant, Curve
from hyperfab.loop.scatter import Guess
from hyperfab.loop.search import Search

NAMES = [name for name in vars(thresholds) if name.isupper()]
PAGE = Path(__file__).parents[2] / "docs" / "close-loop-thresholds.md"


def judged(structured: float, p: float = 0.0) -> Judgement:
    return Judgement(1.0, structured, structured, p, p, p)


def evidence(bic: float = 99.0, share: float = 0.9, help: Help | None = None) -> Evidence:
    return Evidence(bic, share, help, certain=True)


def explained(before: float, left: float) -> bool:
    return engine.explains(*(SimpleNamespace(judgement=judged(one)) for one in (before, left)))  # type: ignore[arg-type]


def suspects(probability: float) -> tuple[str, ...]:
    shares = {"foam": probability, upstream.ELSE: 1.0 - probability, upstream.STATED: 0.0}
    return upstream._suspects(shares)


def judged_alone(rows: int) -> bool:
    """Whether a test of so many rows that misses by ten standard deviations is seen by itself."""
    left = SimpleNamespace(residual=np.full(rows, 10.0))
    noise = Noise(np.ones(rows), np.inf, "")
    return judge._worst_by_chance(left, noise, [Curve("t", 0, rows, np.arange(rows))]) < 0.5  # type: ignore[arg-type]


def read(rows: int) -> bool:
    given = SimpleNamespace(layout=None, case=SimpleNamespace(readings=["a.csv"], held=[], noise=None))
    try:
        one = SimpleNamespace(values=np.zeros(rows), kind="force")
        readings.read_files(None, given, lambda *asked: [one], ("force",))  # type: ignore[arg-type,return-value]
    except InputError:
        return False
    return True


def sd_of(rows: int) -> float:
    """The noise of two smooth curves, in shares of their peaks."""
    tests = [
        pulled(lambda l, k=k: k * rubber(l), rows=rows, noise=0.0, direction=90.0 * (k - 1), name=f"{k}")
        for k in (1, 2)
    ]
    problem = posed(tests, "neo-hookean")
    return float(estimate_noise(problem).sd[-1] / np.max(problem.measured))


def in_proportion(gain: float) -> bool:
    """Whether noise in proportion is claimed where it makes the readings so much likelier."""
    rng = np.random.default_rng(0)
    level = np.linspace(1.0, 100.0, 60)
    base = rng.standard_normal(60)

    def claimed(power: float) -> tuple[float, Guess]:
        found = base * level**power
        guess = Guess(scatter._size(found), 30.0, "", found, level)
        costs = []
        for ratio in scatter._RATIOS:
            shape = np.hypot(1.0, ratio * level / 100.0)
            size = scatter._size(found / shape)
            left = np.minimum(np.abs(found) / (size * shape), 3.0)
            costs.append(scatter._WORTH * float(np.sum(2.0 * np.log(size * shape) + left**2)))
        return costs[0] - min(costs), guess

    power = brentq(lambda one: claimed(one)[0] - gain, 0.0, 1.5, xtol=1e-4)
    return int(np.argmax(scatter.likely_ratios([claimed(float(power))[1]], 100.0))) > 0


def alike(p: float) -> bool:
    """Whether two levels of noise that chance would make so different with probability ``p`` count as the same."""
    dof = np.array([20.0, 20.0])

    def chance(ratio: float) -> float:
        sizes = np.array([1.0, ratio])
        gap = 40.0 * np.log(np.mean(sizes**2)) - 20.0 * np.sum(np.log(sizes**2))
        return float(chi2.sf(gap / (1.0 + (0.1 - 0.025) / 3.0), 1))

    ratio = brentq(lambda one: np.log(chance(one) / p), 1.01, 20.0)
    return scatter.alike(np.array([1.0, ratio]), dof)


def pair(gain: float, offset: float = 0.0) -> tuple[Any, Noise, float]:
    """Two replicates that differ by a gain, in standard deviations of it; the noise told, and that deviation."""
    lam = np.linspace(1.0, 1.5, 60)
    stress, sd = rubber(lam), 0.02
    one_sd = sd / float(np.sqrt(np.sum(stress**2)))
    tests = [
        TestCurve("uniaxial", lam, stress * (1.0 + sign * 0.5 * gain * one_sd), source=f"{k}", specimen=f"{k}")
        for k, sign in enumerate((-1.0, 1.0))
    ]
    problem = posed(tests)
    return problem, estimate_noise(problem, sd), one_sd


def beyond(variances: float) -> bool:
    """Whether a difference whose half square is so many variances counts."""
    return pair(np.sqrt(2.0 * variances))[1].gain_doubt > 0.0


def offset_told(gained: float) -> bool:
    level = np.linspace(0.1, 1.0, 50)
    ones, slope = np.ones(50), np.gradient(level)
    left = ones - level * float(level @ ones) / float(level @ level)
    size = np.sqrt(gained / float(left @ left))
    return len(replicates.told_apart(size * ones, level, (ones, slope**2))[0]) == 2


def scatter_tried() -> float:
    """The likeliest scatter, over what replicates say it may be, of sheets that differ threefold between directions."""
    tests = [
        pulled(lambda l, k=k: k * rubber(l), rows=30, noise=1e-3, seed=10 * k + n, direction=a, name=f"{a} {n}")
        for k, a in ((1, 0.0), (3, 90.0))
        for n in range(2)
    ]
    problem = posed(tests)
    search = Search(problem, estimate_noise(problem))
    known = Noise(**{**vars(search.noise), "gain_sd": 0.02, "gain_doubt": 0.032})
    search = Search(problem, known)
    return doubt.likeliest_scatter(search, search.base())[1] / 0.032


def cloth(share: float) -> str:
    """The verdict on specimens that differ by so much, none of them led alike."""
    tests = [
        pulled(
            lambda l, g=1.0 + share * way: g * rubber(l),
            rows=40,
            seed=k,
            noise=1e-3,
            direction=a,
            degrees=20 + k,
            name=f"{k}",
        )
        for k, (a, way) in enumerate(zip((0.0, 90.0, 0.0, 90.0, 0.0, 90.0), (1, 1, -1, -1, 0.6, -0.6), strict=True))
    ]
    return engine.close(posed(tests), design=False).verdict


def follow(share: float) -> bool:
    """Whether softening is named of four specimens, none led alike, that differ by so much from cold to hot."""
    tests = [
        pulled(lambda l, g=1.0 + 0.5 * share * way: g * rubber(l), rows=40, seed=k, noise=1e-4, degrees=t, name=f"{k}")
        for k, (t, way) in enumerate(((20, 1.0), (25, 0.8), (55, -0.8), (60, -1.0)))
    ]  # fmt: skip
    return engine.close(posed(tests), design=False).after.ids == ("thermal-softening",)


def led_alike(share: float) -> bool:
    turned = (np.array([[0.4 * part, 0.0]]) for part in (1.0, 1.0 - share))
    return fabric_tests._is_same_way(*((one, np.zeros_like(one)) for one in turned))


def counts(sd: float) -> bool:
    """Whether a test counts whose prediction the others know to so many standard deviations."""
    here = DESIGN[:20]
    weight = np.sqrt(np.mean(np.sum(here**2, axis=1)))
    found = SimpleNamespace(
        jacobian=here, precision=here.T @ here + np.eye(2) * (weight / sd) ** 2, residual=np.zeros(20)
    )
    return heldout._without(found, slice(0, 20)) is not None  # type: ignore[arg-type]


def left_out(*tests: tuple[float, float], gone: float = 1.0) -> Help | None:
    """Help for tests that go from one rms to another, thirty rows each; a share ``gone`` of the gain lies in them."""
    places = tuple(slice(30 * k, 30 * k + 30) for k in range(len(tests)))

    def of(k: int) -> HeldOut:
        rms = np.array([one[k] for one in tests])
        return HeldOut(np.repeat(rms, 30), tuple(range(len(tests))), rms, places)

    rows = np.concatenate([np.full(30 * len(tests), gone / (30 * len(tests))), [1.0 - gone]])
    return help_of(of(0), of(1), rows)


def helped(*tests: tuple[float, float]) -> float:
    found = left_out(*tests)
    assert found is not None
    return found.helped


def strained(p: float) -> bool:
    away = float(norm.isf(0.5 * p))
    problem: Any = SimpleNamespace(own=[Constant("a", 0.0, prior_sd=1.0)], well_known=True)
    found: Any = SimpleNamespace(x=np.array([away]))
    return confounding.is_strained(problem, found)


def same(
    patch: pytest.MonkeyPatch, left: float = 0.01, whole: float = 100.0, p: float = 1.0, gap: float = 99.0
) -> bool:
    """Whether a rival does the same that misses an imprint of mean square ``whole`` by ``left``.

    Its constants are as far off as happens with probability ``p``; by BIC it does worse by ``gap``.
    """
    away = float(norm.isf(0.5 * p))
    problem = SimpleNamespace(own=[Constant("a", 0.0, prior_sd=1.0)], well_known=True, describes=False)
    search: Any = SimpleNamespace(problem=problem, noise=None)
    best, other = (
        SimpleNamespace(fit=SimpleNamespace(x=np.array([x]), residual=np.zeros(10), forms={}), ids=())
        for x in (0.0, away)
    )
    patch.setattr(confounding, "_misfit", lambda *given: 10.0 * left)
    patch.setattr(confounding, "_gap", lambda *given: gap)
    return confounding.does_the_same(search, best, other, lambda: 10.0 * whole)  # type: ignore[arg-type]


def rivals_asked(monkeypatch: pytest.MonkeyPatch, constants: int, cosine: float) -> list[int]:
    """The constants that a rival of a law with so many is allowed, if it is asked at all."""
    asked: list[int] = []
    other = SimpleNamespace(id="other")
    search = SimpleNamespace(
        problem=SimpleNamespace(well_known=False, describes=True), noise=None,
        without=lambda best, name: SimpleNamespace(fit=None),
        ranking=lambda state: [(other, 1.0)],
        with_term=lambda state, effect, most=99: asked.append(most),
    )  # fmt: skip
    form = SimpleNamespace(constants=range(constants))
    best = SimpleNamespace(ids=("one",), fit=SimpleNamespace(forms={"one": form}))
    monkeypatch.setattr(confounding, "_alike", lambda *given: {"one": 1.0, "other": cosine})
    confounding._tried_instead_of(search, best, "one")  # type: ignore[arg-type]
    return asked


def wrong(times: float) -> bool:
    """Whether the misfit of a line counts as noise where its mean square is so many times the noise's."""
    rng = np.random.default_rng(2)
    left = rng.standard_normal(len(X))
    left -= DESIGN @ np.linalg.lstsq(DESIGN, left, rcond=None)[0]
    problem = line(1.0 + 2.0 * X + SD * left * np.sqrt(times * len(X) / float(left @ left)))
    return Search(problem, WHITE).base().under is not None


def leaving(names: tuple[str, ...], left: float) -> Any:
    """A model with some names that leaves so much, in standard deviations of the noise, of a thousand readings."""
    problem = SimpleNamespace(
        curves=(Curve("t", 0, 1000, np.arange(1000.0)),),
        channel=np.zeros(1000, dtype=np.int64),
        effects=(SimpleNamespace(forms=(SimpleNamespace(free=True),)),),
        plain="",
    )
    chi2 = (1.0 + left**2) * 1000.0
    residual = np.full(1000, np.sqrt(chi2 / 1000.0))
    found = SimpleNamespace(residual=residual, jacobian=np.ones((len(residual), 1)), x=np.empty(0), chi2=chi2, forms={})
    noise = Noise(np.ones(len(residual)), np.inf, "stated")
    return SimpleNamespace(ids=names, problem=problem, noise=noise, fit=found, judgement=judged(min(left, 0.4)))


def as_likely(left: float) -> bool:
    """Whether a name that leaves so much of ten standard deviations is told beside one that leaves nothing."""
    base, one, other = leaving((), 10.0), leaving(("rate",), 0.0), leaving(("mullins",), left)
    states = [base, one, other]
    search: Any = SimpleNamespace(problem=base.problem, states=states)
    return bool(confounding._as_likely(search, one, belief(base, states, 8))["rate"])


def something_else(left: float) -> float:
    return belief(leaving((), 10.0), [leaving(("rate",), left)], 8).something_else


def outweighs(left: float) -> bool:
    """Whether a name no other test can foretell is given where it leaves so much of ten standard deviations."""
    return outweighs_something_else(leaving((), 10.0), leaving(("rate",), left))


def gave(share: float) -> bool:
    """Whether what a term gives counts where such a share of it lies in tests that can be left out."""
    return left_out((3.0, 1.0), (3.0, 1.0), gone=share) is not None


def test_what_richer_forms_cost_takes_no_names_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three names whose formulas come near leave less in richer forms, which cost more: one name that misses more than
    these formulas is still no nearer."""
    near, rich, alone = (SimpleNamespace(ids=ids, fit=None) for ids in (("a", "b", "c"), ("a", "b", "c"), ("a",)))
    cost = {id(near): 25.0, id(rich): 38.0, id(alone): 29.0}
    for name, told in {
        "explains": lambda before, state: False,
        "likeliest": lambda *_: None,
        "structured": lambda *_: 1.0,
        "surprise": lambda state: cost[id(state)],
        "_pays": lambda *_: True,
    }.items():
        monkeypatch.setattr(fewest, name, told)
    problem = SimpleNamespace(describes=True, plain="law")
    search: Any = SimpleNamespace(
        problem=problem, noise=None, states=[], enriched=lambda state: rich, freed=lambda before, ids, of=(): alone
    )
    found: Any = [fewest.fewest(search, leaving((), 10.0), one, {}, lambda state: True) for one in (near,)]
    assert found == [rich]
    cost[id(near)] = 36.0
    assert fewest.fewest(search, leaving((), 10.0), cast(Any, near), {}, lambda state: True) is alone


#: What is said below a number and above it; the cases lie within a factor of two of it on either side.
CASES: dict[str, tuple[Callable[[pytest.MonkeyPatch], Any], Any]] = {
    "ALPHA": (lambda _: [judged(9.0, p).is_noise for p in (0.0035, 0.007)], [False, True]),
    "SMALL": (
        lambda patch: [
            [judged(left).is_small for left in (0.3, 0.6)],
            [explained(100.0, left) for left in (0.5, 0.9)],
            [same(patch, left=left**2) for left in (0.3, 0.6)],
            [as_likely(left) for left in (0.1, 0.15)],
        ],
        [[True, False], [True, False], [True, False], [True, False]],
    ),
    "TOLD": (
        lambda _: [
            [beyond(one) for one in (3.0, 6.0)],
            [round(helped((9.0, 1.0), (3.0, 3.0 + d)), 1) for d in (0.3, 0.45)],
            [helped((9.0, 1.0), (1.0, top)) > 0.6 for top in (1.4, 2.6)],
            [wrong(times) for times in (3.0, 6.0)],
            1.4 < scatter_tried() <= 2.0,
        ],
        [[False, True], [1.0, 0.5], [True, False], [False, True], True],
    ),
    "UNLIKELY": (
        lambda patch: [
            [alike(p) for p in (0.7e-5, 1.4e-5)],
            [strained(p) for p in (0.7e-5, 1.5e-5)],
            [same(patch, p=p) for p in (0.7e-5, 1.5e-5)],
            [offset_told(gained) for gained in (18.7, 20.3)],
            [NextMeasurement("", {}, one).decisive for one in (18.7, 20.3)],
        ],
        [[False, True], [True, False], [False, True], [False, True], [False, True]],
    ),
    "FEWEST": (
        lambda _: [
            [judged_alone(rows) for rows in (6, 12)],
            [read(rows) for rows in (6, 12)],
            [as_likely(left) for left in (0.1, 0.15)],
        ],
        [[False, True], [False, True], [True, False]],
    ),
    "MACHINE": (lambda _: [sd_of(60), sd_of(4)] == pytest.approx([0.005, 0.02]), True),
    "ONE_CLOTH": (
        lambda _: [[cloth(share) for share in (0.08, 0.1)], [follow(share) for share in (0.08, 0.1)]],
        [["noise", "unexplained"], [False, True]],
    ),
    "PRIOR": (lambda _: Given({}, SimpleNamespace(prior=None), None, None).surely, 0.1),  # type: ignore[arg-type]
    "MARGIN": (
        lambda patch: [
            [evidence(bic=bic).pays(), in_proportion(bic), same(patch, left=30.0, gap=bic)] for bic in (6.0, 12.0)
        ],
        [[False, False, True], [True, True, False]],
    ),
    "SHARE": (
        lambda patch: [
            [evidence(share=one).pays() for one in (0.035, 0.075)],
            [evidence(help=Help(one, 1.0, 6)).pays() for one in (0.035, 0.075)],
            [explained(2.6, left) for left in (0.5, 0.64)],
            [same(patch, left=share, whole=1.0) for share in (0.035, 0.075)],
            [rivals_asked(patch, 3, one) for one in (0.035, 0.075)],
            [led_alike(share) for share in (0.035, 0.075)],
        ],
        [[False, True], [False, True], [True, False], [True, False], [[], [3]], [True, False]],
    ),
    "MOST": (
        lambda _: [
            [[evidence(help=Help(*of, 3)).accepted() for of in ((0.5, one), (one, 0.5))] for one in (0.4, 0.66)],
            [gave(one) for one in (0.4, 0.66)],
            [something_else(left) > 0.5 for left in (3.0, 4.0)],
            [outweighs(left) for left in (3.0, 4.0)],
        ],
        [[[False, False], [True, True]], [False, True], [False, True], [True, False]],
    ),
    "ODDS": (
        lambda _: [
            [as_likely(left) for left in (0.1, 0.15)],
            [suspects(p) for p in (0.65, 0.85)],
        ],
        [[True, False], [("foam", upstream.ELSE), ("foam",)]],
    ),
}  # fmt: skip


#: Read when a class is made: its case states the number itself.
AT_IMPORT = {"MACHINE"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name == "ONE_CLOTH" else ()) for name in NAMES]
)
def test_each_number_lies_between_its_cases_and_within_a_factor_of_two(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, said = CASES[name]
    assert case(monkeypatch) == said
    for factor in () if name in AT_IMPORT else (0.5, 2.0):
        given = getattr(thresholds, name)
        moved = type(given)(given * factor)
        for module in [one for key, one in sys.modules.items() if key.startswith("hyperfab.")]:
            if name in vars(module) and vars(module)[name] == given and module is not thresholds:
                monkeypatch.setattr(module, name, moved)
        monkeypatch.setattr(thresholds, name, moved)
        assert case(monkeypatch) != said, (name, factor, given)
        monkeypatch.undo()


def test_a_test_left_out_counts_where_the_others_know_it_better_than_a_reading_would() -> None:
    assert [counts(sd) for sd in (0.7, 1.4)] == [True, False]


def test_the_page_has_each_number_with_its_value() -> None:
    rows = re.findall(r"^\| `([A-Z_]+)` \| ([^ |]+) \| ([^|]+) \|$", PAGE.read_text(encoding="utf-8"), flags=re.M)
    assert {name: float(value) for name, value, _ in rows} == {name: getattr(thresholds, name) for name in NAMES}
    assert all(len(why) > 20 for _, _, why in rows)


def test_six_specimens_at_six_temperatures_are_no_softening_that_goes_up_and_down() -> None:
    """From 20 to 25 degC, 7 % apart as those of one cloth may be: a smooth curve of heat goes through all of them."""
    assert cloth(0.08) == "noise"
