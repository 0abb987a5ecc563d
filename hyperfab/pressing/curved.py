"""The smooth surface behind the facets: how far it stands off them.

A mold's STL has its vertices on the machined surface and its facets as chords below it, by about h^2 kappa / 8. Left
alone that shifts every gap to one side by hundredths of a millimetre. Each facet is therefore curved with the
quadratic that the normals at its three corners ask for. At edges that are creases, by more than CREASE_DEG, each side
has normals of its own, and the edge is the curve that lies on both. Where a plane goes over into a blend the curvature
jumps, and each side tells its own: normals at the plane's end are the plane's, those at the first corners off it come
from the facets beyond, and no edge between them dips below the plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.surface import Surface

CREASE_DEG = 25.0
#: An edge that turns by more is a crease wherever it ends.
_SHARP_DEG = 45.0
#: Square of the sine of the angle between the sides of a crease whose curve they tell, at least.
_KNIFE = 0.1
#: Normals at a vertex that are apart by no more, but for rounding, are of one side.
_ONE_SIDE = 1e-5
#: Facets that turn by no more [rad] are level: an STL's corners are rounded.
_LEVEL = 2e-4
#: Facets level with each other are a plane where their edges turn, over the way across, by so many times less than
#: others of the facets beyond; and by how many where they have a corner at which nothing turns but creases and borders.
#: Of what is curved all over they turn as much, beside an inflection by up to three times less.
_LESS, _LESS_STILL = 3.0, 1.5
#: An edge that leaves a plane ends no steeper than so many times its chord. From 3 on it would dip below the plane,
#: from 2.5 on the facet within; a parabola's end is 2.
_STEEPEST = 2.5


@dataclass(frozen=True)
class Curving:
    """What curves the facets of a surface: ``bulge`` (m, 3, 3), four times the way [mm] from the middle of each edge
    ab, bc, ca to the smooth surface (``e^2 / (2 R)`` on a sphere), and ``skew`` (m, 3, 3), by how much more the edge
    bends towards its first end, on a crease those of the curve that lies on both sides; ``normals`` (m, 3, 3) those of
    the smooth surface at the corners of each facet."""

    surface: Surface
    normals: Array
    bulge: Array
    skew: Array

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
        return self.off_at(face, barycentric(self.surface, face, points))

    def off_at(self, face: Ints, weights: Array) -> Array:
        """The same where the corners of the facets have ``weights`` (n, 3)."""
        after = np.roll(weights, -1, axis=1)
        bent = self.bulge[face] + (weights - after)[..., None] * self.skew[face]
        return np.asarray(np.einsum("ne,nec->nc", weights * after, bent))

    def normal(self, face: Ints, points: Array) -> Array:
        """Unit normals (n, 3) of the smooth surface there."""
        return self.normal_at(face, barycentric(self.surface, face, points))

    def normal_at(self, face: Ints, weights: Array) -> Array:
        """The same where the corners of the facets have ``weights`` (n, 3)."""
        mean = np.einsum("nc,ncx->nx", weights, self.normals[face])
        length = np.linalg.norm(mean, axis=1, keepdims=True)
        # Between normals that are opposite there is none: the surface is folded there.
        return np.where(length > 0.5, mean / np.maximum(length, 0.5), self.surface.normals[face])

    def reach(self, face: Ints, points: Array, directions: Array) -> Array:
        """How much further (n,) [mm] rays along ``directions`` (n, 3) go from the facets to the smooth surface."""
        facet = self.surface.normals[face]
        normal = self.normal(face, points)
        slope = (directions * normal).sum(axis=1)
        height = self.height(face, points) * (facet * normal).sum(axis=1)
        # Rays that graze the surface are not followed: the tangent plane is no guide there.
        return np.where(np.abs(slope) > 0.05, height / np.where(slope == 0.0, 1.0, slope), 0.0)

    def part(self, surface: Surface, faces: Flags) -> Curving:
        """The curving of some faces, which are all of ``surface``."""
        return Curving(surface, self.normals[faces], self.bulge[faces], self.skew[faces])


@dataclass(frozen=True)
class Drawn:
    """What facets are parts of that were cut: the ``faces`` (k, 3) that were drawn, between the vertices
    that come first; which of them (m,) each facet is a part ``of``, and the ``weights`` (m, 3, 3) of that one's corners
    at its own."""

    faces: Ints
    of: Ints
    weights: Array

    def whole(self, vertices: Array) -> Surface:
        """The surface as drawn."""
        return Surface(vertices[: self.faces.max() + 1], self.faces)

    def curving(self, surface: Surface) -> Curving:
        """How the parts curve, all of ``surface``: their edges lie on the patches of the facets as drawn."""
        whole = curving(self.whole(surface.vertices))
        normals = whole.normal_at(np.repeat(self.of, 3), self.weights.reshape(-1, 3)).reshape(self.weights.shape)
        bulge, skew = np.zeros((2, *self.weights.shape))
        for edge in range(3):
            start, end = self.weights[:, edge], self.weights[:, (edge + 1) % 3]
            first, one, two, last = (whole.off_at(self.of, start + k / 3.0 * (end - start)) for k in range(4))
            one, two = one - (2.0 * first + last) / 3.0, two - (first + 2.0 * last) / 3.0
            bulge[:, edge], skew[:, edge] = 9.0 / 4.0 * (one + two), 27.0 / 4.0 * (one - two)
        return Curving(surface, normals, bulge, skew)


def curving(surface: Surface, smooth: bool = True, drawn: Drawn | None = None) -> Curving:
    """Return how the facets of a surface curve, where they were cut as those that were ``drawn`` do; with ``smooth``
    false they are taken as flat."""
    bulge, skew, upright = np.zeros((3, *surface.faces.shape, 3))
    if not smooth:
        return Curving(surface, np.repeat(surface.normals[:, None], 3, axis=1), bulge, skew)
    if drawn is not None:
        return drawn.curving(surface)
    creased, every = creases(surface), np.arange(len(surface.faces))
    normals, flat = _corners(surface, creased)
    for edge in range(3):
        a, b = surface.faces[:, edge], surface.faces[:, (edge + 1) % 3]
        # From the lower number to the higher: both facets of an edge find the same to the last bit.
        ends = np.where(a < b, edge, (edge + 1) % 3), np.where(a < b, (edge + 1) % 3, edge)
        (low, low_flat), (high, high_flat) = ((normals[every, end], flat[every, end]) for end in ends)
        chord = surface.vertices[np.maximum(a, b)] - surface.vertices[np.minimum(a, b)]
        low, high = _eased(high, low, -chord, high_flat), _eased(low, high, chord, low_flat)
        mean, turn = low + high, high - low
        length = np.linalg.norm(mean, axis=1)
        # Where normals are opposite no curve is told.
        told = length >= 0.5
        mean = np.where(told[:, None], mean / np.where(told, length, 1.0)[:, None], 0.0)
        # The middle of a circle's arc exactly; at both ends upright on the normals.
        bulge[:, edge] = (2.0 * (chord * turn).sum(axis=1) / (2.0 + length))[:, None] * mean
        skew[:, edge] = (np.where(a < b, -1.0, 1.0) * (chord * mean).sum(axis=1))[:, None] * mean
        upright[:, edge] = mean
    _meet(surface, creased, upright, bulge)
    _meet(surface, creased, upright, skew, -1.0)
    return Curving(surface, normals, bulge, skew)


def _eased(near: Array, far: Array, chord: Array, flat: Flags) -> Array:
    """Return the normals ``far`` (n, 3) at the ends of ``chord`` (n, 3); where these leave a ``flat`` (n,) whose normal
    is ``near``, no steeper than so that the edge does not dip below it."""
    rise, slope = (chord * near).sum(axis=1), (chord * (near - far)).sum(axis=1)
    leaves = flat & (slope != 0.0)
    share = np.clip(_STEEPEST * rise / np.where(leaves, slope, 1.0), 0.0, 1.0)
    return np.where(leaves[:, None], _unit(near + share[:, None] * (far - near)), far)


def _meet(surface: Surface, creased: Flags, upright: Array, bend: Array, turned: float = 1.0) -> None:
    """Let ``bend`` (m, 3, 3) be on ``creased`` (m, 3) edges what lies on the smooth surfaces of both sides.

    ``upright`` (m, 3, 3) are the normals in the middle of each edge; seen from the other side a bend is ``turned``.
    """
    face, edge = np.nonzero(creased & (surface.twins > np.arange(len(creased))[:, None]))
    other = surface.twins[face, edge]
    back = np.argmax(surface.faces[other] == surface.faces[face, (edge + 1) % 3][:, None], axis=1)
    one, two = upright[face, edge], upright[other, back]
    here, there = (bend[face, edge] * one).sum(axis=1), turned * (bend[other, back] * two).sum(axis=1)
    cosine = (one * two).sum(axis=1)
    # Along a knife's edge both sides tell the same: it stays straight.
    sure = 1.0 - cosine**2 > _KNIFE
    share = np.where(sure, 1.0 / np.where(sure, 1.0 - cosine**2, 1.0), 0.0)
    both = (share * (here - cosine * there))[:, None] * one + (share * (there - cosine * here))[:, None] * two
    bend[face, edge], bend[other, back] = both, turned * both


def creases(surface: Surface) -> Flags:
    """Which edges (m, 3) are creases.

    A crease goes on at both its ends, or ends at a border. Edges that turn as much and do not are the steepest of a
    blend in few facets: were they taken for creases, the surface would be torn there and be whole beside them.
    """
    turn = np.abs(surface.edge_turn)
    found = turn > np.radians(CREASE_DEG)
    face, edge = np.nonzero(found & (surface.twins > np.arange(len(found))[:, None]))
    if not len(face):
        return np.asarray(found)
    other = surface.twins[face, edge]
    start, end = surface.faces[face, edge], surface.faces[face, (edge + 1) % 3]
    back = np.argmax(surface.faces[other] == end[:, None], axis=1)
    goes_on = np.zeros(len(surface.vertices), dtype=bool)
    for k in range(3):
        goes_on[surface.faces[surface.twins[:, k] < 0][:, [k, (k + 1) % 3]]] = True
    kept, blunt = np.ones(len(face), dtype=bool), turn[face, edge] <= np.radians(_SHARP_DEG)
    while True:
        count = np.bincount(np.concatenate([start[kept], end[kept]]), minlength=len(goes_on))
        ends = (count == 1) & ~goes_on
        gone = kept & blunt & (ends[start] | ends[end])
        if not gone.any():
            break
        kept &= ~gone
    found[face[~kept], edge[~kept]] = found[other[~kept], back[~kept]] = False
    return np.asarray(found)


def _corners(surface: Surface, creased: Flags) -> tuple[Array, Flags]:
    """Return unit normals (m, 3, 3) at the corners of each facet, of the smooth surface on its side of ``creased``
    (m, 3) edges, and at which corners (m, 3) that side has a plane."""
    faces, twins = surface.faces, surface.twins
    face, edge = np.nonzero(~creased & (twins >= 0))
    other = twins[face, edge]
    own, across = [], []
    for corner in (edge, (edge + 1) % 3):
        own.append(3 * face + corner)
        across.append(3 * other + np.argmax(faces[other] == faces[face, corner][:, None], axis=1))
    count, side = _joined(np.concatenate(own), np.concatenate(across), faces.size)
    side = side.reshape(-1, 3)
    plane = _planes(surface, creased)
    flat = (np.bincount(side[plane].ravel(), minlength=count) > 0)[side]
    ways = np.repeat(surface.normals[:, None], 3, axis=1)
    ways[flat & ~plane[:, None]] = 0.0
    _rise(surface, side, plane, flat, ways)
    return _summed(surface, side, count, ways)[side], flat


def _planes(surface: Surface, creased: Flags) -> Flags:
    """Which facets (m,) are parts of planes: of some that are level all around a vertex, or that turn less than those
    beyond. The halves of a quadrangle and the parts of a cylinder's strip are level with each other too."""
    level = (np.abs(surface.edge_turn) <= _LEVEL) & (surface.twins >= 0)
    face, edge = np.nonzero(level)
    _, region = _joined(face, surface.twins[face, edge], len(level))
    plane = np.bincount(region) > 1
    face, edge = np.nonzero(~level & ~creased & (surface.twins >= 0))
    other, start, end = surface.twins[face, edge], surface.faces[face, edge], surface.faces[face, (edge + 1) % 3]
    length = np.linalg.norm(surface.vertices[end] - surface.vertices[start], axis=1)
    curved = np.abs(surface.edge_turn[face, edge]) * length / (surface.areas[face] + surface.areas[other])
    most = np.zeros(len(plane))
    np.maximum.at(most, region[face], curved)
    still, within = np.ones((2, len(surface.vertices)), dtype=bool)
    still[start] = still[end] = False
    for k in range(3):
        within[surface.faces[~level[:, k]][:, [k, (k + 1) % 3]]] = False
    less = np.full(len(plane), _LESS)
    less[region[still[surface.faces].any(axis=1)]] = _LESS_STILL
    plane[region[face[less[region[face]] * curved >= most[region[other]]]]] = False
    plane[region[within[surface.faces].any(axis=1)]] = True
    return np.asarray(plane[region])


