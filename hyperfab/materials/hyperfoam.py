"""Hyperfoam, the compressible law of Ogden, Hill and Storakers, in every test of a foam.

``W = sum_i 2 mu_i/alpha_i^2 [l1^a + l2^a + l3^a - 3 + (J^(-a beta_i) - 1)/beta_i]`` with ``a = alpha_i`` and
``beta_i = nu_i/(1 - 2 nu_i)``. B. Storakers, J. Mech. Phys. Solids 34 (1986) 125, doi:10.1016/0022-5096(86)90033-5;
R. Hill, Adv. Appl. Mech. 18 (1979) 1. In logarithmic strains e with sum E the derivatives are those of sums of
exponentials, so that states, tangents and derivatives by constants are closed but for the strains that are free.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array, Flags
from hyperfab.materials.law import Law, Sheet, Term, Value
from hyperfab.numerics.kernels import kernel

#: The models by name, and their number of terms.
ORDERS = {f"hyperfoam-{n}": n for n in (1, 2, 3)}
#: Tests that the law carries.
TESTS = (
    "uniaxial", "confined-compression", "shear", "simple-shear", "biaxial", "biaxial-general", "volumetric",
)  # fmt: skip
#: Where constants are sought: exponents, Poisson's ratios.
ALPHAS, RATIOS = (-60.0, 60.0), (-0.9, 0.499)
#: Newton's steps to the strains of free sides, and the largest of them.
_STEPS, _STEP = 60, 0.5


@dataclass(frozen=True)
class Hyperfoam:
    """Constants of n terms: ``mu`` [MPa] (its sum is the shear modulus at rest), ``alpha`` and ``nu``.

    >>> law = Hyperfoam((0.1,), (4.0,), (0.0,))
    >>> law.stress("confined-compression", [0.5]) == law.stress("uniaxial", [0.5])
    array([ True])
    """

    mu: tuple[float, ...]
    alpha: tuple[float, ...]
    nu: tuple[float, ...]

    @property
    def name(self) -> str:
        """The model's name."""
        return f"hyperfoam-{len(self.mu)}"

    @property
    def beta(self) -> Array:
        """``nu / (1 - 2 nu)`` of each term."""
        nu = np.asarray(self.nu)
        return np.asarray(nu / (1.0 - 2.0 * nu))

    @property
    def arrays(self) -> tuple[Array, Array, Array]:
        """``mu``, ``alpha`` and ``beta``, each (terms,)."""
        return np.array(self.mu), np.array(self.alpha), self.beta

    @property
    def bulk_modulus(self) -> float:
        """The bulk modulus at rest [MPa]."""
        return float(2.0 * np.asarray(self.mu) @ (1.0 / 3.0 + self.beta))

    @property
    def youngs_modulus(self) -> float:
        """Young's modulus at rest [MPa]."""
        K, G = self.bulk_modulus, sum(self.mu)
        return 9.0 * K * G / (3.0 * K + G)

    @property
    def parameters(self) -> dict[str, float]:
        """The constants as a material document has them."""
        return {
            f"{name}{i + 1}{unit}": float(value)
            for i in range(len(self.mu))
            for name, unit, value in (
                ("mu", "_MPa", self.mu[i]), ("alpha", "", self.alpha[i]), ("nu", "", self.nu[i])
            )
        }  # fmt: skip

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> Hyperfoam:
        """Return the law of a document's constants.

        Raises KeyError where one is missing, ValueError where one is without meaning.
        """
        n = len(parameters) // 3
        mu, alpha, nu = (
            tuple(float(parameters[f"{name}{i + 1}{unit}"]) for i in range(n))
            for name, unit in (("mu", "_MPa"), ("alpha", ""), ("nu", ""))
        )
        found = cls(mu, alpha, nu)
        if not n or 0.0 in alpha or not all(-1.0 < one < 0.5 for one in nu) or not sum(mu) > 0.0:
            raise ValueError("nu is from -1 to below 0.5, alpha not 0, and the sum of mu above 0")
        return found

    def without_nothing(self) -> Hyperfoam:
        """Return the same law without terms of zero stress."""
        terms = [one for one in zip(self.mu, self.alpha, self.nu, strict=True) if one[0] != 0.0]
        return Hyperfoam(*zip(*terms, strict=True))

    def stress(self, test: str, stretch: ArrayLike, stretch2: ArrayLike | None = None) -> Array:
        """Return the stress [MPa] of a test at ``stretch`` (n,), negative in compression; nan where there is no state.

        Nominal along the load; in simple shear the shear stress at shear strain ``stretch``, in a volumetric test the
        mean Cauchy stress at volume ratio ``stretch``. ``stretch2`` (n,) is the second axis of a general biaxial test.
        """
        rows = Rows.of(test, np.asarray(stretch, dtype=float), stretch2)
        with np.errstate(all="ignore"):
            return rows.stress(self, rows.strain(self))

    def lateral(self, test: str, stretch: ArrayLike) -> Array:
        """Return the stretch (n,) across the load where it is free, by no force across.

        >>> Hyperfoam((0.1,), (4.0,), (0.25,)).lateral("uniaxial", [0.5]).round(12) == round(0.5**-0.25, 12)
        array([ True])
        """
        rows = Rows.of(test, np.asarray(stretch, dtype=float), None)
        with np.errstate(all="ignore"):
            return np.asarray(np.exp(rows.strain(self)[:, 2]))

    def energy(self, e: Array) -> Array:
        """Return W (n,) [MPa] at logarithmic strains ``e`` (n, 3)."""
        E, found = e.sum(axis=1), np.zeros(len(e))
        for mu, alpha, beta in zip(self.mu, self.alpha, self.beta, strict=True):
            volume = np.expm1(-alpha * beta * E) / beta if beta else -alpha * E
            found += 2.0 * mu / alpha**2 * (np.expm1(alpha * e).sum(axis=1) + volume)
        return found

    def first(self, e: Array) -> Array:
        """Return dW/de (n, 3) at logarithmic strains ``e`` (n, 3)."""
        E, found = e.sum(axis=1)[:, None], np.zeros_like(e)
        for mu, alpha, beta in zip(self.mu, self.alpha, self.beta, strict=True):
            found += 2.0 * mu / alpha * (np.expm1(alpha * e) - np.expm1(-alpha * beta * E))
        return found

    def second(self, e: Array) -> Array:
        """Return d2W/de2 (n, 3, 3); the law is stable where it is positive definite (Hill)."""
        E = e.sum(axis=1)[:, None, None]
        found = np.zeros((len(e), 3, 3))
        for mu, alpha, beta in zip(self.mu, self.alpha, self.beta, strict=True):
            found += 2.0 * mu * (np.exp(alpha * e)[:, :, None] * np.eye(3) + beta * np.exp(-alpha * beta * E))
        return found

    def stable(self, e: Array) -> Flags:
        """Return whether the law is stable at each of ``e`` (n, 3): work is needed for any further change."""
        D = self.second(e)
        known: Flags = np.all(np.isfinite(D), axis=(1, 2))
        D = np.where(known[:, None, None], D, -np.eye(3))
        return np.asarray(known & np.greater(np.linalg.eigvalsh(D)[:, 0], 0.0))

    def _parts(self, e: Array) -> list[Array]:
        E = e.sum(axis=1)[:, None]
        return [
            2.0 * (np.expm1(alpha * e) - np.expm1(-alpha * beta * E)) / alpha
            for alpha, beta in zip(self.alpha, self.beta, strict=True)
        ]


