"""The sandwich warms between two molds: conduction through fabric, foam and fabric at every place, against time.

Each place is a column of its own: heat flows through the thickness, which is a hundredth of the molds' width. Every
layer is exact (no mesh through the thickness): in Laplace's variable s a layer of resistance R and capacity C turns
the impedance Z seen from one side into ``Zc (Z + Zc tanh a) / (Zc + Z tanh a)``, a = sqrt(s R C), Zc = R / a (the
thermal quadrupole: Carslaw and Jaeger, Conduction of Heat in Solids, 1959, 3.7; D. Maillet et al., Thermal
Quadrupoles, 2000). Back in time by Talbot's contour with the constants of L. N. Trefethen, J. A. C. Weideman and
T. Schmelzer, BIT 46 (2006) 653, whose error falls as 3.89^-N at any time after the closing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.threads import in_blocks

#: Points of the contour: an error of 1e-7 of the temperature difference.
_POINTS = 12
#: Places that are computed together.
_BLOCK = 2048
#: Halvings of the dwell in search of the time that a target is reached: to 1e-9 of it.
_HALVINGS = 30

_THETA = np.pi * np.arange(1, _POINTS, 2) / _POINTS
_COT = 1.0 / np.tan(0.6407 * _THETA)
_Z = _POINTS * (0.5017 * _THETA * _COT - 0.6122 + 0.2645j * _THETA)
_DZ = _POINTS * (0.5017 * _COT - 0.5017 * 0.6407 * _THETA * (1.0 + _COT**2) + 0.2645j)
_WEIGHT = -2j / _POINTS * np.exp(_Z) * _DZ / _Z


@dataclass(frozen=True)
class Column:
    """The sandwich at n places between a male and a female that keep their temperatures from the closing on.

    start       temperature [degC] at which the sandwich is laid in
    male        of the male mold (n,) [degC]; ``female`` of the female (n,)
    contact     resistance [m^2 K/W] between mold and sandwich (2, n): male side, female side
    resistance  of fabric below, foam, fabric above (3, n) [m^2 K/W]: thickness as it is pressed over conductivity
    capacity    of the same (3, n) [J/m^2/K]: density, specific heat and thickness as they were before pressing

    >>> import numpy as np
    >>> foam = np.array([[0.0], [4.5e-3 / 0.023], [0.0]]), np.array([[0.0], [30.0 * 1045.0 * 4.5e-3], [0.0]])
    >>> slab = Column(25.0, np.array([200.0]), np.array([200.0]), np.zeros((2, 1)), *foam)
    >>> slab.at(4.0).round(2).tolist(), slab.at([0.0, 1e9]).round(3).tolist()
    ([146.69], [[25.0], [200.0]])
    """

    start: float
    male: Array
    female: Array
    contact: Array
    resistance: Array
    capacity: Array

    def at(self, times: ArrayLike, share: float = 0.5) -> Array:
        """Return the foam's temperature (..., n) [degC] at ``times`` (...) [s] after the closing.

        ``share`` says where through the thickness of the foam: 0 at the fabric on the male, 1 at that on the female.
        Times of each place's own go to ``at_own``.
        """
        seconds = np.asarray(times, dtype=float)
        flat = np.broadcast_to(seconds.reshape(-1, 1), (seconds.size, len(self.male)))
        return self.at_own(flat, share).reshape(*seconds.shape, len(self.male))

    def at_own(self, times: Array, share: float = 0.5) -> Array:
        """Return the temperature (k, n) [degC] at ``times`` (k, n) [s] of each place's own."""
        out = np.empty(times.shape)
        outer = np.stack([self.male - self.start, self.female - self.start])

        def work(first: int, last: int) -> None:
            of = slice(first, last)
            _respond(
                times[:, of], outer[:, of], self.contact[:, of], self.resistance[:, of], self.capacity[:, of],
                share, _Z, _WEIGHT, out[:, of],
            )  # fmt: skip

        in_blocks(work, times.shape[1], _BLOCK)
        return self.start + out

    def reaches(self, target: float, dwell: float, share: float = 0.5) -> Array:
        """Return when (n,) [s] the temperature passes ``target`` [degC], NaN where it does not within ``dwell`` [s]."""
        low, high = np.zeros((1, len(self.male))), np.full((1, len(self.male)), dwell)
        rising = 1.0 if target >= self.start else -1.0
        passed = rising * (self.at_own(high, share) - target) >= 0.0
        for _ in range(_HALVINGS if passed.any() else 0):
            middle = 0.5 * (low + high)
            there = rising * (self.at_own(middle, share) - target) >= 0.0
            low, high = np.where(there, low, middle), np.where(there, middle, high)
        return np.asarray(np.where(passed, high, np.nan)[0])


@kernel
def _respond(
    times: Array,
    outer: Array,
    contact: Array,
    resistance: Array,
    capacity: Array,
    share: float,
    points: NDArray[np.complex128],
    weights: NDArray[np.complex128],
    out: Array,
) -> None:
    """How far the temperature has moved by each time, ``outer`` (2, n) being where the molds would have it."""
    for k in range(times.shape[0]):
        for i in range(times.shape[1]):
            if times[k, i] <= 0.0:
                out[k, i] = 0.0
                continue
            total = 0.0
            for j in range(len(points)):
                s = points[j] / times[k, i]
                one, z_one = _layer(s, resistance[0, i], capacity[0, i], outer[0, i] + 0j, contact[0, i] + 0j)
                one, z_one = _layer(s, share * resistance[1, i], share * capacity[1, i], one, z_one)
                rest = 1.0 - share
                two, z_two = _layer(s, resistance[2, i], capacity[2, i], outer[1, i] + 0j, contact[1, i] + 0j)
                two, z_two = _layer(s, rest * resistance[1, i], rest * capacity[1, i], two, z_two)
                # Where both sides hold the place without any resistance, they hold it at one temperature.
                both = z_one + z_two
                held = (one * z_two + two * z_one) / both if abs(both) > 0.0 else 0.5 * (one + two)
                total += (weights[j] * held).real
            out[k, i] = total


@part
def _layer(s: complex, R: float, C: float, source: complex, Z: complex) -> tuple[complex, complex]:
    """The source and its impedance as they are seen through a layer."""
    if R <= 0.0:
        return source, Z
    a = np.sqrt(s * (R * C))
    if abs(a) < 1e-6:
        return source, Z + R
    # With decaying exponentials alone, so that a short time cannot overflow.
    decay = np.exp(-a)
    Zc, tanh = R / a, (1.0 - decay * decay) / (1.0 + decay * decay)
    below = Zc + Z * tanh
    return source * Zc * 2.0 * decay / (1.0 + decay * decay) / below, Zc * (Z + Zc * tanh) / below
