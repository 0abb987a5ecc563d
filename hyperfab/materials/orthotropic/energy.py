"""One strain energy for an orthotropic fabric: a ground, threads along warp, weft and at an angle, and the shear angle.

    W(C) = C10 x + C20 x^2 + C30 x^3 + C2 ln(1 + y/3)                           the ground
         + sum over threads of k1/(2 k2) (exp(k2 <I - 1>^2) - 1)                warp, weft, and a pair at +-bias
         + G/2 C12^2 / (C11 C22)                                                the angle between warp and weft

per undeformed volume, with C the right Cauchy-Green tensor in the sheet's axes (1 warp, 2 weft), I = t.C.t the squared
stretch of a thread, <.> its positive part: threads bear tension alone. The ground's invariants

    x = tr C + (J^-2m - 1)/m - 2,      y = tr C^-1 + (J^2m - 1)/m - 2,      J^2 = det C,  m = nu/(1 - nu)

contract by stretch^-nu in uniaxial tension; for nu = 1/2 they are I1 - 3 and I2 - 3 of an incompressible sheet in plane
stress, so that without threads and shear term the law is the isotropic one (neo-Hooke, Yeoh, Yeoh with ln I2). Every
term is smooth in its constants, and none may be below zero.

Threads after Holzapfel, Gasser & Ogden (2000), J. Elast. 61, 1, doi:10.1023/A:1010835316564; a pair of inclined
threads is what couples warp and weft in a knit, whose loops turn before they stretch; the ground's volume term is that
of Blatz & Ko (1962), Trans. Soc. Rheol. 6, 223, doi:10.1122/1.548937, in plane stress.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array
from hyperfab.errors import InputError
from hyperfab.materials.law import scaled

#: The constants the energy is linear in, all stresses, then the others.
LINEAR = ("C10_MPa", "C20_MPa", "C30_MPa", "C2_MPa", "k1_warp_MPa", "k1_weft_MPa", "k1_bias_MPa", "G_MPa")
NONLINEAR = ("nu", "k2_warp", "k2_weft", "k2_bias", "bias_deg")
NAMES = (*LINEAR, *NONLINEAR)

#: What the constants are where nothing is said of them: an incompressible ground alone.
ABSENT = dict.fromkeys(NAMES, 0.0) | {"nu": 0.5, "bias_deg": 45.0}
#: Between which values each constant has a meaning.
WALLS = dict.fromkeys(NAMES, (0.0, math.inf)) | {"nu": (0.0, 0.5), "bias_deg": (0.0, 90.0)}

#: Below this exponent of the volume the power is a logarithm.
_TINY = 1e-9


@dataclass(frozen=True)
class Answer:
    """What the sheet answers at n points, per undeformed volume.

    ``energy`` (n,) [MPa]; ``stress`` (n, 3): second Piola-Kirchhoff S11, S22, S12 [MPa]; ``stiffness`` (n, 3, 3):
    dS/dE for (E11, E22, 2 E12) [MPa].
    """

    energy: Array
    stress: Array
    stiffness: Array


@dataclass(frozen=True)
class Orthotropic:
    """The law with its constants, by name.

    >>> rubber = Orthotropic.of({"C10_MPa": 0.2})
    >>> round(float(rubber.answer([[4.0, 0.5, 0.0]]).stress[0, 0]), 12)
    0.35
    """

    parameters: Mapping[str, float]

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> Orthotropic:
        """Return the law; constants that are not named are absent.

        Raises InputError naming a constant that is unknown, or has no meaning.
        """
        for name, value in parameters.items():
            if name not in NAMES:
                raise InputError(
                    "is no constant of orthotropic", key=name, remedy=f"it has {', '.join(NAMES)}"
                )
            if not math.isfinite(value):
                raise InputError(f"is not a finite number: {value!r}", key=name)
        found = {**ABSENT, **{name: float(value) for name, value in parameters.items()}}
        low = [name for name in NAMES if math.isinf(WALLS[name][1]) and found[name] < 0.0]
        if low:
            raise InputError("is below zero: the sheet would not be stable", key=low[0])
        if not 0.0 <= found["nu"] <= 0.5:
            raise InputError("is a Poisson's ratio from 0 to 0.5", key="nu")
        if not 0.0 <= found["bias_deg"] <= 90.0:
            raise InputError("is an angle from the warp, 0 to 90 deg", key="bias_deg")
        stiff = found["C10_MPa"] + found["C2_MPa"]
        if not stiff > 0.0:
            raise InputError(
                "the ground has no stiffness at rest (C10_MPa and C2_MPa are zero)", key="C10_MPa"
            )
        return cls(found)

    @property
    def vector(self) -> Array:
        """The constants in the order of NAMES."""
        return np.array([self.parameters[name] for name in NAMES])

    def scaled(self, factor: float) -> Orthotropic:
        """Return the law with all stresses times ``factor``."""
        return Orthotropic(scaled(self.parameters, factor))

    def turned(self) -> Orthotropic:
        """Return the law of the sheet turned by a quarter: warp and weft exchanged."""
        p = dict(self.parameters)
        p["k1_warp_MPa"], p["k1_weft_MPa"] = p["k1_weft_MPa"], p["k1_warp_MPa"]
        p["k2_warp"], p["k2_weft"] = p["k2_weft"], p["k2_warp"]
        p["bias_deg"] = 90.0 - p["bias_deg"]
        return Orthotropic(p)

    def answer(self, strain: ArrayLike) -> Answer:
        """Return energy, stress and stiffness at C11, C22, C12 (n, 3)."""
        C = np.asarray(strain, dtype=np.float64)
        energy, stress, stiffness = np.zeros(len(C)), np.zeros((len(C), 3)), np.zeros((len(C), 3, 3))
        for constant, (w, s, d) in zip(self.vector[: len(LINEAR)], self.terms(C), strict=True):
            if constant != 0.0:
                energy += constant * w
                stress += constant * s
                stiffness += constant * d
        return Answer(energy, stress, stiffness)

    def thickness_stretch(self, strain: Array) -> Array:
        """Return the thickness stretch (n,) of the ground, J^-m: 1/J where it keeps the volume."""
        det = strain[:, 0] * strain[:, 1] - strain[:, 2] ** 2
        nu = self.parameters["nu"]
        return np.asarray(det ** (-0.5 * nu / (1.0 - nu)))

    def stress_terms(self, strain: Array, theta: Array | None = None) -> Array:
        """Return the stress (n, 8, 3) of each linear constant, for other nonlinear constants where given."""
        parts = _parts(strain, self._theta if theta is None else theta, bent=False)
        return np.stack([g for _, g, _ in parts], axis=1) * _TWICE

    def terms(self, strain: Array) -> list[tuple[Array, Array, Array]]:
        """Return energy (n,), stress (n, 3) and stiffness (n, 3, 3) of each linear constant."""
        parts = _parts(strain, self._theta, bent=True)
        return [(w, g * _TWICE, H * (_TWICE[:, None] * _TWICE)) for w, g, H in parts if H is not None]

    @cached_property
    def _theta(self) -> Array:
        return self.vector[len(LINEAR) :]


#: From derivatives by C11, C22, C12 to stress and stiffness: S = 2 dW/dC, and C12 stands in C twice.
_TWICE = np.array([2.0, 2.0, 1.0])

#: A value with its first (n, 3) and, where wanted, second derivatives (n, 3, 3) by C11, C22, C12.
_Part = tuple[Array, Array, Array | None]


def _parts(C: Array, theta: Array, bent: bool) -> list[_Part]:
    """Return the terms in the order of LINEAR, with second derivatives where ``bent``."""
    nu, k2_warp, k2_weft, k2_bias, bias = theta
    x, y = _invariants(C, nu / (1.0 - nu), bent)
    cos, sin = np.cos(np.deg2rad(bias)), np.sin(np.deg2rad(bias))
    one, other = (_thread(C, k2_bias, cos, side * sin, bent) for side in (1.0, -1.0))
    I2 = 3.0 + y[0]
    return [
        x,
        _of(x, x[0] ** 2, 2.0 * x[0], 2.0 + 0.0 * x[0]),
        _of(x, x[0] ** 3, 3.0 * x[0] ** 2, 6.0 * x[0]),
        _of(y, np.log1p(y[0] / 3.0), 1.0 / I2, -1.0 / I2**2),
        _thread(C, k2_warp, 1.0, 0.0, bent),
        _thread(C, k2_weft, 0.0, 1.0, bent),
        (
            one[0] + other[0],
            one[1] + other[1],
            None if one[2] is None or other[2] is None else one[2] + other[2],
        ),
        _angle(C, bent),
    ]


def _invariants(C: Array, m: float, bent: bool) -> tuple[_Part, _Part]:
    """Return x and y."""
    c1, c2, c3 = C.T
    det = c1 * c2 - c3 * c3
    log = np.log(det)
    d1 = np.stack([c2, c1, -2.0 * c3], axis=1)
    trace = c1 + c2

    def power(p: float) -> tuple[Array, Array, Array]:
        """(det^p - 1)/p, log det at p = 0, and its derivatives by det."""
        value = log if abs(p) < _TINY else np.expm1(p * log) / p
        return value, np.exp((p - 1.0) * log), (p - 1.0) * np.exp((p - 2.0) * log)

    shrunk, grown = power(-m), power(m)
    slope = grown[1] - trace / det**2
    x1, y1 = -shrunk[1][:, None] * d1, slope[:, None] * d1
    x1[:, :2] += 1.0
    y1[:, :2] += (1.0 / det)[:, None]
    x2 = y2 = None
    if bent:
        outer = d1[:, :, None] * d1[:, None, :]
        d2 = np.zeros((3, 3))
        d2[0, 1] = d2[1, 0] = 1.0
        d2[2, 2] = -2.0
        both = np.zeros_like(outer)
        both[:, :2, :] += d1[:, None, :]
        both[:, :, :2] += d1[:, :, None]
        x2 = -shrunk[2][:, None, None] * outer - shrunk[1][:, None, None] * d2
        y2 = (
            (grown[2] + 2.0 * trace / det**3)[:, None, None] * outer
            + slope[:, None, None] * d2
            - both / (det**2)[:, None, None]
        )
    return (trace - 2.0 - shrunk[0], x1, x2), (trace / det - 2.0 + grown[0], y1, y2)


def _of(inner: _Part, value: Array, slope: Array, bend: Array) -> _Part:
    """Return a function of an invariant by the chain rule."""
    _, g, H = inner
    if H is not None:
        H = slope[:, None, None] * H + bend[:, None, None] * g[:, :, None] * g[:, None, :]
    return value, slope[:, None] * g, H


def _thread(C: Array, k2: float, cos: float, sin: float, bent: bool) -> _Part:
    """Return 1/(2 k2) (exp(k2 <I - 1>^2) - 1) of threads along (cos, sin)."""
    along = np.array([cos * cos, sin * sin, 2.0 * cos * sin])
    strain = np.maximum(C @ along - 1.0, 0.0)
    square = strain * strain
    with np.errstate(over="ignore"):
        growth = np.exp(k2 * square)
        value = 0.5 * square if abs(k2) < _TINY else 0.5 * np.expm1(k2 * square) / k2
        bend = np.where(strain > 0.0, growth * (1.0 + 2.0 * k2 * square), 0.0)
    H = bend[:, None, None] * (along[:, None] * along) if bent else None
    return value, (strain * growth)[:, None] * along, H


def _angle(C: Array, bent: bool) -> _Part:
    """Return half the squared sine of the change of the angle between warp and weft: nothing else moves it."""
    c1, c2, c3 = C.T
    product = c1 * c2
    square = c3 * c3 / product
    g = np.stack([-0.5 * square / c1, -0.5 * square / c2, c3 / product], axis=1)
    if not bent:
        return 0.5 * square, g, None
    H = np.empty((len(C), 3, 3))
    H[:, 0, 0], H[:, 1, 1], H[:, 2, 2] = square / c1**2, square / c2**2, 1.0 / product
    H[:, 0, 1] = H[:, 1, 0] = 0.5 * square / product
    H[:, 0, 2] = H[:, 2, 0] = -c3 / (product * c1)
    H[:, 1, 2] = H[:, 2, 1] = -c3 / (product * c2)
    return 0.5 * square, g, H


def least_modulus(own: Answer, C: Array) -> Array:
    """Return the least over the largest eigenvalue (n,) of the moduli of the Kirchhoff stress's Jaumann rate.

    ``own`` is the law's answer at C11, C22, C12 (n, 3). Negative where more strain in some direction of the plane
    takes less stress (Drucker); not a number where the law has none.
    """
    angle = 0.5 * np.arctan2(2.0 * C[:, 2], C[:, 0] - C[:, 1])
    mean, radius = 0.5 * (C[:, 0] + C[:, 1]), np.hypot(0.5 * (C[:, 0] - C[:, 1]), C[:, 2])
    c1 = mean + radius
    c2 = np.maximum((C[:, 0] * C[:, 1] - C[:, 2] ** 2) / c1, 1e-12)
    l1, l2 = np.sqrt(c1), np.sqrt(c2)
    cos2, sin2 = np.cos(2.0 * angle), np.sin(2.0 * angle)
    cc, ss, cs = 0.5 * (1.0 + cos2), 0.5 * (1.0 - cos2), 0.5 * sin2
    one, two = np.stack([cc, ss, 2.0 * cs], axis=1), np.stack([ss, cc, -2.0 * cs], axis=1)
    both = np.stack([-2.0 * cs, 2.0 * cs, 2.0 * cos2], axis=1)
    T = np.stack([one * c1[:, None], two * c2[:, None], 0.5 * both * (l1 * l2)[:, None]], axis=1)
    t = np.einsum("nij,nj->ni", T, own.stress)
    M = np.einsum("nij,njk,nlk->nil", T, own.stiffness, T)
    # The Jaumann rate adds half of delta tau in all its symmetries.
    M[:, 0, 0] += 2.0 * t[:, 0]
    M[:, 1, 1] += 2.0 * t[:, 1]
    M[:, 2, 2] += 0.5 * (t[:, 0] + t[:, 1])
    M[:, 0, 2] += t[:, 2]
    M[:, 2, 0] += t[:, 2]
    M[:, 1, 2] += t[:, 2]
    M[:, 2, 1] += t[:, 2]
    finite = np.isfinite(M).all(axis=(1, 2))
    values = np.linalg.eigvalsh(np.where(finite[:, None, None], M, np.eye(3)))
    largest = np.abs(values).max(axis=1)
    return np.where(finite, values[:, 0] / np.where(largest > 0.0, largest, 1.0), np.nan)
