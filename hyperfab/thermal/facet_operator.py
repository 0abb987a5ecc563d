"""The map from nodal temperatures to temperatures at the quadrature points of facets, and back to nodal loads.

Conditions on faces, linear or not, go through it alone; a nonlinear film changes neither the volume matrices nor
their factorisation.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.elements import TRIANGLE, facet_weights


class FacetOperator:
    """Facets with nodes (f, 6) at ``points`` [m]; ``size`` is the number of nodes of the mesh.

    ``weights`` (f, q) sum to the area [m^2].
    """

    def __init__(self, points: Array, nodes: Ints) -> None:
        self.nodes = nodes
        self.weights = facet_weights(points[nodes])
        values, _ = TRIANGLE.tables
        f, q = self.weights.shape
        rows = np.repeat(np.arange(f * q), 6)
        columns = np.repeat(nodes, q, axis=0).ravel()
        entries = np.tile(values.ravel(), f)
        self._to_points = sparse.csr_matrix((entries, (rows, columns)), shape=(f * q, len(points)))
        self._to_nodes = sparse.csr_matrix(self._to_points.T)
        self._products = np.einsum("qi,qj->qij", values, values).reshape(q, 36)

    @property
    def area(self) -> float:
        """Total area [m^2]."""
        return float(self.weights.sum())

    def at_points(self, nodal: Array) -> Array:
        """Return a nodal field (n,) at the quadrature points (f, q)."""
        return (self._to_points @ nodal).reshape(self.weights.shape)

    def at_points_of(self, fields: Array) -> Array:
        """Return nodal fields (n, r) at the quadrature points, one row a point (f q, r)."""
        return np.asarray(self._to_points @ fields)

    def load(self, density: Array | float) -> Array:
        """Return the nodal loads (n,) of a density per area (f, q): their sum is its integral."""
        return self._to_nodes @ (self.weights * density).ravel()

    def matrices(self, density: Array) -> Array:
        """Return the facet matrices (f, 6, 6): the integral of density (f, q) times two shape functions."""
        return ((self.weights * density) @ self._products).reshape(-1, 6, 6)

    def mean(self, nodal: Array) -> float:
        """Return the mean of a nodal field over the area."""
        return float((self.weights * self.at_points(nodal)).sum()) / self.area
