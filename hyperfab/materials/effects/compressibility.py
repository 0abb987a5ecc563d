"""A sheet that changes its volume: contraction by an exponent other than one half."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.effects.path import BIAXIAL, SHEAR, UNIAXIAL, Path, second_stretch
from hyperfab.materials.effects.smooth import through
from hyperfab.materials.law import Array

#: Newton steps for the volume, each doubles the digits; after one this small, relative, none are left to double.
_STEPS, _EXACT = 7, 1e-9


def across(stretch: Array, contraction: Array | float, bend: float = 0.0) -> Array:
    """Return the transverse stretch of a uniaxial test: ``stretch^-(contraction + bend ln stretch)``.

    Blatz & Ko (1962), Trans. Soc. Rheol. 6, 223, doi:10.1122/1.548937, for their exponent nu; 1/2 keeps the volume.

    >>> across(np.array([4.0]), 0.5)
    array([0.5])
    """
    return np.asarray(stretch ** -(contraction + bend * np.log(stretch)))


def as_incompressible(mode: Array, stretch: Array, second: Array, contraction: Array, bend: float = 0.0) -> Array:
    """Return the second stretch at which an incompressible sheet has the same stretch and the same thickness.

    With the normal stress zero the thickness of Blatz and Ko's material is ``(l1 l2)^(-nu/(1-nu))``; the driving stress
    of a law in the stretches along the pull and through the thickness is then the incompressible one at
    ``l2 = 1/(l1 l3)``. Exact for the neo-Hookean energy.
    """
    area = np.where(mode == BIAXIAL, stretch**2, np.where(mode == SHEAR, stretch, stretch * second))
    thickness = area ** (-contraction / (1.0 - contraction))
    thickness = np.where(mode == UNIAXIAL, across(stretch, contraction, bend), thickness)
    return np.asarray(1.0 / (stretch * thickness))


def pull(stretch: Array, second: Array, usual: Array) -> Array:
    """Return by how much the driving stretch ``l - l3^2/l`` differs from that of a sheet with ``usual`` second stretch.

    ``second`` is that of ``as_incompressible``. For a sheet whose moduli go with its stretch, not with its volume: the
    slope of the law stays, what it acts on is less. 1 at rest.
    """
    driving = stretch - 1.0 / (stretch**3 * second**2)
    before = stretch - 1.0 / (stretch**3 * usual**2)
    return np.asarray(np.where(np.abs(before) > 1e-9, driving / np.where(before == 0.0, 1.0, before), 1.0))


def volume(mode: Array, stretch: Array, second: Array, nu: float) -> Array:
    """Return the volume ratio of a sheet whose energy splits into one of shape and ``K/2 (J - 1)^2``.

    ``nu`` is Poisson's ratio at rest, ``second`` the given second stretch (of tests that give one). With no stress
    through the thickness ``K J (J - 1)`` balances the stress of shape, taken as neo-Hooke's.
    Flory (1961), Trans. Faraday Soc. 57, 829, doi:10.1039/tf9615700829.

    >>> volume(np.array([UNIAXIAL]), np.array([1.5]), np.array([np.nan]), 0.5)
    array([1.])
    """
    share = (1.0 - 2.0 * nu) / (2.0 * (1.0 + nu))
    found = np.ones_like(stretch)
    if share == 0.0:
        return found
    area = np.where(mode == BIAXIAL, stretch**2, np.where(mode == SHEAR, stretch, stretch * second))
    other = second_stretch(mode, stretch, second, second)
    pulled = mode == UNIAXIAL
    flat, thick = stretch**2 + np.where(pulled, 0.0, other**2), np.where(pulled, 0.0, area**-2.0)
    side = np.where(pulled, 1.0 / stretch, 0.0)
    for _ in range(_STEPS):
        size = np.cbrt(found)
        area_of = size * size
        shape = flat / area_of - 2.0 * thick * found * size - side * size
        slope = -2.0 / 3.0 * flat / (found * area_of) - 8.0 / 3.0 * thick * size - side / (3.0 * area_of)
        step = (found * (found - 1.0) - share * shape) / (2.0 * found - 1.0 - share * slope)
        found = np.clip(found - step, 0.5 * found, 2.0 * found)
        if np.all(np.abs(step) <= _EXACT * found):
            break
    return np.asarray(found)


def of_shape(mode: Array, stretch: Array, second: Array, ratio: Array) -> tuple[Array, Array]:
    """Return the two stretches of shape alone, in the sheet's plane, of a volume ``ratio``."""
    size = np.cbrt(ratio)
    other = second_stretch(mode, stretch, np.sqrt(ratio / stretch), second)
    return stretch / size, np.asarray(other / size)


#: The exponents along warp and weft, and what it is more between, of a sheet that keeps its volume.
_AT_REST = (0.5, 0.5, 0.0)