class HyperfoamLaw(Law):
    """The law of n terms by the names of its constants; what is free of it asks for all of them together."""

    title = "compressible foam"
    source = "doi:10.1016/0022-5096(86)90033-5"
    equation = "W = sum_i 2 mu_i/alpha_i^2 [l1^a + l2^a + l3^a - 3 + (J^(-a beta_i) - 1)/beta_i]"
    compressible = True

    def __init__(self, n: int) -> None:
        self.name = f"hyperfoam-{n}"
        self.linear = tuple(f"mu{i + 1}_MPa" for i in range(n))
        self.nonlinear = tuple(f"{name}{i + 1}" for name in ("alpha", "nu") for i in range(n))
        self.bounds = {f"{name}{i + 1}": ends for name, ends in (("alpha", ALPHAS), ("nu", RATIOS)) for i in range(n)}

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """Say what has no meaning in ``Hyperfoam.of``."""
        try:
            Hyperfoam.of(parameters)
        except ValueError as error:
            return str(error)
        return None

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> Sequence[Term]:
        """Raise TypeError: the sides of a foam are free by all its terms, not by each."""
        raise TypeError(f"{self.name} is no sum of terms of a sheet")


@dataclass(frozen=True)
class Rows:
    """Rows of a test in logarithmic strains: ``e`` (n, 3) where they are known, ``free`` (3,) what is not, one value.

    The stress is ``along`` (3,) times dW/de over ``lever`` (n,).
    """

    e: Array
    free: Array
    along: Array
    lever: Array

    @classmethod
    def of(cls, test: str, stretch: Array, stretch2: ArrayLike | None = None) -> Rows:
        """Return the rows of a test; ValueError where the law does not carry it."""
        zero, one = np.zeros_like(stretch), np.array([1.0, 0.0, 0.0])
        if test == "simple-shear":
            x = np.arcsinh(0.5 * stretch)
            return cls(np.stack([x, -x, zero], axis=1), np.zeros(3), np.array([1.0, -1.0, 0.0]), 2.0 * np.cosh(x))
        x = np.log(stretch)
        if test == "volumetric":
            return cls(np.stack([x, x, x], axis=1) / 3.0, np.zeros(3), one, stretch)
        sides = {
            "uniaxial": (zero, [0.0, 1.0, 1.0]),
            "confined-compression": (zero, [0.0, 0.0, 0.0]),
            "shear": (zero, [0.0, 0.0, 1.0]),
            "biaxial": (x, [0.0, 0.0, 1.0]),
            "biaxial-general": (x if stretch2 is None else np.log(np.asarray(stretch2)), [0.0, 0.0, 1.0]),
        }
        if test not in sides:
            raise ValueError(f"{test} is no test of a foam")
        second, free = sides[test]
        return cls(np.stack([x, second, zero], axis=1), np.array(free), one, stretch)

    def strain(self, law: Hyperfoam) -> Array:
        """Return the strains (n, 3) with no force on what is free, by Newton's method; nan where there is none."""
        if not self.free.any():
            return self.e
        weight = np.abs(np.asarray(law.mu))
        nu = float(weight @ np.asarray(law.nu) / weight.sum())
        # At rest exact; of one term the answer.
        t = -nu * self.e.sum(axis=1) / (1.0 - nu * (2.0 - self.free.sum()))
        found = self.e.copy()
        _free_strains(found, self.free, np.asarray(t), *law.arrays)
        return found

    def stress(self, law: Hyperfoam, e: Array) -> Array:
        """Return the stress (n,) [MPa] at strains ``e``."""
        return np.asarray(law.first(e) @ self.along / self.lever)

    def slopes(self, law: Hyperfoam, e: Array) -> tuple[Array, Array]:
        """Return the derivatives of the stress and of the free strain by the constants (n, 3 terms)."""
        change = np.empty((len(e), 3 * len(law.mu)))
        moved = np.zeros_like(change)
        _slopes(e, self.free, self.along, self.lever, *law.arrays, change, moved)
        return change, moved


