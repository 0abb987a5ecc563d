"""Arruda-Boyce law, the series of five terms: ``W = mu sum_i C_i / lambda_m^(2i-2) (I1^i - 3^i)``.

Arruda & Boyce (1993), J. Mech. Phys. Solids 41, 389, doi:10.1016/0022-5096(93)90013-6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hyperfab.materials.law import Axis, Extent, InvariantTerm, Law, Sheet, Value, log_axis, of_I1, positive

#: Series of the inverse Langevin function, as the paper gives it.
COEFFICIENTS = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)


class ArrudaBoyce(Law):
    """Eight chains of limiting stretch lambda_m; ``mu0 = mu (1 + 3/(5 lm^2) + 99/(175 lm^4) + ...)``."""

    name = "arruda-boyce"
    title = "eight chains, series of five terms"
    source = "doi:10.1016/0022-5096(93)90013-6"
    equation = "W = mu sum_i C_i / lambda_m^(2i-2) (I1^i - 3^i)"
    linear: tuple[str, ...] = ("mu_MPa",)
    nonlinear: tuple[str, ...] = ("lambda_m",)

    def axes(self, extent: Extent) -> list[Axis]:
        """The series has no limit: lambda_m may lie below the data's chain stretch."""
        chain = (1.0 + extent.x / 3.0) ** 0.5
        return [log_axis(0.1 * chain, 100.0 * chain)]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """lambda_m is above zero."""
        return positive(parameters, "lambda_m")

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return the one term of mu, by Horner's rule in I1/lambda_m^2."""
        a = theta[0] ** -2.0
        I1, x = 3.0 + sheet.x, sheet.x
        z = a * I1
        return [of_I1(W=lambda: _series(a, I1, x), W1=_first(z), W11=a * _second(z))]


def _first(z: Value) -> Value:
    total: Value = 0.0
    for i in range(5, 0, -1):
        total = total * z + i * COEFFICIENTS[i - 1]
    return total


def _second(z: Value) -> Value:
    total: Value = 0.0
    for i in range(5, 1, -1):
        total = total * z + (i - 1) * i * COEFFICIENTS[i - 1]
    return total


def _series(a: Value, I1: Value, x: Value) -> Value:
    """Sum of C_i a^(i-1) (I1^i - 3^i), each difference as (I1 - 3) times a sum: no cancellation at rest."""
    total: Value = 0.0
    for i, coefficient in enumerate(COEFFICIENTS, start=1):
        quotient = sum(I1 ** (i - 1 - k) * 3.0**k for k in range(i))
        total = total + coefficient * a ** (i - 1) * x * quotient
    return total


LAWS = (ArrudaBoyce(),)