def _rise(surface: Surface, side: Ints, plane: Flags, flat: Flags, ways: Array) -> None:
    """Let ``ways`` (m, 3, 3) of the facets tell the normals at the first corners off a ``plane`` (m,) by what is beyond
    them: the facets between them and its ``flat`` (m, 3) corners are part plane, part blend.

    The normal of a blend that is round leaves the plane's with the root of the height. ``side`` (m, 3) are the sides of
    creases.
    """
    between = flat.any(axis=1) & ~plane
    upright, start = np.zeros((side.max(initial=-1) + 1, 3)), np.full(side.max(initial=-1) + 1, -1)
    upright[side[plane]] = surface.normals[plane][:, None]
    face, corner = np.nonzero(between[:, None] & ~flat)
    start[side[face, corner]] = 3 * face + np.argmax(flat[face], axis=1)
    face, corner = np.nonzero(~between[:, None] & (start[side] >= 0))
    foot = start[side[face, corner]]
    up, base = upright[side.ravel()[foot]], surface.vertices[surface.faces.ravel()[foot]]
    heights = np.einsum("nkx,nx->nk", surface.vertices[surface.faces[face]] - base[:, None], up)
    own = heights[np.arange(len(face)), corner]
    root = np.sqrt(np.maximum(heights * np.sign(own)[:, None], 0.0))
    both = root.min(axis=1) + root.max(axis=1)
    share = 2.0 * np.sqrt(np.abs(own)) / np.where(both > 0.0, both, 1.0)
    told = np.bincount(side[face, corner], minlength=len(start)) > 0
    ways[told[side] & between[:, None]] = 0.0
    ways[face, corner] = up + share[:, None] * (surface.normals[face] - up)


