"""Large facets cut into small ones: what is asked at corners alone is asked everywhere."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.pressing.curved import Curving, Drawn, barycentric, curving
from hyperfab.pressing.mold import LOOKING, extent
from hyperfab.surface import Surface
from hyperfab.surface.topology import sides

#: Edges of facets are no longer than this part of the mold's size: what goes as a parabola from the mold's middle to
#: its ends is met to 1/400 of its height between the corners.
_LONGEST = 1.0 / 20.0
#: ... and no longer than this part of that beneath edges of the other mold, which turn by more than so many degrees
#: (less is a blend in few facets): there the gap jumps, or something begins to stand out.
_AT_EDGES, _EDGE_DEG = 1.0 / 16.0, 45.0
#: ... and from there on no longer than so many times the way to the edge: the nearest gap changes all along it.
_GRADING = 1.0
#: Edges are as long as each other where they differ by this share: an STL's corners are rounded.
_ROUNDED = 1e-4
#: What part of the most that facets may stand off by is next to nothing.
_NOTHING = 0.1
#: The corners of the facets that a facet is cut into, by which of its edges ab, bc, ca are cut: 0, 1, 2 are its own
#: corners, 3, 4, 5 the middles of these edges.
_CUTS = {
    (False, False, False): ((0, 1, 2),),
    (True, False, False): ((0, 3, 2), (3, 1, 2)),
    (False, True, False): ((1, 4, 0), (4, 2, 0)),
    (False, False, True): ((2, 5, 1), (5, 0, 1)),
    (True, True, False): ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    (False, True, True): ((4, 2, 5), (1, 4, 5), (1, 5, 0)),
    (True, False, True): ((5, 0, 3), (2, 5, 3), (2, 3, 1)),
    (True, True, True): ((0, 3, 5), (1, 4, 3), (2, 5, 4), (3, 4, 5)),
}


def dense(
    surface: Surface, towards: Array, other: Surface, smooth: bool = True, edges: bool = False
) -> tuple[Surface, Drawn | None]:
    """Return the same surface with its large facets that look ``towards`` (3,) the ``other`` mold cut, and their
    neighbours where they meet them; new corners are on the ``smooth`` surface. And what its facets are parts of; None
    where none was cut.

    Beneath a smaller mold facets are cut to the measure of that: beside its edges the gap goes from one facet to the
    next by as much as they are long. With ``edges`` they are cut further beneath the sharp edges of the other mold: a
    rib of it, narrower than they are long, lies between their corners.

    >>> from hyperfab.surface import Surface
    >>> square = Surface(
    ...     np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    ... )
    >>> fine, _ = dense(square, np.array([0.0, 0, 1]), square)
    >>> len(fine.faces), float(fine.areas.sum().round(12))
    (2048, 1.0)
    """
    vertices, faces, of = surface.vertices, surface.faces, np.arange(len(surface.faces))
    across = np.eye(3) - np.outer(towards, towards)
    looking, opposite = (_seen(one, way) for one, way in ((surface, towards), (other, -towards)))
    facing = Surface(other.vertices, other.faces[opposite])
    over = facing.vertices[np.unique(facing.faces)] @ across
    if edges:
        looking |= _beside(surface, towards, over)
    longest, shorter = (
        _LONGEST * extent(one.vertices, one.faces[seen]) for one, seen in ((surface, looking), (other, opposite))
    )
    cut = True
    while cut:
        vertices, faces, of, cut = _cut(vertices, faces, of, looking[of], longest)
    centre = facing.areas @ facing.vertices[facing.faces].mean(axis=1) @ across / facing.areas.sum()
    within = np.linalg.norm(over - centre, axis=1).max() + longest
    cut = shorter < longest
    while cut:
        middle, reach = _circles(vertices @ across, faces)
        beneath = np.linalg.norm(middle - centre, axis=1) - reach <= within
        vertices, faces, of, cut = _cut(vertices, faces, of, looking[of] & beneath, shorter)
    finest = min(shorter, longest) * _AT_EDGES
    line = _edges_beneath(other, surface, towards, finest) @ across if edges else np.zeros((0, 3))
    cut = len(line) > 0
    while cut:
        middle, reach = _circles(vertices @ across, faces)
        chosen = np.flatnonzero(looking[of] & (np.sqrt(3.0) * reach > finest * (1.0 + _ROUNDED)))
        away = cKDTree(line).query(middle[chosen])[0] - reach[chosen]
        at_edge = np.zeros(len(faces), dtype=bool)
        at_edge[chosen] = np.sqrt(3.0) * reach[chosen] > _GRADING * away + _ROUNDED * finest
        vertices, faces, of, cut = _cut(vertices, faces, of, at_edge, finest)
    if len(faces) == len(surface.faces):
        return surface, None
    # Halves of halves, to the last bit: two facets find the same at an edge of theirs.
    weights = barycentric(surface, np.repeat(of, 3), vertices[faces].reshape(-1, 3)).reshape(-1, 3, 3)
    drawn = Drawn(surface.faces, of, np.round(weights * 2.0**20) / 2.0**20)
    face = np.empty(len(vertices), dtype=of.dtype)
    face[faces] = of[:, None]
    new = np.arange(len(surface.vertices), len(vertices))
    vertices[new] += curving(surface, smooth).off(face[new], vertices[new])
    return Surface(vertices, faces), drawn


def bent(curve: Curving, most: float, off: float) -> tuple[Surface, Array]:
    """Return the smooth surface as facets whose normals turn by no more than ``most`` [rad] along an edge, which it
    stands ``off`` [mm] at most, and the unit normals (m, 3, 3) at their corners: others are cut, their new corners on
    the smooth surface.

    Where it stands off by next to nothing beside that they may turn by more: a fold does however finely it is cut.

    >>> from hyperfab.surface import Surface
    >>> one = Surface(np.eye(3), np.array([[0, 1, 2]]))
    >>> curve = Curving(one, np.eye(3)[None], np.zeros((1, 3, 3)), np.zeros((1, 3, 3)))  # 90 degrees from end to end
    >>> [len(bent(curve, np.radians(most), 0.5)[0].faces) for most in (91.0, 61.0)]
    [1, 4]
    """
    surface = curve.surface
    vertices, faces, of = surface.vertices, surface.faces, np.arange(len(surface.faces))
    while True:
        normals = curve.normal(np.repeat(of, 3), vertices[faces].reshape(-1, 3)).reshape(-1, 3, 3)
        ends, number = sides(faces, len(vertices))
        turn = np.linalg.norm(np.roll(normals, -1, axis=1) - normals, axis=2)
        far = np.linalg.norm(vertices[ends[:, 1]] - vertices[ends[:, 0]], axis=1)[number] * turn / 8.0
        turns = (turn > 2.0 * np.sin(most / 2.0)) & (far > _NOTHING * off)
        long = np.bincount(number[turns | (far > off)], minlength=len(ends)) > 0
        if not long.any():
            break
        vertices, faces, of = _halved(vertices, faces, of, ends, number, long)
    face = np.empty(len(vertices), dtype=of.dtype)
    face[faces] = of[:, None]
    new = np.arange(len(surface.vertices), len(vertices))
    vertices = np.concatenate([surface.vertices, vertices[new] + curve.off(face[new], vertices[new])])
    return Surface(vertices, faces), normals


def _circles(vertices: Array, faces: Ints) -> tuple[Array, Array]:
    """Return the middles (m, 3) of facets and how far from them their farthest corner is (m,)."""
    corners = vertices[faces]
    middle = corners.mean(axis=1)
    return middle, np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)


def _seen(surface: Surface, towards: Array) -> Flags:
    """Which facets (m,) look ``towards`` (3,); all where none does."""
    looking = np.asarray(surface.normals @ towards > LOOKING)
    return looking if looking.any() else ~looking


def _beside(surface: Surface, towards: Array, over: Array) -> Flags:
    """Which facets (m,) are upright walls that the other mold, seen along ``towards`` (3,) at ``over`` (n, 3), goes
    beyond: what they stand opposite to in the closed press changes along them."""
    found = np.abs(surface.normals @ towards) <= LOOKING
    upright = np.flatnonzero(found)
    plan = np.linalg.eigh(np.outer(towards, towards))[1][:, :2]
    outline = over[ConvexHull(over @ plan).vertices]
    starts = surface.vertices[surface.faces[upright, 0]]
    beyond = (surface.normals[upright] @ outline.T).max(axis=1) - (starts * surface.normals[upright]).sum(axis=1)
    found[upright] = beyond > _ROUNDED * np.ptp(outline, axis=0).max()
    return found


def _edges_beneath(other: Surface, surface: Surface, towards: Array, apart: float) -> Array:
    """Return points (k, 3) along the edges of the ``other`` mold where the surface has none of its own beneath: beside
    those, as where both molds end alike, the gap does not jump within a facet."""
    line, own = (_edge_points(one, way, apart) for one, way in ((other, towards), (surface, -towards)))
    if not len(line) or not len(own):
        return line
    across = np.eye(3) - np.outer(towards, towards)
    return np.asarray(line[cKDTree(own @ across).query(line @ across)[0] > apart * (1.0 + _ROUNDED)])


def _edge_points(surface: Surface, towards: Array, apart: float) -> Array:
    """Return points (k, 3) along the sharp edges, outward or inward, of facets that look against ``towards`` (3,), no
    more than ``apart`` mm from one to the next."""
    out = np.abs(surface.edge_turn) > np.radians(_EDGE_DEG)
    face, edge = np.nonzero(out & (surface.normals @ towards < -LOOKING)[:, None])
    start, end = (surface.vertices[surface.faces[face, (edge + k) % 3]] for k in (0, 1))
    count = np.ceil(np.linalg.norm(end - start, axis=1) / apart - _ROUNDED).astype(int) + 1
    one = np.repeat(np.arange(len(count)), count)
    step = np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)
    share = (step / np.maximum(count - 1, 1)[one])[:, None]
    return np.asarray(start[one] + share * (end[one] - start[one]))


def _cut(vertices: Array, faces: Ints, of: Ints, chosen: Flags, longest: float) -> tuple[Array, Ints, Ints, bool]:
    """Return vertices, faces and the facets ``of`` which they are parts, each edge of a ``chosen`` face that is too
    long cut in its middle; and whether any was."""
    ends, number = sides(faces, len(vertices))
    long = np.linalg.norm(vertices[ends[:, 1]] - vertices[ends[:, 0]], axis=1) > longest * (1.0 + _ROUNDED)
    long &= np.bincount(number[chosen].ravel(), minlength=len(ends)) > 0
    return (*_halved(vertices, faces, of, ends, number, long), True) if long.any() else (vertices, faces, of, False)


def _halved(vertices: Array, faces: Ints, of: Ints, ends: Ints, number: Ints, long: Flags) -> tuple[Array, Ints, Ints]:
    """Return vertices, faces and the facets ``of`` which they are parts, ``long`` edges (e,) of ``sides`` halved."""
    middle = len(vertices) + np.cumsum(long) - 1
    corners = np.concatenate([faces, middle[number]], axis=1)
    pattern, found, kept = long[number], [], []
    for cuts, children in _CUTS.items():
        these = np.flatnonzero((pattern == cuts).all(axis=1))
        for child in children:
            found.append(corners[these][:, list(child)])
            kept.append(these)
    parts = np.concatenate(kept)
    order = np.argsort(parts, kind="stable")
    points = np.concatenate([vertices, vertices[ends[long]].mean(axis=1)])
    return points, np.concatenate(found)[order], of[parts[order]]
