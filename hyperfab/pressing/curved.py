"""The smooth surface behind the facets: how far it stands off them.

A mold's STL has its vertices on the machined surface and its facets as chords below it, by about h^2 kappa / 8. Left
alone that shifts every gap to one side by hundredths of a millimetre. Each facet is therefore curved with the
quadratic that its three vertex normals ask for; edges that are creases, by more than CREASE_DEG, stay straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.surface import Surface

CREASE_DEG = 25.0


@dataclass(frozen=True)
class Curving:
    """What curves the facets of a surface: ``bulge`` (m, 3, 3), four times the way [mm] from the middle of each edge
    ab, bc, ca to the smooth surface (``e^2 / (2 R)`` on a sphere), and ``skew`` (m, 3, 3), by how much more the edge
    bends towards its first end, both zero where an end lies on a crease; ``normals`` (n, 3) those of the smooth surface
    at the vertices; ``smooth`` (m,) facets without a corner on a crease."""

    surface: Surface
    normals: Array
    bulge: Array
    skew: Array
    smooth: Flags

    @cached_property
    def room(self) -> Array:
        """How far (m,) [mm] the smooth surface is from each facet at most: products of two weights add up to 1/3."""
        most = np.linalg.norm(self.bulge, axis=2) + np.linalg.norm(self.skew, axis=2)
        return np.asarray(most.max(axis=1) / 3.0)

    def height(self, face: Ints, points: Array) -> Array:
        """How far (n,) [mm] the smooth surface stands off the facets ``face`` (n,) at ``points`` (n, 3) on them."""
        return np.asarray((self.off(face, points) * self.surface.normals[face]).sum(axis=1))

    def off(self, face: Ints, points: Array) -> Array:
        """The way (n, 3) [mm] from ``points`` (n, 3) on the facets ``face`` (n,) to the smooth surface."""
        weights = barycentric(self.surface, face, points)
        after = np.roll(weights, -1, axis=1)
        bent = self.bulge[face] + (weights - after)[..., None] * self.skew[face]
        return np.asarray(np.einsum("ne,nec->nc", weights * after, bent))

    def normal(self, face: Ints, points: Array, facet: Array) -> Array:
        """Unit normals (n, 3) of the smooth surface there; beside a crease those of the ``facet`` (n, 3)."""
        weights = barycentric(self.surface, face, points)
        corners = self.normals[self.surface.faces[face]]
        mean = (weights[..., None] * corners).sum(axis=1)
        mean = mean / np.linalg.norm(mean, axis=1, keepdims=True)
        return np.where(self.smooth[face, None], mean, facet)

    def reach(self, face: Ints, points: Array, directions: Array) -> Array:
        """How much further (n,) [mm] rays along ``directions`` (n, 3) go from the facets to the smooth surface."""
        facet = self.surface.normals[face]
        normal = self.normal(face, points, facet)
        slope = (directions * normal).sum(axis=1)
        height = self.height(face, points) * (facet * normal).sum(axis=1)
        # Rays that graze the surface are not followed: the tangent plane is no guide there.
        return np.where(np.abs(slope) > 0.05, height / np.where(slope == 0.0, 1.0, slope), 0.0)

    def part(self, surface: Surface, faces: Flags) -> Curving:
        """The curving of some faces, which are all of ``surface``."""
        return Curving(surface, self.normals, self.bulge[faces], self.skew[faces], self.smooth[faces])


def curving(surface: Surface, smooth: bool = True) -> Curving:
    """Return how the facets of a surface curve; with ``smooth`` false they are taken as flat."""
    if not smooth:
        flat = np.zeros(len(surface.faces), dtype=bool)
        none = np.zeros((*surface.faces.shape, 3))
        return Curving(surface, surface.vertex_normals, none, none, flat)
    creased = np.zeros(len(surface.vertices), dtype=bool)
    for edge in range(3):
        sharp = np.abs(surface.edge_turn[:, edge]) > np.radians(CREASE_DEG)
        creased[surface.faces[sharp][:, [edge, (edge + 1) % 3]]] = True
    normals = smooth_normals(surface)
    bulge, skew = np.zeros((2, *surface.faces.shape, 3))
    for edge in range(3):
        a, b = surface.faces[:, edge], surface.faces[:, (edge + 1) % 3]
        # From the lower number to the higher: both facets of an edge find the same to the last bit.
        low, high = np.minimum(a, b), np.maximum(a, b)
        chord = surface.vertices[high] - surface.vertices[low]
        mean, turn = normals[low] + normals[high], normals[high] - normals[low]
        length = np.linalg.norm(mean, axis=1)
        # Where normals are opposite no curve is told.
        told = ~(creased[a] | creased[b] | (length < 0.5))
        mean = np.where(told[:, None], mean / np.where(told, length, 1.0)[:, None], 0.0)
        # The middle of a circle's arc exactly; at both ends upright on the normals.
        bulge[:, edge] = (2.0 * (chord * turn).sum(axis=1) / (2.0 + length))[:, None] * mean
        skew[:, edge] = (np.where(a < b, -1.0, 1.0) * (chord * mean).sum(axis=1))[:, None] * mean
    return Curving(surface, normals, bulge, skew, np.asarray(~creased[surface.faces].any(axis=1)))


def smooth_normals(surface: Surface) -> Array:
    """Unit normals (n, 3) at the vertices of the smooth surface: facet normals by N. Max's weights.

    They are exact where the vertices lie on a sphere, however irregular the facets (J. Graphics Tools 4 (1999) 1).
    """
    total = np.zeros_like(surface.vertices)
    corners = [surface.vertices[surface.faces[:, k]] for k in range(3)]
    for k in range(3):
        one, two = corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]
        lengths = (one * one).sum(axis=1) * (two * two).sum(axis=1)
        weighted = np.cross(one, two) / np.where(lengths > 0.0, lengths, 1.0)[:, None]
        for axis in range(3):
            total[:, axis] += np.bincount(surface.faces[:, k], weights=weighted[:, axis], minlength=len(total))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / np.where(length > 0.0, length, 1.0))


def barycentric(surface: Surface, face: Ints, points: Array) -> Array:
    """Return the weights (n, 3) of the corners of facets ``face`` (n,) at ``points`` (n, 3) on them."""
    a, b, c = (surface.vertices[surface.faces[face, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    double = (normal * normal).sum(axis=1)
    double = np.where(double == 0.0, 1.0, double)
    wb = (np.cross(points - a, c - a) * normal).sum(axis=1) / double
    wc = (np.cross(b - a, points - a) * normal).sum(axis=1) / double
    return np.clip(np.stack([1.0 - wb - wc, wb, wc], axis=1), 0.0, 1.0)
