"""Ten-node tetrahedra and six-node triangles: shape functions, quadrature, and integrals over many at a time.

Shape functions and quadrature rules are scikit-fem's; the integrals are batched matrix products, because meshes of
some 10^5 elements are assembled in a second that way and in little memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hyperfab.arrays import Array


@dataclass(frozen=True)
class Reference:
    """A reference element of degree 2 with its quadrature rule (exact to degree ``order``)."""

    dimension: int
    order: int

    @cached_property
    def _element(self) -> Any:
        import skfem

        return skfem.ElementTetP2() if self.dimension == 3 else skfem.ElementTriP2()

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        from skfem.quadrature import get_quadrature

        points, weights = get_quadrature(self._element.refdom, self.order)
        return np.ascontiguousarray(points.T), weights

    @property
    def points(self) -> Array:
        """Quadrature points (q, dimension)."""
        return self._rule[0]

    @property
    def weights(self) -> Array:
        """Quadrature weights (q,), summing to the reference element's volume."""
        return self._rule[1]

    @property
    def corners(self) -> Array:
        """Corners of the reference element."""
        return np.concatenate([np.zeros((1, self.dimension)), np.eye(self.dimension)])

    @cached_property
    def tables(self) -> tuple[Array, Array]:
        """Shape functions (q, i) and their gradients (q, i, dimension) at the quadrature points."""
        return self.tabulate(self.points)

    def tabulate(self, points: Array) -> tuple[Array, Array]:
        """Return shape functions (p, i) and gradients (p, i, dimension) at reference points (p, dimension)."""
        count = 10 if self.dimension == 3 else 6
        pairs = [self._element.lbasis(points.T, i) for i in range(count)]
        values = np.stack([np.broadcast_to(value, points.shape[:1]) for value, _ in pairs], axis=1)
        gradients = np.stack([np.broadcast_to(g, points.T.shape).T for _, g in pairs], axis=1)
        return values, gradients


#: Exact for products of shape functions on straight elements (degree 4), and accurate on curved ones.
TETRAHEDRON = Reference(3, 4)
TRIANGLE = Reference(2, 4)


@dataclass(frozen=True)
class Metric:
    """Geometry of elements at the quadrature points: ``volume`` (m, q) weight times Jacobian [m^3], and
    ``inverse`` (m, q, 3, 3), d(reference)/d(place) [1/m]."""

    volume: Array
    inverse: Array


def metric(nodes: Array) -> Metric:
    """Return the metric of tetrahedra with nodes (m, 10, 3) [m]; ValueError where one is inside out."""
    _, gradients = TETRAHEDRON.tables
    jacobian = np.einsum("mid,qik->mqdk", nodes, gradients, optimize=True)
    determinant = np.linalg.det(jacobian)
    if determinant.size and determinant.min() <= 0:
        raise ValueError("an element is inside out")
    return Metric(determinant * TETRAHEDRON.weights, np.linalg.inv(jacobian))


def stiffness(found: Metric, conductivity: Array | float) -> Array:
    """Return the conduction matrices (m, 10, 10) [W/K]: integral of k grad(i) . grad(j).

    ``conductivity`` [W/m/K] is one number or one a quadrature point (m, q).
    """
    weight = found.volume * conductivity
    tensor = np.einsum("mq,mqkd,mqld->mqkl", weight, found.inverse, found.inverse, optimize=True)
    return (tensor.reshape(len(weight), -1) @ _stiffness_table()).reshape(-1, 10, 10)


def mass(found: Metric, capacity: Array | float) -> Array:
    """Return the capacity matrices (m, 10, 10) [J/K]: integral of (rho c) i j, ``capacity`` in J/m^3/K."""
    values, _ = TETRAHEDRON.tables
    table = np.einsum("qi,qj->qij", values, values).reshape(len(values), 100)
    return ((found.volume * capacity) @ table).reshape(-1, 10, 10)


def load(found: Metric, density: Array) -> Array:
    """Return the integrals (m, 10) of a density (m, q) times each shape function."""
    values, _ = TETRAHEDRON.tables
    return (found.volume * density) @ values


def facet_weights(nodes: Array) -> Array:
    """Return weight times area (f, q) [m^2] of six-node triangles with nodes (f, 6, 3) [m]."""
    return np.linalg.norm(facet_normals(nodes), axis=2) * TRIANGLE.weights


def facet_normals(nodes: Array) -> Array:
    """Return the normals (f, q, 3) of six-node triangles at the quadrature points, as long as the Jacobian."""
    _, gradients = TRIANGLE.tables
    tangents = np.einsum("fid,qik->fqdk", nodes, gradients, optimize=True)
    return np.cross(tangents[..., 0], tangents[..., 1])


def _stiffness_table() -> Array:
    _, gradients = TETRAHEDRON.tables
    table = np.einsum("qik,qjl->qklij", gradients, gradients)
    return table.reshape(-1, 100)
