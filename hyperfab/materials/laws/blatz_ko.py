"""Blatz-Ko law for compressible foams and rubbers, with zero stress across the sheet.

``W = mu f/2 [I1 - 3 + (J^(-2b) - 1)/b] + mu (1-f)/2 [I2/J^2 - 3 + (J^(2b) - 1)/b]``, ``b = nu/(1 - 2 nu)``.
Blatz & Ko (1962), Trans. Soc. Rheol. 6, 223, doi:10.1122/1.548937. Foam form: f = 0, nu = 1/4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.law import Array, Axis, Extent, Law, Membrane, Sheet, Value, linear_axis


@dataclass(frozen=True)
class _Half:
    """``sum of l^n over the plane + 2/|..| ((l1 l2)^(-m) - 1)``: one bracket with the thickness condensed out.

    Zero stress across the sheet gives the same thickness stretch for both brackets, l3 = (l1 l2)^(-nu/(1-nu)).
    What is left is ``[l1^n + l2^n - 2 + (n/m) ((l1 l2)^-m - 1)]/2`` with n = 2, m = 2 nu/(1-nu) for the first
    bracket and both signs turned for the second.
    """

    n: float
    m: Value

    def stress(self, sheet: Sheet, along: int = 1) -> Array:
        """Return dW/dl1, or dW/dl2 with ``along`` 2."""
        a, b, _ = sheet.logs
        log, stretch = (a, sheet.l1) if along == 1 else (b, sheet.l2)
        volume = -self.m * (a + b)
        return np.asarray(0.5 * self.n * np.exp(volume) * np.expm1(self.n * log - volume) / stretch)

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives."""
        n, m, l1, l2 = self.n, self.m, sheet.l1, sheet.l2
        a, b, _ = sheet.logs
        p1, p2 = self.stress(sheet), self.stress(sheet, along=2)
        volume = np.exp(-m * (a + b))
        area = -(a + b) if np.all(m == 0.0) else np.expm1(-m * (a + b)) / m
        return Membrane(
            W=0.5 * (np.expm1(n * a) + np.expm1(n * b) + n * area),
            P1=p1,
            P2=p2,
            A11=0.5 * n * ((n - 1.0) * l1**n + (m + 1.0) * volume) / l1**2,
            A12=0.5 * n * m * volume / (l1 * l2),
            A22=0.5 * n * ((n - 1.0) * l2**n + (m + 1.0) * volume) / l2**2,
        )


class BlatzKo(Law):
    """Compressible; a fit takes the foam form, f = 0 and nu = 1/4, with mu as its one constant."""

    name = "blatz-ko"
    title = "compressible; foam form f = 0, nu = 1/4"
    source = "doi:10.1122/1.548937"
    equation = "W = mu f/2 [I1 - 3 + (J^(-2b) - 1)/b] + mu (1-f)/2 [I2/J^2 - 3 + (J^(2b) - 1)/b], b = nu/(1 - 2 nu)"
    linear = ("mu f", "mu (1-f)")
    nonlinear = ("nu",)
    held: Mapping[str, float] = {"mu f": 0.0, "nu": 0.25}
    bounds: Mapping[str, tuple[float, float]] = {"nu": (0.0, 0.4999)}
    compressible = True

    @property
    def names(self) -> tuple[str, ...]:
        """mu, f and nu."""
        return ("mu_MPa", "f", "nu")

    def split(self, parameters: Mapping[str, float]) -> tuple[list[float], list[float]]:
        """Return mu f and mu (1 - f), and nu."""
        mu, f, nu = (float(parameters[name]) for name in self.names)
        return [mu * f, mu * (1.0 - f)], [nu]

    def join(self, c: Sequence[float], theta: Sequence[float]) -> dict[str, float]:
        """Return mu, f and nu."""
        mu = float(c[0] + c[1])
        return {"mu_MPa": mu, "f": float(c[0]) / mu if mu else 0.0, "nu": float(theta[0])}

    def axes(self, extent: Extent) -> list[Axis]:
        """Poisson's ratio between no contraction and nearly constant volume."""
        return [linear_axis(*self.bounds["nu"])]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """nu is from 0 to below 1/2."""
        return None if 0.0 <= parameters["nu"] < 0.5 else "nu is not from 0 to below 0.5"

    def contraction(self, theta: Sequence[Value]) -> Value:
        """Return Poisson's ratio: the lateral stretch is stretch^-nu whatever f."""
        return theta[0]

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[_Half]:
        """Return the bracket of I1 and that of I2."""
        m = 2.0 * theta[0] / (1.0 - theta[0])
        return [_Half(2.0, m), _Half(-2.0, -m)]


class BlatzKoGeneral(BlatzKo):
    """The same energy with f and nu fitted too."""

    name = "blatz-ko-general"
    title = "compressible; f and nu fitted"
    held: Mapping[str, float] = {}


LAWS = (BlatzKo(), BlatzKoGeneral())
