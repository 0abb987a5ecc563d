"""Uniform thermal growth of a mold about its mounting face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hyperfab.pressing.mold import Mold

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Expansion:
    """Linear thermal expansion of a mold material, from the temperature at which its drawing holds.

    ``coefficient`` [1/K] is the mean coefficient between ``reference`` [degC] and each of ``temperatures`` [degC],
    as handbooks give it; one number holds throughout. Outside the table the nearest value is kept.

    >>> aluminium = Expansion(20.0, (100.0, 300.0), (23.6e-6, 25.2e-6))
    >>> round(float(aluminium.strain(200.0)), 9)
    0.004392
    """

    reference: float
    temperatures: tuple[float, ...]
    coefficient: tuple[float, ...]

    @classmethod
    def constant(cls, coefficient: float, reference: float) -> Expansion:
        """The same coefficient [1/K] at every temperature."""
        return cls(reference, (reference,), (coefficient,))

    def strain(self, temperature: ArrayLike) -> Array:
        """Thermal strain at ``temperature`` [degC]; zero at the reference."""
        value = np.asarray(temperature, dtype=float)
        mean = np.interp(value, self.temperatures, self.coefficient)
        return np.asarray(mean * (value - self.reference))


def guide_line(male: Mold) -> Array:
    """Return the line (2,) [mm], seen along the axis, from which both molds grow sideways: the male's middle.

    Guides hold the two molds to each other, so they grow from one line, and it is the middle of the tool.
    """
    plan = male.vertices[:, :2]
    return np.asarray(0.5 * (plan.min(axis=0) + plan.max(axis=0)))


def uniform_growth(male: Mold, female: Mold, male_strain: float, female_strain: float) -> tuple[Array, Array]:
    """Return the displacements (n, 3) [mm] of both molds' vertices when each grows evenly.

    Each mounting face stays at its height; sideways both grow from the guides' line.

    >>> import numpy as np
    >>> one = Mold(np.array([[10.0, 0.0, 50.0], [-10.0, 0.0, -50.0]]), np.array([[0, 1, 0]]), side=1, mount=-50.0)
    >>> uniform_growth(one, one, 0.01, 0.0)[0].tolist()
    [[0.1, 0.0, 1.0], [-0.1, 0.0, 0.0]]
    """
    line = guide_line(male)
    growth = [
        strain * (mold.vertices - np.array([line[0], line[1], mold.mount]))
        for mold, strain in ((male, male_strain), (female, female_strain))
    ]
    return growth[0], growth[1]


def ungrown(points: Array, mold: Mold, strain: float) -> Array:
    """Return where points (n, 3) [mm] of the evenly grown ``mold`` lie when it is cold.

    >>> import numpy as np
    >>> one = Mold(np.array([[10.0, 0.0, 50.0], [-10.0, 0.0, -50.0]]), np.array([[0, 1, 0]]), side=1, mount=-50.0)
    >>> hot = one.vertices + uniform_growth(one, one, 0.01, 0.0)[0]
    >>> bool(np.allclose(ungrown(hot, one, 0.01), one.vertices))
    True
    """
    line = guide_line(mold)
    fixed = np.array([line[0], line[1], mold.mount])
    return np.asarray(fixed + (points - fixed) / (1.0 + strain))