@dataclass(frozen=True)
class Contraction:
    """A form of the effect: an exponent of the whole sheet, of warp and weft (2 ``ways``), or of these and what it is
    more between them (3); ``bent``: with its bend.

    ``smooth``: each a smooth function of the logarithm of the stretch.
    """

    ways: int = 1
    bent: bool = False
    smooth: bool = False

    def absent(self, values: Array) -> bool:
        """Whether the sheet keeps its volume."""
        if self.smooth:
            parts = zip(_AT_REST, self._smooth_parts(values), strict=False)
            return all(bool(one[0] == null and not np.any(one[1:])) for null, one in parts)
        return bool(np.all(values[: self.ways] == _AT_REST[: self.ways]) and not (self.bent and values[-1]))

    def poisson(self, values: Array) -> float | None:
        """Return the one number that says it all, None where there is no such."""
        return None if self.ways > 1 or self.bent or self.smooth else float(values[0])

    def exponent(self, path: Path, values: Array) -> tuple[Array, float]:
        """Return the exponent of every row, and the bend."""
        if self.smooth:
            way = np.log(path.stretch) / np.log1p(values[0])
            each = [one[0] + through(way, one[1:]) for one in self._smooth_parts(values)]
            return _of_way(path, each), 0.0
        nu = _of_way(path, [np.full_like(path.stretch, value) for value in values[: self.ways]])
        return nu, float(values[-1]) if self.bent else 0.0

    def _smooth_parts(self, values: Array) -> list[Array]:
        """Return, of each direction, the exponent at rest and what it has more at thirds of the reach, told first."""
        return np.split(values[1:], self.ways)

    def across(self, path: Path, stretch: Array, values: Array) -> Array:
        """Return the transverse stretch of uniaxial rows."""
        return across(stretch, *self.exponent(path, values))

    def state(self, path: Path, stretch: Array, usual: Array, values: Array) -> tuple[Array, Array, Array | float]:
        """Return the stretches in which the law is asked, and what its stress is multiplied by.

        ``usual`` is the second stretch of a sheet that keeps its volume.
        """
        return stretch, as_incompressible(path.mode, stretch, usual, *self.exponent(path, values)), 1.0


@dataclass(frozen=True)
class Slope(Contraction):
    """The law's slope stays as it is, what it acts on is less."""

    def poisson(self, values: Array) -> float | None:
        """Return None: the law is not that of a Poisson's ratio."""
        return None

    def state(self, path: Path, stretch: Array, usual: Array, values: Array) -> tuple[Array, Array, Array | float]:
        """Return the stretches of a sheet that keeps its volume, and how much less drives it."""
        _, thinner, _ = super().state(path, stretch, usual, values)
        return stretch, usual, pull(stretch, thinner, usual)


@dataclass(frozen=True)
class Width(Slope):
    """Stresses stay as they are: how a strip becomes narrower is no part of the law."""

    def state(self, path: Path, stretch: Array, usual: Array, values: Array) -> tuple[Array, Array, Array | float]:
        """Return the stretches of a sheet that keeps its volume."""
        return stretch, usual, 1.0


@dataclass(frozen=True)
class Split(Slope):
    """An energy of shape and one of volume."""

    def across(self, path: Path, stretch: Array, values: Array) -> Array:
        return np.asarray(np.sqrt(volume(path.mode, stretch, path.across, values[0]) / stretch))

    def state(self, path: Path, stretch: Array, usual: Array, values: Array) -> tuple[Array, Array, Array | float]:
        """Return the stretches of shape alone."""
        ratio = volume(path.mode, stretch, path.across, values[0])
        return *of_shape(path.mode, stretch, path.across, ratio), 1.0 / np.cbrt(ratio)


def _of_way(path: Path, each: Sequence[Array]) -> Array:
    """Return what a row has, by its direction, of warp, weft and what is more between them."""
    found = each[0]
    if len(each) > 1:
        found = found + path.weft_share * (each[1] - each[0])
    return found + path.bias_share * each[2] if len(each) > 2 else found


#: The forms in which a sheet changes its volume.
FORMS: Mapping[str, Contraction] = {
    "uniform": Contraction(),
    "slope": Slope(),
    "split": Split(),
    "slope-bent": Slope(bent=True),
    "uniform-bent": Contraction(bent=True),
    "uniform-smooth": Contraction(smooth=True),
    "slope-smooth": Slope(smooth=True),
    "directions": Contraction(ways=2),
    "directions-bent": Contraction(ways=2, bent=True),
    "directions-smooth": Contraction(ways=2, smooth=True),
    "width": Width(),
    "width-bent": Width(bent=True),
    "width-smooth": Width(smooth=True),
    "width-directions": Width(ways=2),
    "width-directions-smooth": Width(ways=2, smooth=True),
    "slanted": Contraction(ways=3),
    "slanted-smooth": Contraction(ways=3, smooth=True),
}


def is_of_width(terms: Mapping[str, tuple[str, Array]]) -> bool:
    """Whether ``terms`` say how a strip becomes narrower, whatever the law has it do."""
    return "compressibility" in terms and isinstance(FORMS[terms["compressibility"][0]], Width)
