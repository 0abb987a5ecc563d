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
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hyperfab.arrays import Array
from hyperfab.errors import InputError
from hyperfab.materials.law import scaled
from hyperfab.numerics.kernels import kernel, part

#: The constants the energy is linear in, all stresses, then the others.
LINEAR = ("C10_MPa", "C20_MPa", "C30_MPa", "C2_MPa", "k1_warp_MPa", "k1_weft_MPa", "k1_bias_MPa", "G_MPa")
NONLINEAR = ("nu", "k2_warp", "k2_weft", "k2_bias", "bias_deg")
NAMES = (*LINEAR, *NONLINEAR)

#: What the constants are where nothing is said of them: an incompressible ground alone.
ABSENT = dict.fromkeys(NAMES, 0.0) | {"nu": 0.5, "bias_deg": 45.0}
#: Between which values each constant has a meaning.
WALLS = dict.fromkeys(NAMES, (0.0, math.inf)) | {"nu": (0.0, 0.5), "bias_deg": (0.0, 90.0)}

#: Where the energy, stress and stiffness of each term and an invariant's derivatives are worked out.
Room = tuple[Array, Array, Array, Array, Array]
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

    name: ClassVar[str] = "orthotropic"
    parameters: Mapping[str, float]

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> Orthotropic:
        """Return the law; constants that are not named are absent.

        Raises InputError naming a constant that is unknown, or has no meaning.
        """
        for name, value in parameters.items():
            if name not in NAMES:
                raise InputError("is no constant of orthotropic", key=name, remedy=f"it has {', '.join(NAMES)}")
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
            raise InputError("the ground has no stiffness at rest (C10_MPa and C2_MPa are zero)", key="C10_MPa")
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
        C = np.ascontiguousarray(strain, dtype=np.float64)
        found = Answer(np.zeros(len(C)), np.zeros((len(C), 3)), np.zeros((len(C), 3, 3)))
        _answer(C, self.vector, found.energy, found.stress, found.stiffness)
        return found

    def thickness_stretch(self, strain: Array) -> Array:
        """Return the thickness stretch (n,) of the ground, J^-m: 1/J where it keeps the volume."""
        det = strain[:, 0] * strain[:, 1] - strain[:, 2] ** 2
        nu = self.parameters["nu"]
        return np.asarray(det ** (-0.5 * nu / (1.0 - nu)))

    def stress_terms(self, strain: Array, theta: Array | None = None) -> Array:
        """Return the stress (n, 8, 3) of each linear constant, for other nonlinear constants where given."""
        C = np.ascontiguousarray(strain, dtype=np.float64)
        found = np.empty((len(C), len(LINEAR), 3))
        _stresses(C, np.ascontiguousarray(self.vector[len(LINEAR) :] if theta is None else theta), found)
        return found


@kernel
def _answer(C: Array, constants: Array, energy: Array, stress: Array, stiffness: Array) -> None:
    """Energy (n,), stress (n, 3) and stiffness (n, 3, 3) of strains (n, 3)."""
    room = make_room()
    for i in range(len(C)):
        energy[i] = answer_at(C[i], constants, room, stress[i], stiffness[i])


@part
def make_room() -> Room:
    """Where the terms of one strain are worked out."""
    count = len(LINEAR)
    return np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3)), np.empty(3), np.empty((3, 3))


@part
def answer_at(c: Array, constants: Array, room: Room, stress: Array, stiffness: Array) -> float:
    """Sum the terms whose constant is not zero: the energy at one strain, ``stress`` (3,) and ``stiffness`` (3, 3)."""
    count = len(LINEAR)
    wanted, theta = constants[:count] != 0.0, constants[count:]
    w, g, H, p, P = room
    _terms(c, theta, wanted, True, p, P, w, g, H)
    energy = 0.0
    stress[:] = 0.0
    stiffness[:] = 0.0
    for k in range(count):
        if wanted[k]:
            factor = constants[k]
            energy += factor * w[k]
            for a in range(3):
                stress[a] += factor * g[k, a]
                for b in range(3):
                    stiffness[a, b] += factor * H[k, a, b]
    return energy


@kernel
def _stresses(C: Array, theta: Array, out: Array) -> None:
    """The stress (n, 8, 3) of each term."""
    count = len(LINEAR)
    wanted = np.ones(count, np.bool_)
    w, H = np.zeros(count), np.zeros((count, 3, 3))
    p, P = np.empty(3), np.empty((3, 3))
    for i in range(len(C)):
        _terms(C[i], theta, wanted, False, p, P, w, out[i], H)