@kernel
def _free_strains(e: Array, free: Array, start: Array, mu: Array, alpha: Array, beta: Array) -> None:
    """Write the strain of the free sides into ``e`` (n, 3), by Newton's method from ``start`` (n,); nan where there is
    none."""
    many = free.sum()
    for i in range(len(e)):
        E, t, slope, step = e[i].sum(), start[i], 0.0, 0.0
        for _ in range(_STEPS):
            # All free sides are alike: one force and its slope, not those of three axes.
            force = slope = 0.0
            for k in range(len(mu)):
                side, volume = np.expm1(alpha[k] * t), np.expm1(-alpha[k] * beta[k] * (E + many * t))
                force += mu[k] / alpha[k] * (side - volume)
                slope += mu[k] * (1.0 + side + many * beta[k] * (1.0 + volume))
            step = -force / slope
            step = 0.0 if np.isnan(step) else min(max(step, -_STEP), _STEP)
            t += step
            if abs(step) < 1e-14:
                break
        if not (abs(step) < 1e-9 and slope > 0.0):
            t = np.nan
        for a in range(3):
            if free[a] > 0.0:
                e[i, a] += t


@kernel
def _slopes(
    e: Array,
    free: Array,
    along: Array,
    lever: Array,
    mu: Array,
    alpha: Array,
    beta: Array,
    change: Array,
    moved: Array,
) -> None:
    """Write the derivatives of the stress and of the free strain by mu, alpha and nu of all terms, in this order
    (n, 3 terms), the free sides giving way."""
    terms = len(mu)
    pull, across = np.empty(3 * terms), np.empty(3 * terms)
    for i in range(len(e)):
        E = e[i].sum()
        # How the pull, and what is on the free sides, change as these move; of a pull and of a free side by constants.
        carried = stiff = 0.0
        pull[:] = 0.0
        across[:] = 0.0
        for k in range(terms):
            a, volume = alpha[k], np.exp(-alpha[k] * beta[k] * E)
            ratio = 2.0 * mu[k] * E * volume * (1.0 + 2.0 * beta[k]) ** 2
            for j in range(3):
                side = np.exp(a * e[i, j])
                part = 2.0 * (np.expm1(a * e[i, j]) - np.expm1(-a * beta[k] * E)) / a
                turn = mu[k] * (2.0 * (e[i, j] * side + beta[k] * E * volume) - part) / a
                pull[k] += along[j] * part
                pull[terms + k] += along[j] * turn
                pull[2 * terms + k] += along[j] * ratio
                across[k] += free[j] * part
                across[terms + k] += free[j] * turn
                across[2 * terms + k] += free[j] * ratio
                bulk = free.sum() * beta[k] * volume
                carried += 2.0 * mu[k] * along[j] * (free[j] * side + bulk)
                stiff += 2.0 * mu[k] * free[j] * (free[j] * side + bulk)
        for c in range(3 * terms):
            if stiff != 0.0:
                moved[i, c] = -across[c] / stiff
            change[i, c] = (pull[c] + carried * moved[i, c]) / lever[i]
