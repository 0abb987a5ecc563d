"""Integrals over the part of a triangle surface where a level is positive, cut exactly at the edge of contact.

The level (how deep the sandwich is compressed) is linear in each triangle. A triangle that the zero line crosses is
cut along it, so areas and forces converge with the square of the mesh size and do not jump when the line moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel

# Six points of degree 4 on the triangle: D. A. Dunavant, Int. J. Numer. Meth. Eng. 21 (1985) 1129.
_A, _B = 0.445948490915965, 0.091576213509771
_WA, _WB = 0.223381589678011, 0.109951743655322
POINTS = np.array([[p if corner != k else 1.0 - 2.0 * p for corner in range(3)] for p in (_A, _B) for k in range(3)])
WEIGHTS = np.array([_WA] * 3 + [_WB] * 3)
WEIGHTS = WEIGHTS / WEIGHTS.sum()


@dataclass(frozen=True)
class Quadrature:
    """Points inside the pieces where the level is positive.

    ``face`` (k,) the face each piece belongs to, first those that are whole; ``cut`` (k - whole, 6, 3) barycentric
    places of the points of the others; ``area`` (k, 6) [mm^2] the share of each point.
    """

    face: Ints
    cut: Array
    area: Array

    def at_corners(self, faces: Ints, values: Array) -> Array:
        """Values (k, 6, ...) at the points, linear between the ``values`` (n, ...) at the vertices."""
        corner = values[faces[self.face]]
        count, width = len(corner), int(np.prod(values.shape[1:]))
        flat = corner.reshape(count, 3, width)
        out = np.empty((count, 6, width))
        whole = count - len(self.cut)
        # Whole faces have the same points: one matrix product for all of them.
        together = POINTS @ flat[:whole].transpose(1, 0, 2).reshape(3, whole * width)
        out[:whole] = together.reshape(6, whole, width).transpose(1, 0, 2)
        out[whole:] = self.cut @ flat[whole:]
        return out.reshape(count, 6, *values.shape[1:])

    def resultant(self, faces: Ints, load: Array, direction: Array, places: Array) -> tuple[Array, Array]:
        """Force (3,) and moment (3,) about the origin of ``load`` (k, 6) at the points, along the ``direction``
        (n, 3) and at the ``places`` (n, 3) given at the vertices and linear between them."""
        found: tuple[Array, Array] = _resultant(faces, self.face, POINTS, self.cut, load, direction, places)
        return found

    def per_face(self, density: Array, count: int) -> Array:
        """Integral of ``density`` (k, 6) over each of ``count`` faces."""
        sums = np.bincount(self.face, weights=(density * self.area).sum(axis=1), minlength=count)
        return np.asarray(sums, dtype=float)


@kernel
def _resultant(
    faces: Ints, pieces: Ints, whole: Array, cut: Array, load: Array, direction: Array, places: Array
) -> tuple[Array, Array]:
    force, moment = np.zeros(3), np.zeros(3)
    first_cut = len(pieces) - len(cut)
    for k in range(len(pieces)):
        corners = faces[pieces[k]]
        weights = whole if k < first_cut else cut[k - first_cut]
        # Of one piece first: sums of like size lose fewer digits.
        f0 = f1 = f2 = m0 = m1 = m2 = 0.0
        for q in range(6):
            d0 = d1 = d2 = x0 = x1 = x2 = 0.0
            for c in range(3):
                w, v = weights[q, c], corners[c]
                d0, d1, d2 = d0 + w * direction[v, 0], d1 + w * direction[v, 1], d2 + w * direction[v, 2]
                x0, x1, x2 = x0 + w * places[v, 0], x1 + w * places[v, 1], x2 + w * places[v, 2]
            d0, d1, d2 = load[k, q] * d0, load[k, q] * d1, load[k, q] * d2
            f0, f1, f2 = f0 + d0, f1 + d1, f2 + d2
            m0, m1, m2 = m0 + x1 * d2 - x2 * d1, m1 + x2 * d0 - x0 * d2, m2 + x0 * d1 - x1 * d0
        force[0], force[1], force[2] = force[0] + f0, force[1] + f1, force[2] + f2
        moment[0], moment[1], moment[2] = moment[0] + m0, moment[1] + m1, moment[2] + m2
    return force, moment


def positive_part(level: Array, faces: Ints, areas: Array) -> Quadrature:
    """Return points over the part where ``level`` (n,), given at the vertices, is positive.

    >>> import numpy as np
    >>> half = positive_part(np.array([1.0, -1.0, -1.0]), np.array([[0, 1, 2]]), np.array([8.0]))
    >>> float(half.area.sum().round(12))
    2.0
    """
    value = level[faces]
    positive = value > 0.0
    count = positive.sum(axis=1)
    whole = np.flatnonzero(count == 3)
    pieces = []
    for number in (1, 2):
        cut = np.flatnonzero(count == number)
        # Turn each face so that the odd corner out is its first.
        odd = np.argmax(positive[cut] if number == 1 else ~positive[cut], axis=1)
        turn = (odd[:, None] + np.arange(3)) % 3
        corner = np.eye(3)[turn]
        v = np.take_along_axis(value[cut], turn, axis=1)
        on_ab = _zero(v[:, 0], v[:, 1], corner[:, 0], corner[:, 1])
        on_ac = _zero(v[:, 0], v[:, 2], corner[:, 0], corner[:, 2])
        if number == 1:
            pieces.append((cut, np.stack([corner[:, 0], on_ab, on_ac], axis=1)))
        else:
            pieces.append((cut, np.stack([on_ab, corner[:, 1], corner[:, 2]], axis=1)))
            pieces.append((cut, np.stack([on_ab, corner[:, 2], on_ac], axis=1)))
    face = np.concatenate([whole, *(f for f, _ in pieces)])
    corners = np.concatenate([c for _, c in pieces])
    share = np.ones(len(face))
    share[len(whole) :] = np.abs((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum(axis=1))
    area = (areas[face] * share)[:, None] * WEIGHTS
    return Quadrature(face, POINTS @ corners, area)


def _zero(value_a: Array, value_b: Array, a: Array, b: Array) -> Array:
    t = value_a / (value_a - value_b)
    return np.asarray(a + t[:, None] * (b - a))
