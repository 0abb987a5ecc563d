"""Compression laws of foam: nominal stress against engineering strain, both positive in compression."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hyperfab.arrays import Array
from hyperfab.materials.hyperfoam import Hyperfoam

#: Strains at which a smooth law is sampled where layers share a closing: to 1e-6 of its largest stress.
_SAMPLES = 4097


@dataclass(frozen=True)
class FoamLaw:
    """A compression law up to ``limit``, the strain at which the foam counts as bottomed.

    ``raw_stress`` [MPa], ``raw_slope`` [MPa] and ``raw_energy`` [MPa, that is mJ/mm^3] take strains in 0..limit.
    Beyond the limit the stress goes on along its last slope, so that a force can still be balanced; how much area
    is there is for the caller to say. ``bends`` are the strains between which the law is straight, None where it is
    smooth; ``free`` is the thickness over that at rest of foam whose area is stretched (n,), where the law tells it.
    Foam that differs from place to place has a limit a place (n,), and ``places`` carries it to others.

    >>> law = linear(0.05)
    >>> law.stress(np.array([-0.1, 0.0, 0.5])).tolist(), float(law.energy(np.array(0.5)))
    ([0.0, 0.0, 0.025], 0.00625)
    """

    name: str
    limit: float | Array
    raw_stress: Callable[[Array], Array]
    raw_slope: Callable[[Array], Array]
    raw_energy: Callable[[Array], Array]
    bends: Array | None = None
    free: Callable[[Array], Array] | None = None
    places: Callable[[Callable[[Array], Array]], FoamLaw] | None = None

    def at(self, interpolate: Callable[[Array], Array]) -> FoamLaw:
        """The law elsewhere, given what carries values a place there."""
        return self if self.places is None else self.places(interpolate)

    @property
    def knots(self) -> Array:
        """Strains (k,) between which the law is straight, or near enough: they reach from 0 to the limit."""
        return np.linspace(0.0, self.limit, _SAMPLES) if self.bends is None else self.bends

    def stress(self, strain: ArrayLike) -> Array:
        """Nominal stress [MPa]; zero where the foam is not compressed."""
        inside, beyond = self._split(strain)
        found = self.raw_stress(inside)
        return found + self.raw_slope(np.asarray(self.limit)) * beyond if beyond.any() else found

    def slope(self, strain: ArrayLike) -> Array:
        """Tangent modulus [MPa]; zero where the foam is not compressed."""
        inside, _ = self._split(strain)
        return np.where(np.asarray(strain) > 0.0, self.raw_slope(inside), 0.0)

    def energy(self, strain: ArrayLike) -> Array:
        """Stored energy per undeformed volume [MPa]: the integral of the stress over the strain."""
        inside, beyond = self._split(strain)
        top = np.asarray(self.limit)
        return self.raw_energy(inside) + self.raw_stress(top) * beyond + 0.5 * self.raw_slope(top) * beyond**2

    def scaled(self, factor: float) -> FoamLaw:
        """The law with all stresses multiplied by ``factor``, as foam that has relaxed.

        >>> float(linear(0.05).scaled(0.5).stress(0.5))
        0.0125
        """
        if factor == 1.0:
            return self
        return replace(
            self,
            raw_stress=lambda e: factor * self.raw_stress(e),
            raw_slope=lambda e: factor * self.raw_slope(e),
            raw_energy=lambda e: factor * self.raw_energy(e),
            places=None if self.places is None else lambda carry: self.at(carry).scaled(factor),
        )

    def thinning(self, area: ArrayLike, poisson: float | None) -> Array:
        """Return the foam's thickness over that at rest where a drape stretches its ``area`` (n,) by this factor.

        By ``poisson`` where it is given: the logarithmic strains of the three directions are in its ratio, so that the
        thickness goes with ``area^(-nu / (1 - nu))``; this is also what a hyperfoam of one term does. Else the law says
        where no stress acts across. Raises ValueError where neither does, or no such state is.

        >>> linear(0.05).thinning([1.0, 1.5], 0.5).round(9).tolist()
        [1.0, 0.666666667]
        >>> hyperfoam([0.01], [4.0], [0.3]).thinning(1.5, None).round(9).item(), round(1.5 ** (-0.3 / 0.7), 9)
        (0.840489549, 0.840489549)
        """
        area = np.asarray(area, dtype=float)
        if poisson is not None:
            return np.asarray(area ** (-poisson / (1.0 - poisson)))
        if self.free is None:
            raise ValueError("neither the law nor a Poisson's ratio tells how stretched foam thins")
        found = self.free(area)
        if not np.all(np.isfinite(found)):
            raise ValueError(f"no thickness of the foam balances an area stretched by {area.max():.3g}")
        return found

    def _split(self, strain: ArrayLike) -> tuple[Array, Array]:
        strain = np.asarray(strain, dtype=float)
        inside = np.clip(strain, 0.0, self.limit)
        return inside, np.maximum(strain - self.limit, 0.0)


def mixed(laws: Sequence[FoamLaw], weights: Sequence[float | Array]) -> FoamLaw:
    """Return the law whose stresses are the mean of others, by weights that add up to one: numbers, or (n,) a place.

    Bottomed where the first of those that weigh anything is.

    >>> mixed([linear(0.05), linear(0.03)], [0.75, 0.25]).stress(1.0).round(9).item()
    0.045
    >>> there = [np.array([1.0, 0.5]), np.array([0.0, 0.5])]
    >>> mixed([linear(0.05), linear(0.03)], there).stress([1.0, 1.0]).round(9).tolist()
    [0.05, 0.04]
    """
    used = [(law, w) for law, w in zip(laws, weights, strict=True) if np.size(w) == 0 or np.any(np.asarray(w) > 0.0)]
    if len(used) == 1 and np.ndim(used[0][1]) == 0:
        return used[0][0]

    def mean(of: Sequence[Callable[[Array], Array] | None]) -> Callable[[Array], Array]:
        return lambda e: np.asarray(sum(w * one(e) for one, (_, w) in zip(of, used, strict=True) if one is not None))

    def carried(interpolate: Callable[[Array], Array]) -> FoamLaw:
        return mixed([law for law, _ in used], [interpolate(np.asarray(w)) for _, w in used])

    even = all(np.ndim(w) == 0 for _, w in used)
    limits = [np.where(np.asarray(w) > 0.0, law.limit, np.inf) for law, w in used]
    limit = np.min(np.stack(np.broadcast_arrays(*limits)), axis=0)
    first = float(limit.min(initial=np.inf))
    smooth = any(law.bends is None for law, _ in used) or not even
    bends = None if smooth else np.unique(np.concatenate([law.knots for law, _ in used]))
    told = [law.free for law, _ in used]
    names = dict.fromkeys(law.name for law, _ in used)
    return FoamLaw(
        " and ".join(names),
        first if even else np.asarray(limit),
        mean([law.raw_stress for law, _ in used]),
        mean([law.raw_slope for law, _ in used]),
        mean([law.raw_energy for law, _ in used]),
        None if bends is None else np.append(bends[bends < first], first),
        None if None in told else mean(told),
        None if even else carried,
    )


@dataclass(frozen=True)
class Tempered:
    """Laws (k) at rising ``temperatures`` (k,) [degC]: between two their stresses are linear, beyond them the nearest
    holds. A single law holds at any temperature.

    >>> foam = Tempered((20.0, 180.0), (linear(0.05), linear(0.03)))
    >>> foam.at(60.0).stress(1.0).round(9).item(), foam.at(300.0).stress(1.0).item()
    (0.045, 0.03)
    >>> foam.at(np.array([20.0, 100.0])).stress([1.0, 1.0]).round(9).tolist()
    [0.05, 0.04]
    """

    temperatures: tuple[float, ...]
    laws: tuple[FoamLaw, ...]

    def at(self, celsius: float | Array) -> FoamLaw:
        """Return the law at one temperature [degC], or at one a place (n,)."""
        if len(self.laws) == 1:
            return self.laws[0]
        places = np.asarray(celsius, dtype=float)
        if places.ndim and np.ptp(places) == 0.0:
            places = places[0]
        hats = [np.interp(places, self.temperatures, hat) for hat in np.eye(len(self.laws))]
        return mixed(self.laws, [hat if places.ndim else float(hat) for hat in hats])


def linear(modulus: float) -> FoamLaw:
    """Stress = modulus x strain, modulus in MPa; bottomed at full compression."""
    return FoamLaw(
        "linear",
        1.0,
        lambda e: modulus * e,
        lambda e: modulus + 0.0 * e,
        lambda e: 0.5 * modulus * e * e,
        np.array([0.0, 1.0]),
    )


def table(strain: ArrayLike, stress: ArrayLike) -> FoamLaw:
    """Straight lines between measured points; both columns must rise.

    ``strain`` (n,) and ``stress`` (n,) [MPa]. A first point above zero strain is joined to the origin. The foam is
    bottomed at the last strain. Raises ValueError naming the first row that does not rise.

    >>> law = table([0.0, 0.5, 0.8], [0.0, 0.01, 0.05])
    >>> law.stress(0.25).item(), round(law.energy(0.8).item(), 9)
    (0.005, 0.0115)
    """
    x, y = np.asarray(strain, dtype=float), np.asarray(stress, dtype=float)
    for row in range(len(x)):
        before = (x[row - 1], y[row - 1]) if row else (-np.inf, -np.inf)
        if not (x[row] > before[0] and y[row] >= before[1]):
            raise ValueError(f"row {row + 1}: strain and stress must rise from row to row")
    if len(x) < 2 or x[0] < 0.0 or y[0] < 0.0 or x[-1] >= 1.0:
        raise ValueError("strain must run from 0 to less than 1 in at least two rows, with stress of 0 or more")
    if x[0] > 0.0:
        x, y = np.concatenate([[0.0], x]), np.concatenate([[0.0], y])
    slopes = np.diff(y) / np.diff(x)
    areas = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(x))])

    def segment(e: Array) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(x, e, side="right") - 1, 0, len(slopes) - 1)

    def energy(e: Array) -> Array:
        i = segment(e)
        d = e - x[i]
        return np.asarray(areas[i] + y[i] * d + 0.5 * slopes[i] * d * d)

    return FoamLaw(
        "table",
        float(x[-1]),
        lambda e: np.interp(e, x, y),
        lambda e: np.asarray(slopes[segment(e)]),
        energy,
        x,
    )


def plateau(plateau_stress: float, modulus: float, densification: float, power: float = 2.0) -> FoamLaw:
    """Plateau and densification: ``s (1 - exp(-E e / s)) + B (e / (1 - e))^m``, bottomed at a strain of 0.95.

    ``plateau_stress`` s, ``modulus`` E and ``densification`` B in MPa, ``power`` m of 1 or more. The form of Avalle,
    Belingardi and Montanini (Int. J. Impact Eng. 25 (2001) 455) with a plateau that never falls.
    """
    s, E, B, m = plateau_stress, modulus, densification, power

    def packed(e: Array) -> Array:
        return e / (1.0 - e)

    return FoamLaw(
        "plateau",
        0.95,
        lambda e: s * -np.expm1(-E * e / s) + B * packed(e) ** m,
        lambda e: E * np.exp(-E * e / s) + B * m * packed(e) ** (m - 1.0) / (1.0 - e) ** 2,
        lambda e: s * (e + s / E * np.expm1(-E * e / s)) + B * _packed_integral(e, m),
    )


def hyperfoam(mu: ArrayLike, alpha: ArrayLike, nu: ArrayLike) -> FoamLaw:
    """Ogden-Storakers hyperfoam between wide plates, its sideways stretch held at one; bottomed at 0.95.

    ``W = sum 2 mu / alpha^2 (l1^alpha + l2^alpha + l3^alpha - 3 + (J^(-alpha beta) - 1) / beta)`` with
    ``beta = nu / (1 - 2 nu)``: shear moduli ``mu`` [MPa], exponents ``alpha`` and ``nu``, one a term. Source:
    B. Storakers, J. Mech. Phys. Solids 34 (1986) 125.
    """
    terms = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, dtype=float)) for v in (mu, alpha, nu)))
    rows = [(m, a, v / (1.0 - 2.0 * v)) for m, a, v in zip(*terms, strict=True)]

    def stress(e: Array) -> Array:
        lam = 1.0 - e
        return np.asarray(-sum(2 * m / a * (lam ** (a - 1) - lam ** (-a * b - 1)) for m, a, b in rows))

    def slope(e: Array) -> Array:
        lam = 1.0 - e
        pieces = (2 * m / a * ((a - 1) * lam ** (a - 2) + (a * b + 1) * lam ** (-a * b - 2)) for m, a, b in rows)
        return np.asarray(sum(pieces))

    def energy(e: Array) -> Array:
        lam = 1.0 - e
        pieces = (
            2 * m / a**2 * (lam**a - 1 + ((lam ** (-a * b) - 1) / b if b else -a * np.log(lam))) for m, a, b in rows
        )
        return np.asarray(sum(pieces))

    law = Hyperfoam(*(tuple(float(one) for one in term) for term in terms))

    def free(area: Array) -> Array:
        # No stress across: the law feels the sides by the area alone.
        return law.lateral("biaxial", np.sqrt(np.atleast_1d(area))).reshape(np.shape(area))

    return FoamLaw("hyperfoam", 0.95, stress, slope, energy, free=free)


def relaxed(shares: ArrayLike, times: ArrayLike, dwell: float) -> float:
    """Return what is left of the pressure after ``dwell`` [s]: ``1 - sum share (1 - exp(-dwell / time))``.

    A Prony series; ``times`` in s, one a share.

    >>> round(relaxed([0.2], [10.0], 1e9), 12), relaxed([0.2], [10.0], 0.0)
    (0.8, 1.0)
    """
    lost = np.asarray(shares, dtype=float) * -np.expm1(-dwell / np.asarray(times, dtype=float))
    return 1.0 - float(lost.sum())


def _packed_integral(e: Array, power: float) -> Array:
    """Integral of ``(x / (1 - x))^power`` from 0 to ``e``, by 24 Gauss points on two graded halves.

    With ``x = 1 - (1 - e)^s`` the steep end is stretched out, so that the rule is exact to rounding here.
    """
    nodes, weights = np.polynomial.legendre.leggauss(24)
    s = 0.5 * (nodes + 1.0)
    log = np.log1p(-np.asarray(e, dtype=float))[..., None]
    x = -np.expm1(log * s)
    return np.asarray((0.5 * weights * (x / (1.0 - x)) ** power * -log * (1.0 - x)).sum(-1))
