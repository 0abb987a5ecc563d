"""Names that no other test can foretell, on two straight lines of which the second has a bump, and a step in it; and
forms that the data do not tell."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.loop import no_worse
from hyperfab.loop.engine import close
from hyperfab.loop.judge import Evidence
from hyperfab.loop.problem import Constant, Curve, Effect, Form, Problem

ROWS, SD = 120, 0.05
X = np.linspace(0.0, 1.0, ROWS)
NONE = np.zeros(ROWS)
SHAPES = {"bump": np.exp(-0.5 * ((X - 0.4) / 0.1) ** 2), "step": np.tanh((X - 0.75) / 0.03)}
#: What no entry has.
RIPPLE = np.sin(40.0 * X)


class TwoLines(Problem):
    """Twice ``a + b x``; each entry is in the second line alone, as a joint between two probes is in the farther."""

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        second = sum((values[0] * SHAPES[name] for name, (_, values) in terms.items()), start=NONE)
        line = own[0] + own[1] * X
        return np.concatenate([line, line + second])


def entry(name: str) -> Effect:
    form = Form("one", (Constant("size", 0.0, -10.0, 10.0, 0.1),), ((0.3,),), ((0.01,),))
    return Effect(name, name, "", "", (form,))


def two_lines(bump: float, step: float, ripple: float) -> TwoLines:
    """The second line is off by so many standard deviations of the noise."""
    noise = np.random.default_rng(4).standard_normal(2 * ROWS)
    off = bump * SHAPES["bump"] + step * SHAPES["step"] + ripple * RIPPLE
    measured = np.tile(1.0 + 2.0 * X, 2) + SD * (noise + np.concatenate([NONE, off]))
    curves = (Curve("near", 0, ROWS, X), Curve("far", ROWS, 2 * ROWS, X))
    own = (Constant("a", 1.0, -10.0, 10.0), Constant("b", 2.0, -10.0, 10.0))
    return TwoLines(measured, curves, own, tuple(entry(name) for name in SHAPES))


def test_two_names_that_no_other_test_foretells_are_told_though_something_small_is_left() -> None:
    found = close(two_lines(60.0, 15.0, 3.0), noise=SD, design=False)
    assert found.verdict == "unexplained"
    assert set(found.after.ids) == {"bump", "step"}


@pytest.mark.parametrize("ripple", [8.0, 10.0])
def test_a_second_name_that_leaves_more_than_something_else_would_is_not_told(ripple: float) -> None:
    found = close(two_lines(60.0, 15.0, ripple), noise=SD, design=False)
    assert found.verdict == "unexplained"
    assert not found.after.ids


@pytest.mark.parametrize("certain", [True, False])
def test_a_richer_form_stands_in_only_where_the_data_tell_its_constants(
    certain: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wedge foretells forces worse than nothing does; a quadric of which nothing is sure foretells none."""

    def form(worse: bool) -> Any:
        return SimpleNamespace(ids=("thickness-variation",), worse=worse, fit=SimpleNamespace(cost=1.0))

    base, wedge, quadric = SimpleNamespace(ids=(), worse=False), form(True), form(False)
    wedge.fit.rich = quadric
    search: Any = SimpleNamespace(
        problem=SimpleNamespace(channel=np.array([0, 1])),
        richer=lambda simple, free: [simple.rich],
        state=lambda fitted: fitted,
        without=lambda state, name: base,
        evidence=lambda smaller, larger: Evidence(460.0, 1.0, None, certain=certain),
    )
    monkeypatch.setattr(no_worse, "held", lambda search, base, state, apart: state)
    monkeypatch.setattr(no_worse, "is_no_worse", lambda base, state, apart: not state.worse)
    found = no_worse.of_same_names(search, base, wedge, None)  # type: ignore[arg-type]
    assert found is (quadric if certain else None)
