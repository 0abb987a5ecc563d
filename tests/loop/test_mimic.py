"""Rivals: constants that have gone further than what is known of them allows make a finding less sure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hyperfab.loop.mimic import is_strained
from hyperfab.loop.problem import Constant


@pytest.mark.parametrize(
    ("away", "strained"),
    [
        # Chi-squared of 6.25 of five constants is likely, of 22.5 it is not (p = 4e-4).
        ([0.5, -0.5, 2.0, 1.0, 0.87], False),
        ([3.0, -3.0, 2.0, 0.5, 0.5], True),
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
