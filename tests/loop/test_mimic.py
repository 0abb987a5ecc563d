"""Rivals: constants that have gone further than what is known of them allows make a finding less sure."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.loop import confounding, engine
from hyperfab.loop.belief import Belief
from hyperfab.loop.confounding import is_strained
from hyperfab.loop.engine import close
from hyperfab.loop.problem import Constant, Curve, Effect, Form, Problem
from hyperfab.loop.search import Search

PLACE = np.linspace(0.0, 1.0, 60)


class Saturating(Problem):
    """Readings around a level; one effect saturates, another is the same by another name, the third is a slope."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the level and what the terms add: little of the first two is nothing like much of them."""
        found = np.full(len(self.measured), own[0])
        for name, (_, values) in terms.items():
            x = np.concatenate([PLACE, PLACE])
            found = found + (values[0] * x if name == "slope" else np.tanh(values[0] * x**15))
        return found


def saturating(size: float) -> Saturating:
    def effect(name: str) -> Effect:
        form = Form("plain", (Constant("a", 0.0, 0.0, 1e9, 1e-2),), ((1.0,), (1e3,)), ((1e-2,),))
        return Effect(name, name, "nothing", "made up", (form,))

    curves = tuple(Curve(f"{k}", 60 * k, 60 * k + 60, PLACE) for k in range(2))
    own = (Constant("level", 0.0),)
    exact = Saturating(np.zeros(120), curves, own, tuple(effect(n) for n in ("one", "other", "slope")))
    noise = 0.01 * np.random.default_rng(1).standard_normal(120)
    exact.measured = exact.predict(np.array([1.0]), {"one": ("plain", np.array([size]))}) + noise
    return exact


@pytest.mark.parametrize(
    ("away", "strained"),
    [
        # Chi-squared of 6.25 of five constants is likely, of 32.5 it is not (p = 5e-6).
        ([0.5, -0.5, 2.0, 1.0, 0.87], False),
        ([4.0, -4.0, 0.0, 0.5, 0.5], True),
    ],
)
def test_constants_are_strained_by_their_chi_squared(away: list[float], strained: bool) -> None:
    own = [Constant(f"c{i}", 1.0, 0.0, 3.0, 0.1, prior_sd=0.1) for i in range(5)]
    free = Constant("free", 0.0, -9.0, 9.0, 1.0)
    problem: Any = SimpleNamespace(own=[*own, free])
    term = 7.0
    fit: Any = SimpleNamespace(x=np.array([*(1.0 + 0.1 * np.array(away)), 8.0, term]))
    assert is_strained(problem, fit) is strained


def test_constants_of_which_nothing_is_known_are_never_strained() -> None:
    problem: Any = SimpleNamespace(own=[Constant("C10_MPa", 0.0, -9.0, 9.0, 1.0)])
    fit: Any = SimpleNamespace(x=np.array([5.0]))
    assert not is_strained(problem, fit)


@pytest.mark.parametrize("size", [0.5, 1e4])
def test_look_alike_is_flagged_however_large_the_effect(size: float) -> None:
    found = close(saturating(size), noise=0.01, design=False)
    assert found.verdict == "ambiguous"
    assert [set(one) for one in found.indistinguishable] == [{"one", "other"}]