@part
def _terms(
    c: Array,
    theta: Array,
    wanted: NDArray[np.bool_],
    bent: bool,
    p: Array,
    P: Array,
    w: Array,
    g: Array,
    H: Array,
) -> None:
    """Energy (8,), stress (8, 3) and, where ``bent``, stiffness (8, 3, 3) of the terms in the order of LINEAR, at one
    strain; ``p`` and ``P`` are room for an invariant's derivatives by C11, C22, C12."""
    c1, c2, c3 = c[0], c[1], c[2]
    det, trace, m = c1 * c2 - c3 * c3, c1 + c2, theta[0] / (1.0 - theta[0])
    log = np.log(det)
    if wanted[0] or wanted[1] or wanted[2]:
        value, slope, bend = _power(-m, log)
        x = trace - 2.0 - value
        _of_det(c1, c2, c3, -slope, -bend, p, P)
        p[0] += 1.0
        p[1] += 1.0
        _chain(0, x, 1.0, 0.0, bent, p, P, w, g, H)
        _chain(1, x * x, 2.0 * x, 2.0, bent, p, P, w, g, H)
        _chain(2, x * x * x, 3.0 * x * x, 6.0 * x, bent, p, P, w, g, H)
    if wanted[3]:
        value, slope, bend = _power(m, log)
        y = trace / det - 2.0 + value
        _of_det(c1, c2, c3, slope - trace / det**2, bend + 2.0 * trace / det**3, p, P)
        p[0] += 1.0 / det
        p[1] += 1.0 / det
        mixed = 1.0 / det**2
        P[0, 0] -= 2.0 * c2 * mixed
        P[1, 1] -= 2.0 * c1 * mixed
        P[0, 1] -= trace * mixed
        P[1, 0] -= trace * mixed
        for a in range(2):
            P[a, 2] += 2.0 * c3 * mixed
            P[2, a] += 2.0 * c3 * mixed
        I2 = 3.0 + y
        _chain(3, np.log1p(y / 3.0), 1.0 / I2, -1.0 / I2**2, bent, p, P, w, g, H)
    for k in range(4, 7):
        w[k] = 0.0
        g[k] = 0.0
        H[k] = 0.0
    if wanted[4]:
        _thread(4, c, theta[1], 1.0, 0.0, bent, w, g, H)
    if wanted[5]:
        _thread(5, c, theta[2], 0.0, 1.0, bent, w, g, H)
    if wanted[6]:
        cos, sin = np.cos(np.deg2rad(theta[4])), np.sin(np.deg2rad(theta[4]))
        _thread(6, c, theta[3], cos, sin, bent, w, g, H)
        _thread(6, c, theta[3], cos, -sin, bent, w, g, H)
    if wanted[7]:
        _angle(7, c1, c2, c3, bent, w, g, H)
    # From derivatives to stress and stiffness: S = 2 dW/dC, and C12 stands in C twice.
    for k in range(len(wanted)):
        for a in range(2):
            g[k, a] *= 2.0
            H[k, a, 2] *= 2.0
            H[k, 2, a] *= 2.0
            for b in range(2):
                H[k, a, b] *= 4.0


@part
def _power(p: float, log: float) -> tuple[float, float, float]:
    """(det^p - 1)/p, log det at p = 0, and its derivatives by det."""
    value = log if abs(p) < _TINY else np.expm1(p * log) / p
    return value, np.exp((p - 1.0) * log), (p - 1.0) * np.exp((p - 2.0) * log)


@part
def _of_det(c1: float, c2: float, c3: float, slope: float, bend: float, p: Array, P: Array) -> None:
    """Derivatives (3,) and (3, 3) of a function of det C."""
    p[0], p[1], p[2] = c2, c1, -2.0 * c3
    for a in range(3):
        for b in range(3):
            P[a, b] = bend * p[a] * p[b]
    P[0, 1] += slope
    P[1, 0] += slope
    P[2, 2] -= 2.0 * slope
    for a in range(3):
        p[a] *= slope


@part
def _chain(
    k: int,
    value: float,
    slope: float,
    bend: float,
    bent: bool,
    p: Array,
    P: Array,
    w: Array,
    g: Array,
    H: Array,
) -> None:
    """A term that is a function of an invariant."""
    w[k] = value
    for a in range(3):
        g[k, a] = slope * p[a]
        if bent:
            for b in range(3):
                H[k, a, b] = slope * P[a, b] + bend * p[a] * p[b]


@part
def _thread(k: int, c: Array, k2: float, cos: float, sin: float, bent: bool, w: Array, g: Array, H: Array) -> None:
    """Add 1/(2 k2) (exp(k2 <I - 1>^2) - 1) of threads along (cos, sin)."""
    along = (cos * cos, sin * sin, 2.0 * cos * sin)
    strain = max(c[0] * along[0] + c[1] * along[1] + c[2] * along[2] - 1.0, 0.0)
    square = strain * strain
    growth = np.exp(k2 * square)
    w[k] += 0.5 * square if abs(k2) < _TINY else 0.5 * np.expm1(k2 * square) / k2
    bend = growth * (1.0 + 2.0 * k2 * square) if strain > 0.0 else 0.0
    for a in range(3):
        g[k, a] += strain * growth * along[a]
        if bent:
            for b in range(3):
                H[k, a, b] += bend * along[a] * along[b]


@part
def _angle(k: int, c1: float, c2: float, c3: float, bent: bool, w: Array, g: Array, H: Array) -> None:
    """Half the squared sine of the change of the angle between warp and weft: nothing else moves it."""
    product = c1 * c2
    square = c3 * c3 / product
    w[k] = 0.5 * square
    g[k, 0], g[k, 1], g[k, 2] = -0.5 * square / c1, -0.5 * square / c2, c3 / product
    if bent:
        H[k, 0, 0], H[k, 1, 1], H[k, 2, 2] = square / c1**2, square / c2**2, 1.0 / product
        H[k, 0, 1] = H[k, 1, 0] = 0.5 * square / product
        H[k, 0, 2] = H[k, 2, 0] = -c3 / (product * c1)
        H[k, 1, 2] = H[k, 2, 1] = -c3 / (product * c2)


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
