"""Zeros of functions of one variable that are known."""

from __future__ import annotations

import math

import pytest

from hyperfab.numerics.roots import zero_between

#: Functions, the ends of a bracket, and the zero.
FUNCTIONS = {
    "cosine": (lambda x: math.cos(x) - x, 0.0, 1.0, 0.7390851332151607),
    "cubic": (lambda x: x**3 - 1e-3, -1.0, 4.0, 0.1),
    "steep": (lambda x: math.exp(20.0 * x) - 2.0, -3.0, 3.0, math.log(2.0) / 20.0),
    "kink": (lambda x: min(x - 0.3, 3.0 * (x - 0.3)), -5.0, 7.0, 0.3),
    "root": (lambda x: math.copysign(abs(x) ** 0.3, x) - 0.1, -1.0, 1.0, 0.1 ** (1.0 / 0.3)),
    "jump": (lambda x: 1.0 if x > 0.3 else -1.0, -1.0, 1.0, 0.3),
    "flat": (lambda x: x**19, -1.0, 2.3, 0.0),
}


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_zero_is_found_to_the_tolerance(name: str, turned: bool) -> None:
    value, low, high, zero = FUNCTIONS[name]
    asked: list[float] = []

    def counted(x: float) -> float:
        asked.append(x)
        return value(x)

    found = zero_between(counted, *((high, low) if turned else (low, high)), 1e-9)
    assert abs(found - zero) <= 1e-9
    assert len(asked) <= 60  # halving alone takes some 35


def test_a_tolerance_of_nothing_ends_at_neighbouring_doubles() -> None:
    found = zero_between(lambda x: x * x - 2.0, 0.0, 2.0, 0.0)
    assert abs(found - math.sqrt(2.0)) <= 4.5e-16


def test_an_end_that_is_a_zero_is_the_answer() -> None:
    assert zero_between(lambda x: x, 0.0, 2.0, 1e-9) == 0.0
    assert zero_between(lambda x: x - 2.0, 0.0, 2.0, 1e-9) == 2.0


def test_ends_of_one_sign_are_refused() -> None:
    with pytest.raises(ValueError, match="no change of sign between 1 and 2"):
        zero_between(lambda x: x, 1.0, 2.0, 1e-9)