def _joined(one: Ints, other: Ints, count: int) -> tuple[int, Ints]:
    """Return how many there are of what hangs together where ``one`` (n,) is joined to the ``other`` (n,), and to which
    each (count,) belongs."""
    graph = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(count, count))
    return connected_components(graph, directed=False)


def one_sided(faces: Ints, normals: Array) -> tuple[Ints, Ints, Array]:
    """Give each side of a crease vertices of its own: of ``faces`` (m, 3) with ``normals`` (m, 3, 3) at their corners.

    Returns which vertex (n,) each is, the faces (m, 3) among these, and their normals (n, 3).

    >>> up, aside = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]
    >>> of, faces, _ = one_sided(np.array([[7, 8, 9], [8, 7, 4]]), np.array([[up] * 3, [aside] * 3]))
    >>> of.tolist(), faces.tolist()
    ([4, 7, 8, 9, 7, 8], [[4, 5, 3], [2, 1, 0]])
    """
    used, small = np.unique(faces, return_inverse=True)
    small, normals = small.reshape(-1), normals.reshape(-1, 3)
    found = np.empty((len(used), 3))
    found[small] = normals
    beside = np.flatnonzero(np.abs(normals - found[small]).max(axis=1) > _ONE_SIDE)
    key = np.column_stack([small[beside], np.round(normals[beside] / _ONE_SIDE)])
    _, first, number = np.unique(key, axis=0, return_index=True, return_inverse=True)
    new = beside[first]
    of, found = np.concatenate([used, used[small[new]]]), np.concatenate([found, normals[new]])
    small[beside] = len(used) + number.reshape(-1)
    return of, small.reshape(-1, 3), found


