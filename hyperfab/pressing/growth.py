"""Thermal growth of a mold about its mounting face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.arrays import Array, Ints
from hyperfab.pressing.mold import Mold
from hyperfab.pressing.tetra import TetraMesh, at_boundary


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


@dataclass(frozen=True)
class EvenGrowth:
    """Growth by one ``strain`` from the ``fixed`` point (3,) [mm].

    >>> EvenGrowth(0.01, np.array([0.0, 0.0, -50.0])).at(np.array([[10.0, 0.0, 50.0]])).tolist()
    [[0.1, 0.0, 1.0]]
    """

    strain: float
    fixed: Array

    def at(self, points: Array) -> Array:
        """Return the displacements (n, 3) [mm] of ``points`` (n, 3)."""
        return np.asarray(self.strain * (points - self.fixed))


@dataclass(frozen=True)
class FieldGrowth:
    """Growth as the finite elements found it: ``moved`` (n, 3) [mm] at the nodes of ``mesh``, outer faces ``faces``."""

    mesh: TetraMesh
    faces: Ints
    moved: Array

    def at(self, points: Array) -> Array:
        """Return the displacements (n, 3) [mm] of the mesh's boundary nearest to ``points`` (n, 3)."""
        return at_boundary(self.mesh, self.faces, self.moved, points)[0]


#: How a hot mold has grown: the displacement of each of its points from where it is cold.
Growth = EvenGrowth | FieldGrowth


def even_growth(mold: Mold, strain: float, line: Array) -> EvenGrowth:
    """Return the growth of a mold that is equally hot throughout: its mounting face stays at its height, and
    sideways it grows from the guides' ``line`` (2,)."""
    return EvenGrowth(strain, np.array([line[0], line[1], mold.mount]))


def ungrown(points: Array, growth: Growth) -> Array:
    """Return where points (n, 3) [mm] of a hot mold's surface lie when it is cold.

    >>> growth = EvenGrowth(0.01, np.zeros(3))
    >>> ungrown(np.array([[101.0, 0.0, 0.0]]), growth).round(9).tolist()
    [[100.0, 0.0, 0.0]]
    """
    cold = points
    # Strains are below one percent: every pass gains two digits or more.
    for _ in range(8):
        cold = points - growth.at(cold)
    return np.asarray(cold)
