"""The sandwich warms between two molds: conduction through fabric, foam and fabric at every place, against time.

Each place is a column of its own: heat flows through the thickness, which is a hundredth of the molds' width. Every
layer is exact (no mesh through the thickness): in Laplace's variable s a layer of resistance R and capacity C turns
the impedance Z seen from one side into ``Zc (Z + Zc tanh a) / (Zc + Z tanh a)``, a = sqrt(s R C), Zc = R / a (the
thermal quadrupole: Carslaw and Jaeger, Conduction of Heat in Solids, 1959, 3.7; D. Maillet et al., Thermal
Quadrupoles, 2000). Within the foam the answer is a wave from either side, so that one solution tells all depths. Back
in time by Talbot's contour with the constants of L. N. Trefethen, J. A. C. Weideman and
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
#: A target is reached to this share of how far it is from the start; it takes about eight of so many steps at most.
_CLOSE, _STEPS = 1e-8, 60

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
        Several depths go to ``at_depths``.
        """
        seconds = np.asarray(times, dtype=float)
        return self.at_depths(seconds.ravel(), np.array([share])).reshape(*seconds.shape, len(self.male))

    def at_depths(self, times: Array, shares: Array) -> Array:
        """Return the temperature (d, t, n) [degC] at depths ``shares`` (d,) of the foam and ``times`` (t,) [s]."""
        return self._at(times[:, None], shares)

    def _at(self, times: Array, shares: Array) -> Array:
        times = np.array(np.broadcast_to(times, (len(times), len(self.male))), order="C")
        out = np.empty((len(shares), *times.shape))
        outer = np.stack([self.male - self.start, self.female - self.start])
        # The kernel is compiled for C order.
        layers = [np.ascontiguousarray(one) for one in (self.contact, self.resistance, self.capacity)]

        def work(first: int, last: int) -> None:
            _respond(times, outer, *layers, shares, _Z, _WEIGHT, out, first, last)

        in_blocks(work, times.shape[1], _BLOCK)
        return self.start + out

    def reaches(self, target: float, dwell: float) -> Array:
        """Return when (n,) [s] the foam's middle passes ``target`` [degC], NaN where not within ``dwell`` [s]."""
        rising = 1.0 if target >= self.start else -1.0

        def over(when: Array) -> Array:
            return np.asarray(rising * (self._at(when[None], np.array([0.5]))[0, 0] - target))

        low, high = np.zeros(len(self.male)), np.full(len(self.male), dwell)
        before, after = np.full(len(self.male), rising * (self.start - target)), over(high)
        passed, when, side = after >= 0.0, high, np.zeros(len(self.male))
        close = _CLOSE * max(abs(target - self.start), 1e-300)
        for _ in range(_STEPS if passed.any() else 0):
            # The secant, an end that stays counted half from the second time on (the Illinois method).
            when = high - after * (high - low) / np.where(after > before, after - before, 1.0)
            here = over(when)
            if np.abs(here[passed]).max() <= close:
                break
            there = here >= 0.0
            before = np.where(there, np.where(side > 0.0, 0.5 * before, before), here)
            after = np.where(there, here, np.where(side < 0.0, 0.5 * after, after))
            low, high = np.where(there, low, when), np.where(there, when, high)
            side = np.where(there, 1.0, -1.0)
        return np.where(passed, when, np.nan)


@kernel
def _respond(
    times: Array,
    outer: Array,
    contact: Array,
    resistance: Array,
    capacity: Array,
    shares: Array,
    points: NDArray[np.complex128],
    weights: NDArray[np.complex128],
    out: Array,
    start: int,
    end: int,
) -> None:
    """How far the temperature has moved at each depth by each time at the places ``start:end``, ``outer`` (2, n) being
    where the molds would have it."""
    depths = len(shares)
    alike = True  # depths that are their own mirror image: what comes from one side fades as what comes from the other
    for d in range(depths):
        alike = alike and abs(shares[d] + shares[depths - 1 - d] - 1.0) < 1e-15
    fades, rises = np.empty(depths, dtype=np.complex128), np.empty(depths, dtype=np.complex128)
    for k in range(times.shape[0]):
        for i in range(start, end):
            for d in range(depths):
                out[d, k, i] = 0.0
            if times[k, i] <= 0.0:
                continue
            R = resistance[1, i]
            for j in range(len(points)):
                s = points[j] / times[k, i]
                one, z_one = _layer(s, resistance[0, i], capacity[0, i], outer[0, i] + 0j, contact[0, i] + 0j)
                two, z_two = _layer(s, resistance[2, i], capacity[2, i], outer[1, i] + 0j, contact[1, i] + 0j)
                a = np.sqrt(s * (R * capacity[1, i])) if R > 0.0 else 0j
                if abs(a) < 1e-6:
                    # It stores nothing: a straight line between both sides.
                    for d in range(depths):
                        left, right = z_one + shares[d] * R, z_two + (1.0 - shares[d]) * R
                        both = left + right
                        # Where both sides hold the place without any resistance, they hold it at one temperature.
                        held = (one * right + two * left) / both if abs(both) > 0.0 else 0.5 * (one + two)
                        out[d, k, i] += (weights[j] * held).real
                    continue
                for d in range(depths):
                    fades[d] = np.exp(-shares[d] * a)
                for d in range(depths):
                    rises[d] = fades[depths - 1 - d] if alike else np.exp(-(1.0 - shares[d]) * a)
                # A wave from the male that is one there, and one from the female: decaying exponentials alone, so
                # that a short time cannot overflow.
                decay, r_one, r_two = np.exp(-a), z_one * a / R, z_two * a / R
                across = (1.0 + r_one) * (1.0 + r_two) - decay * decay * (1.0 - r_one) * (1.0 - r_two)
                first = weights[j] * (one * (1.0 + r_two) - two * decay * (1.0 - r_one)) / across
                second = weights[j] * (two * (1.0 + r_one) - one * decay * (1.0 - r_two)) / across
                for d in range(depths):
                    out[d, k, i] += (first * fades[d] + second * rises[d]).real


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