def smooth_normals(surface: Surface) -> Array:
    """Unit normals (n, 3) at the vertices of the smooth surface: facet normals by N. Max's weights.

    They are exact where the vertices lie on a sphere, however irregular the facets (J. Graphics Tools 4 (1999) 1).
    """
    return _summed(surface, surface.faces, len(surface.vertices), np.repeat(surface.normals[:, None], 3, axis=1))


def _summed(surface: Surface, at: Ints, count: int, ways: Array) -> Array:
    """Unit normals (count, 3): the weighted ``ways`` (m, 3, 3) of facets at their corners, summed ``at`` (m, 3)."""
    total = np.zeros((count, 3))
    corners = [surface.vertices[surface.faces[:, k]] for k in range(3)]
    for k in range(3):
        one, two = corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]
        lengths = (one * one).sum(axis=1) * (two * two).sum(axis=1)
        weight = 2.0 * surface.areas / np.where(lengths > 0.0, lengths, 1.0)
        for axis in range(3):
            total[:, axis] += np.bincount(at[:, k], weights=weight * ways[:, k, axis], minlength=count)
    return _unit(total)


def _unit(ways: Array) -> Array:
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.asarray(ways / np.where(length > 0.0, length, 1.0))


def barycentric(surface: Surface, face: Ints, points: Array) -> Array:
    """Return the weights (n, 3) of the corners of facets ``face`` (n,) at ``points`` (n, 3) on them."""
    a, b, c = (surface.vertices[surface.faces[face, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    double = (normal * normal).sum(axis=1)
    double = np.where(double == 0.0, 1.0, double)
    wb = (np.cross(points - a, c - a) * normal).sum(axis=1) / double
    wc = (np.cross(b - a, points - a) * normal).sum(axis=1) / double
    return np.clip(np.stack([1.0 - wb - wc, wb, wc], axis=1), 0.0, 1.0)