@pytest.mark.parametrize(
    ("chances", "left"),
    [
        ({"ab": 0.3, "a": 0.6}, "a"),
        ({"ab": 0.5, "a": 0.2, "b": 0.2}, "ab"),
        # In other company it is as likely as here; what stands in its place says nothing.
        ({"ab": 0.2, "a": 0.3, "bc": 0.2}, "ab"),
        ({"ab": 0.2, "a": 0.1, "ac": 0.6}, "ab"),
        ({"abc": 0.1, "ab": 0.15, "a": 0.7}, "a"),
        ({"a": 0.2}, "a"),
    ],
)
def test_a_name_goes_that_is_less_likely_than_the_others_without_it(
    chances: dict[str, float], left: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    judgement = SimpleNamespace(is_small=False)
    states = [SimpleNamespace(ids=tuple(ids), judgement=judgement) for ids in chances]
    search: Any = SimpleNamespace(states=states, without=lambda best, name: None)
    search.of_names = partial(Search.of_names, search)
    sure = Belief({frozenset(ids): p for ids, p in chances.items()}, 0.0, 0.0)
    monkeypatch.setattr(engine, "surprise", lambda state: 0.0)
    monkeypatch.setattr(engine, "explains", lambda before, state: True)
    best: Any = states[0]
    assert "".join(engine._likely(search, best, best, lambda: sure).ids) == left


@pytest.mark.parametrize(
    ("chances", "told"),
    [
        ({"ab": 0.6, "ac": 0.3}, {"a": [], "b": ["c"]}),
        ({"ab": 0.6, "ac": 0.1}, {"a": [], "b": []}),
        # A second name that could go says nothing, and nothing can stand for it.
        ({"a": 0.5, "ab": 0.2, "ac": 0.2}, {"a": [], "b": []}),
        ({"ab": 0.5, "c": 0.3}, {"a": ["c"], "b": []}),
        ({"ab": 0.5, "bc": 0.2, "bd": 0.2}, {"a": ["c", "d"], "b": []}),
    ],
)
def test_another_name_is_told_beside_the_one_it_could_stand_for(
    chances: dict[str, float], told: dict[str, list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    states = [SimpleNamespace(ids=tuple(ids)) for ids in chances]
    search: Any = SimpleNamespace(states=states)
    best: Any = states[[one.ids for one in states].index(("a", "b"))]
    sure = Belief({frozenset(ids): p for ids, p in chances.items()}, 0.0, 0.0)
    monkeypatch.setattr(confounding, "surprise", lambda state: -chances["".join(state.ids)])
    found = confounding._as_likely(search, best, sure)
    assert {name: list(others) for name, others in found.items()} == told


@pytest.mark.parametrize(("less_likely", "free", "told"), [(3.5, True, True), (4.5, True, False), (4.5, False, True)])
def test_a_law_of_free_shape_stands_for_a_name_by_what_it_leaves_too(
    less_likely: float, free: bool, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As good by BIC and of nearly the same imprint, but at odds of ninety to one: no rival if its shape is free."""
    search: Any = SimpleNamespace(problem=SimpleNamespace(well_known=False, describes=True), noise=None)
    fit = SimpleNamespace(forms={"other": SimpleNamespace(free=free)})
    best, other = (SimpleNamespace(fit=fit, ids=(), surprise=one) for one in (1.0, 1.0 + less_likely))
    monkeypatch.setattr(confounding, "_gap", lambda *given: 0.0)
    monkeypatch.setattr(confounding, "_misfit", lambda *given: 0.0)
    monkeypatch.setattr(confounding, "surprise", lambda state: state.surprise)
    assert confounding.does_the_same(search, best, other, lambda: 1.0) == told  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("describes", "gap", "away", "more", "told"),
    [
        (False, 12.0, 0.0, 2, True),
        (False, 18.0, 0.0, 1, False),
        (False, 12.0, 6.0, 1, False),
        (False, 12.0, 0.0, 3, False),
        (False, 12.0, 0.0, 0, False),
        (True, 18.0, 6.0, 3, True),
    ],
)
def test_a_law_of_physics_that_is_as_likely_is_told_where_it_nearly_pays(
    describes: bool, gap: float, away: float, more: int, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A specific heat that changes was named alone at 0.31, a heater that fades at 0.21 with two constants more."""
    own = [Constant("c", 0.0, prior_sd=1.0)]
    problem = SimpleNamespace(describes=describes, own=own, effect=lambda name: SimpleNamespace(of_document=False))
    best, other = (
        SimpleNamespace(ids=("one",), fit=SimpleNamespace(x=np.array(x), forms={}))
        for x in ([0.0], [away, *[1.0] * more])
    )
    monkeypatch.setattr(confounding, "_tried_instead_of", lambda *given: {})
    monkeypatch.setattr(confounding, "_never_told_from", lambda *given: [])
    monkeypatch.setattr(confounding, "_as_likely", lambda *given: {"one": {"other": other}})
    monkeypatch.setattr(confounding, "_gap", lambda *given: gap)
    search: Any = SimpleNamespace(problem=problem, noise=None)
    found = confounding.rivals(search, best, lambda: None)  # type: ignore[arg-type, return-value]
    assert list(found["one"]) == ["other"] * told


X, Y = np.random.default_rng(5).uniform(-1.0, 1.0, (2, 160))


class Plan(Problem):
    """Readings over a square: a polynomial of one name does what two others do together."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the level and what the terms add."""
        shapes = {"turn": [Y], "share": [X**2], "uneven": [X, Y, X**2, X * Y, Y**2]}
        found = own[0] + np.zeros(len(X))
        for name, (_, values) in terms.items():
            found = found + sum(value * shape for value, shape in zip(values, shapes[name], strict=False))
        return np.asarray(found)


def plan(truth: Mapping[str, tuple[str, Array]]) -> Plan:
    def form(name: str, count: int, simpler: str | None = None) -> Form:
        constants = tuple(Constant(f"{name}{k}", 0.0, -9.0, 9.0, 0.1) for k in range(count))
        return Form(name, constants, ((0.1,) * count,), ((0.1,) * count,), refines=simpler)

    def effect(name: str, *forms: Form) -> Effect:
        return Effect(name, name, "nothing", "made up", forms)

    effects = (
        effect("turn", form("plain", 1)),
        effect("share", form("plain", 1)),
        effect("uneven", form("plain", 1), form("rich", 5, "plain")),
    )
    curves = tuple(Curve(f"{k}", 40 * k, 40 * k + 40, np.arange(40.0)) for k in range(4))
    exact = Plan(np.zeros(160), curves, (Constant("level", 1.0),), effects)
    exact.measured = exact.predict(np.array([1.0]), truth) + 0.02 * np.random.default_rng(1).standard_normal(160)
    return exact


@pytest.mark.parametrize(
    "truth",
    [
        {"turn": ("plain", np.array([0.5])), "share": ("plain", np.array([0.4]))},
        {"uneven": ("rich", np.array([0.4, 0.3, 0.4, 0.3, -0.3]))},
    ],
    ids=["two", "one"],
)
def test_a_form_of_many_constants_does_not_stand_for_two_names_of_one_each(
    truth: dict[str, tuple[str, np.ndarray]],
) -> None:
    found = close(plan(truth), noise=0.02, design=False)
    assert found.verdict == "effect"
    assert set(found.after.ids) == set(truth)
