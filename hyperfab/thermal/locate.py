"""Where in a mesh points are: their elements, and the weights of the ten nodes there."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Ints
from hyperfab.thermal.elements import TETRAHEDRON

#: Reference coordinates may be this far outside and still count as inside: curved faces are found to a hair.
OUTSIDE = 0.02
CANDIDATES = 24
CHUNK = 1024


class Locator:
    """Finds points in ten-node tetrahedra ``elements`` (m, 10) with nodes at ``points`` (n, 3)."""

    def __init__(self, points: Array, elements: Ints) -> None:
        self._points = points
        self._elements = elements
        self._tree = cKDTree(points[elements[:, :4]].mean(axis=1))

    def find(self, places: Array) -> tuple[Ints, Array, Array]:
        """Return nodes (p, 10), weights (p, 10) and how far outside each place (p, 3) is.

        The last is in reference coordinates: 0 inside, 1 about an element away. Places outside get the weights of
        the nearest corner, edge or face of an element, roughly.
        """
        pieces = [self._find(places[start : start + CHUNK]) for start in range(0, len(places), CHUNK)]
        nodes, weights, outside = zip(*pieces, strict=True)
        return np.concatenate(nodes), np.concatenate(weights), np.concatenate(outside)

    def sensor(self, place: Array) -> Array | None:
        """Return the weights of all nodes (n,) for the value at a place (3,); None where it is in no element."""
        nodes, weights, outside = self.find(place[None, :])
        if outside[0] > OUTSIDE:
            return None
        row = np.zeros(len(self._points))
        np.add.at(row, nodes[0], weights[0])
        return row

    def _find(self, places: Array) -> tuple[Ints, Array, Array]:
        count = min(CANDIDATES, len(self._elements))
        _, near = self._tree.query(places, k=count)
        candidates = near.reshape(len(places), count)
        reference = self._reference(candidates.ravel(), np.repeat(places, count, axis=0))
        inside = np.minimum(reference.min(axis=1), 1.0 - reference.sum(axis=1)).reshape(-1, count)
        best = np.argmax(np.where(np.isnan(inside), -np.inf, inside), axis=1)
        rows = np.arange(len(places))
        chosen = reference.reshape(-1, count, 3)[rows, best]
        outside = np.maximum(-inside[rows, best], 0.0)
        far = outside > OUTSIDE
        chosen[far] = np.clip(chosen[far], 0.0, 1.0)
        chosen[far] /= np.maximum(chosen[far].sum(axis=1), 1.0)[:, None]
        values, _ = TETRAHEDRON.tabulate(chosen)
        return self._elements[candidates[rows, best]], values, outside

    def _reference(self, elements: Ints, places: Array) -> Array:
        """Return the reference coordinates of places (c, 3) in one element each, by Newton's method."""
        nodes = self._points[self._elements[elements]]
        edges = np.stack([nodes[:, i] - nodes[:, 0] for i in (1, 2, 3)], axis=2)
        inverse = np.linalg.inv(edges)
        reference = np.einsum("cij,cj->ci", inverse, places - nodes[:, 0])
        for _ in range(4):
            clipped = np.clip(reference, -0.5, 1.5)
            values, _ = TETRAHEDRON.tabulate(clipped)
            missing = places - np.einsum("ci,cid->cd", values, nodes)
            reference = clipped + np.einsum("cij,cj->ci", inverse, missing)
        return np.asarray(reference, dtype=np.float64)
