"""The map from nodal temperatures to temperatures at the quadrature points of facets, and back to nodal loads.

Conditions on faces, linear or not, go through it alone; a nonlinear film changes neither the volume matrices nor
their factorisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.elements import TRIANGLE, facet_weights


@dataclass(frozen=True)
class Evenness:
    """Temperatures of a surface [degC]: the mean over its area, the least and the greatest of its nodes."""

    mean: float
    least: float
    greatest: float

    @property
    def spread(self) -> float:
        """Greatest less least [K]."""
        return self.greatest - self.least


class FacetOperator:
    """Facets with nodes (f, 6) at ``points`` [m]; ``size`` is the number of nodes of the mesh.

    ``weights`` (f, q) sum to the area [m^2].
    """

    def __init__(self, points: Array, nodes: Ints) -> None:
        self.nodes = nodes
        self.weights = facet_weights(points[nodes])
        #: The nodes of all facets, each once.
        self.all_nodes, own = np.unique(nodes, return_inverse=True)
        self._size = len(points)
        values, _ = TRIANGLE.tables
        f, q = self.weights.shape
        rows = np.repeat(np.arange(f * q), 6)
        columns = np.repeat(own.reshape(nodes.shape), q, axis=0).ravel()
        entries = np.tile(values.ravel(), f)
        self._to_points = sparse.csr_matrix((entries, (rows, columns)), shape=(f * q, len(self.all_nodes)))
        self._to_nodes = sparse.csr_matrix(self._to_points.T)
        self._products = np.einsum("qi,qj->qij", values, values).reshape(q, 36)

    @property
    def area(self) -> float:
        """Total area [m^2]."""
        return float(self.weights.sum())

    @cached_property
    def mean_weights(self) -> Array:
        """What each node (n,) counts in the mean over the area."""
        return self.load(1.0) / self.area

    def at_points(self, nodal: Array) -> Array:
        """Return a nodal field (n,) at the quadrature points (f, q)."""
        return (self._to_points @ nodal[self.all_nodes]).reshape(self.weights.shape)

    def at_points_of(self, fields: Array) -> Array:
        """Return nodal fields (n, r) at the quadrature points, one row a point (f q, r)."""
        return np.asarray(self._to_points @ fields[self.all_nodes])

    def load(self, density: Array | float) -> Array:
        """Return the nodal loads (n,) of a density per area (f, q): their sum is its integral."""
        result = np.zeros(self._size)
        result[self.all_nodes] = self.own_load(density)
        return result

    def own_load(self, density: Array | float) -> Array:
        """Return the loads on ``all_nodes`` alone."""
        return self._to_nodes @ (self.weights * density).ravel()

    def own_matrix(self, density: Array) -> sparse.csr_matrix:
        """Return the sum of ``matrices`` between ``all_nodes``."""
        weighted = sparse.diags((self.weights * density).ravel())
        return sparse.csr_matrix(self._to_nodes @ weighted @ self._to_points)

    def means(self, chosen: Sequence[Ints]) -> tuple[sparse.csr_matrix, Array]:
        """Return what makes fields on ``all_nodes`` their means over groups of points, and the area of each [m^2]."""
        weights = self.weights.ravel()
        area = np.array([weights[group].sum() for group in chosen])
        rows = np.repeat(np.arange(len(chosen)), [len(group) for group in chosen])
        points = np.concatenate([*chosen, np.zeros(0, np.int64)])
        averaging = sparse.csr_matrix((weights[points] / area[rows], (rows, points)), shape=(len(chosen), len(weights)))
        return sparse.csr_matrix(averaging @ self._to_points), area

    def matrices(self, density: Array) -> Array:
        """Return the facet matrices (f, 6, 6): the integral of density (f, q) times two shape functions."""
        return ((self.weights * density) @ self._products).reshape(-1, 6, 6)

    def mean(self, nodal: Array) -> float:
        """Return the mean of a nodal field over the area."""
        return float((self.weights * self.at_points(nodal)).sum()) / self.area

    def evenness(self, nodal: Array) -> Evenness:
        """Return how even a nodal field (n,) is over the facets."""
        own = nodal[self.all_nodes]
        return Evenness(self.mean(nodal), float(own.min()), float(own.max()))
