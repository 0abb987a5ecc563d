"""One measured curve, from the file that holds it to the law that is fitted to it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from hyperfab.arrays import Array, Ints

#: Directions that have a name, in degrees from the warp.
DIRECTIONS = {"warp": 0.0, "weft": 90.0}


@dataclass(frozen=True)
class TestCurve:
    """A test of one specimen in one direction, n rows in the order in which they were read; None: not known.

    - ``mode``: uniaxial, shear (planar), biaxial, biaxial-general, simple-shear, confined-compression or volumetric.
    - ``stretch``, ``stress`` (n,): of the loading direction; nominal stress in MPa, or force per undeformed width in
      N/mm where ``membrane`` is true (no thickness is known). A volumetric test has its volume ratio and mean stress,
      one in simple shear its shear strain and shear stress.
    - ``stretch2``, ``stress2`` (n,): of the second direction of a general biaxial test; of a uniaxial one ``stretch2``
      is the lateral stretch that was measured.
    - ``weight``, ``weight2`` (n,): what an error of a row counts in a fit, of the stress [1/MPa] and of what is
      measured in the second direction. 1 / stress makes a fit relative.
    - ``stress_sd`` [MPa], ``time_s``, ``temperature_degC``, ``rate_1_s``, ``cycle``, ``branch`` (1 on loading, -1 on
      unloading), ``lines`` of the file (n,).
    - ``thickness_mm``, ``width_mm``, ``gauge_length_mm``: the specimen's sizes.
    - ``on_specimen``: whether the stretch was read on the specimen, by marks or an extensometer, not between grips.
    - ``aspect``: length over width of a strip whose stretch is the extension of that whole length: its ends are held.
    - ``direction``: degrees from the warp. ``temperature``: at which all rows count [degC], ``warmth`` the lowest and
      the highest of them. ``others``: numbers told of the test that no law has a use for, by name.

    >>> curve = TestCurve("uniaxial", np.array([1.0, 1.1, 1.2]), np.array([0.0, 0.1, 0.2]), direction=90.0)
    >>> curve.take(curve.stretch > 1.0).stress, curve.direction_name
    (array([0.1, 0.2]), 'weft')
    """

    __test__ = False  # no test class for pytest

    mode: str
    stretch: Array
    stress: Array
    weight: Array | None = None
    stretch2: Array | None = None
    stress2: Array | None = None
    weight2: Array | None = None
    source: str = ""
    lines: Ints | None = None
    stress_sd: Array | None = None
    time_s: Array | None = None
    temperature_degC: Array | None = None
    rate_1_s: Array | None = None
    cycle: Ints | None = None
    branch: Ints | None = None
    direction: float | None = None
    specimen: str | None = None
    thickness_mm: float | None = None
    width_mm: float | None = None
    gauge_length_mm: float | None = None
    aspect: float | None = None
    on_specimen: bool = False
    membrane: bool = False
    temperature: float | None = None
    warmth: tuple[float, float] | None = None
    others: Mapping[str, float] = field(default_factory=dict)

    def take(self, rows: Any) -> Self:
        """Return the same curve with some of its rows."""
        columns: dict[str, Any] = {
            name: value[rows] for name, value in vars(self).items() if isinstance(value, np.ndarray)
        }
        return replace(self, **columns)

    def is_at(self, temperature: float | None) -> bool:
        """Whether it was measured at a temperature, or nothing says at which."""
        return self.temperature in (temperature, None)

    def thinned(self, count: int) -> Self:
        """Return about ``count`` of the rows, evenly."""
        if len(self.stretch) <= count:
            return self
        return self.take(np.unique(np.linspace(0, len(self.stretch) - 1, count).round().astype(np.int64)))

    @property
    def weights(self) -> Array:
        """What the error of each row counts, 1 where that is not told."""
        return np.ones_like(self.stretch) if self.weight is None else self.weight

    @property
    def contraction(self) -> Array | None:
        """The measured lateral stretch of a uniaxial test."""
        return self.stretch2 if self.mode == "uniaxial" else None

    @property
    def principal(self) -> Array:
        """The principal stretch along the load; in simple shear ``stretch`` holds the shear strain."""
        return sheared(self.stretch) if self.mode == "simple-shear" else self.stretch

    def in_planar_tension(self) -> Self:
        """Return a test in simple shear as the planar tension that strains a body in the same way but for a turn.

        True of a body without direction that keeps its volume.
        """
        share = share_of_shear(self.principal)
        return replace(
            self,
            mode="shear",
            stretch=self.principal,
            stress=self.stress / share,
            stress_sd=None if self.stress_sd is None else self.stress_sd / share,
            rate_1_s=None if self.rate_1_s is None else self.rate_1_s * share,
        )

    @property
    def angle_deg(self) -> float:
        """Degrees from the warp, nan where that is not known."""
        return np.nan if self.direction is None else self.direction

    @property
    def direction_name(self) -> str | None:
        """``warp``, ``weft``, or the angle from the warp as text."""
        if self.direction is None:
            return None
        named = (name for name, angle in DIRECTIONS.items() if angle == self.direction)
        return next(named, f"{self.direction:g} deg")

    @property
    def stress_unit(self) -> str:
        """``MPa``, or ``N/mm`` for membrane stress."""
        return "N/mm" if self.membrane else "MPa"


def of_deviations(curves: Sequence[TestCurve]) -> list[TestCurve] | None:
    """Return the curves with the standard deviations of their stresses in their place; None unless all state them."""
    stated = [(curve, curve.stress_sd) for curve in curves if curve.stress_sd is not None]
    if len(stated) < len(curves):
        return None
    return [replace(curve, stress=sd, stress2=None if curve.stress2 is None else sd) for curve, sd in stated]


def largest_stress(curves: Iterable[TestCurve]) -> float:
    """Return the largest absolute stress of all ``curves``."""
    return max(float(np.abs(curve.stress).max()) for curve in curves)


def sheared(strain: Array) -> Array:
    """Return the stretch l in the plane of a simple shear by ``strain`` = l - 1/l, that with l above 1 where it is.

    >>> sheared(np.array([1.5, -1.5]))
    array([2. , 0.5])
    """
    return np.asarray(np.exp(np.arcsinh(0.5 * strain)))


def share_of_shear(stretch: Array) -> Array:
    """Return the shear stress of simple shear over the nominal stress of planar tension at the same ``stretch`` l.

    Both are slopes of one energy, along the strain l - 1/l and along l: 1/(1 + l^-2).

    >>> share_of_shear(np.array([1.0, 2.0]))
    array([0.5, 0.8])
    """
    return np.asarray(1.0 / (1.0 + stretch**-2))


def angle_named(name: str | None) -> float | None:
    """Return the degrees from the warp that a ``direction_name`` tells.

    >>> angle_named("weft"), angle_named("22.5 deg")
    (90.0, 22.5)
    """
    if name is None:
        return None
    return DIRECTIONS[name] if name in DIRECTIONS else float(name.split()[0])
