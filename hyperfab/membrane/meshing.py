"""Triangles of graded size inside a flat outline.

Points are seeded from a quadtree that follows the wanted edge length, spread by repulsion along the edges of
their Delaunay triangulation (the idea of Persson and Strang, SIAM Review 46 (2004) 329, with fixed boundary
points), and triangulated. All of it is deterministic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.membrane.kernels import polygon_distance
from hyperfab.membrane.outline import Outline
from hyperfab.numerics.threads import for_nodes
from hyperfab.numerics.vectors import cross2
from hyperfab.surface.topology import sides

#: Wanted edge length [mm] at points (n, 2).
SizeField = Callable[[Array], Array]

#: A spring is made this much longer than the wanted edge, so that points push each other apart everywhere.
_STRETCHED = 1.2
_TIME_STEP = 0.2
#: Triangulations: the topology settles long before the points do.
_ROUNDS = 12
_MOVES_PER_ROUND = 4
#: Interior points keep this part of an edge length from the boundary.
_CLEARANCE = 0.45
#: How often edges are shortened for an outline that is not convex.
_MOST_FINER = 5


@dataclass(frozen=True)
class Triangles:
    """Corner points (n, 2) [mm], triangles (m, 3) anticlockwise, and boundary edges (k, 2) with their arc (k,)."""

    points: Array
    triangles: Ints
    edges: Ints
    edge_arc: Ints


def triangulate(outline: Outline, size: SizeField, *, seed: int = 0, jitter: float = 0.0) -> Triangles:
    """Mesh an outline with edges of about ``size``.

    ``seed`` chooses among equally good meshes; ``jitter`` then moves interior points at random by that part of
    the local edge length (for studies of how far a result hangs on the mesh). In an outline that is not convex the
    edges are made shorter until the triangles have all of the rim; InputError where that does not help.
    """
    for finer in range(_MOST_FINER):
        found = _triangulated(outline, lambda points: size(points) / 1.5**finer, seed, jitter)  # noqa: B023
        if outline.convex or _has_rim(found):
            return found
    raise InputError(
        "the outline is too narrow somewhere for elements of this size", remedy="choose a smaller --mesh-size"
    )


def _triangulated(outline: Outline, size: SizeField, seed: int, jitter: float) -> Triangles:
    fixed, edges, edge_arc = _boundary(outline, size)
    random = np.random.default_rng(seed)
    moving = _seeds(outline, size, random)
    moving = moving[outline.inside(moving, _CLEARANCE * size(moving))] if len(moving) else moving
    points = _spread(outline, size, fixed, moving)
    if jitter > 0.0:
        free = slice(len(fixed), None)
        points[free] += jitter * size(points[free])[:, None] * random.uniform(-1, 1, points[free].shape)
    return _joined(Triangles(points, _within(outline, points, len(fixed)), edges, edge_arc), len(fixed))


def _joined(found: Triangles, rim: int) -> Triangles:
    """Drop points that no triangle has, as Delaunay's method leaves where two all but coincide; not the ``rim``."""
    used = np.zeros(len(found.points), bool)
    used[:rim] = True
    used[found.triangles] = True
    if used.all():
        return found
    number = np.cumsum(used) - 1
    return Triangles(found.points[used], number[found.triangles], found.edges, found.edge_arc)


def _has_rim(found: Triangles) -> bool:
    """Whether each edge of the rim is a side of exactly one triangle, and no other side is lonely."""
    ends, number = sides(found.triangles, len(found.points))
    lonely = ends[np.bincount(number.ravel()) == 1]
    return np.array_equal(lonely, np.unique(np.sort(found.edges, axis=1), axis=0))


def _within(outline: Outline, points: Array, rim: int) -> Ints:
    """Return the Delaunay triangles inside of the outline, whose first ``rim`` points go around it."""
    triangles = _delaunay(points)
    if outline.convex:
        return triangles
    middle = points[triangles].mean(axis=1)
    return triangles[polygon_distance(middle, np.ascontiguousarray(points[:rim])) > 0.0]


def graded(edge: Array, fine: float, coarse: float, growth: float) -> SizeField:
    """Return a size field: ``fine`` on the points (n, 2) of a curve, growing by ``growth`` per mm up to ``coarse``."""
    tree = cKDTree(edge)

    def size(points: Array) -> Array:
        distance, _ = tree.query(points, workers=for_nodes(len(points)))
        return np.asarray(np.minimum(coarse, fine + growth * distance))

    return size


def _boundary(outline: Outline, size: SizeField) -> tuple[Array, Ints, Ints]:
    """Place points on the boundary so that each edge has about its wanted length; corners are kept."""
    pieces, arc_of = [], []
    for number, arc in enumerate(outline.arcs):
        fine = np.linspace(0.0, 1.0, 2001)
        density = 1.0 / size(arc.points(fine))
        count = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))]) * arc.length / 2000
        edges = max(2, int(np.ceil(count[-1] - 0.25)))
        places = np.interp(np.linspace(0.0, count[-1], edges + 1), count, fine)[:-1]
        pieces.append(arc.points(places))
        arc_of += [number] * edges
    points = np.concatenate(pieces)
    index = np.arange(len(points))
    return points, np.column_stack([index, np.roll(index, -1)]), np.asarray(arc_of)


def _seeds(outline: Outline, size: SizeField, random: np.random.Generator) -> Array:
    """Return points whose density follows the size field: leaves of a quadtree, thinned out by chance."""
    corners = np.concatenate([arc.points(np.linspace(0, 1, 65)) for arc in outline.arcs])
    low, high = corners.min(axis=0), corners.max(axis=0)
    side = float((high - low).max())
    turn = random.uniform(0, 2 * np.pi)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    origin = 0.5 * (low + high) + 0.25 * side * random.uniform(-1, 1, 2)
    cells, width, found = np.zeros((1, 2)), 4.0 * side, []
    while len(cells):
        length = size(cells @ rotation.T + origin)
        # Points of a mesh with edges h have the density 2/(sqrt(3) h²).
        expected = width**2 * 2 / (np.sqrt(3) * length**2)
        near = np.linalg.norm(cells @ rotation.T + origin - 0.5 * (low + high), axis=1) < side + width
        leaf = (expected <= 1.0) & near
        chosen = leaf & (random.uniform(size=len(cells)) < expected)
        found.append(cells[chosen] + 0.3 * width * random.uniform(-1, 1, (int(chosen.sum()), 2)))
        split = cells[near & ~leaf]
        quarter = 0.25 * width * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
        cells = (split[:, None, :] + quarter).reshape(-1, 2)
        width *= 0.5
    return np.concatenate(found) @ rotation.T + origin


def _spread(outline: Outline, size: SizeField, fixed: Array, moving: Array) -> Array:
    """Let the points push each other apart until the edges have their wanted lengths."""
    points, count = np.concatenate([fixed, moving]), len(fixed)
    for round_ in range(_ROUNDS):
        if round_ in (2, 4, 6):
            points = _thinned(points, size, count)
        triangles = _delaunay(points)
        ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys = np.unique(ends[:, 0] * len(points) + ends[:, 1])
        bars = np.column_stack([keys // len(points), keys % len(points)])
        clearance = _CLEARANCE * size(points[count:])
        wanted = size(0.5 * (points[bars[:, 0]] + points[bars[:, 1]]))
        for _ in range(_MOVES_PER_ROUND):
            vector = points[bars[:, 0]] - points[bars[:, 1]]
            length = np.maximum(np.linalg.norm(vector, axis=1), 1e-12)
            target = wanted * _STRETCHED * np.sqrt((length**2).sum() / (wanted**2).sum())
            push = (np.maximum(target - length, 0.0) / length)[:, None] * vector
            force = np.zeros_like(points)
            for axis in (0, 1):
                force[:, axis] = np.bincount(bars[:, 0], push[:, axis], len(points))
                force[:, axis] -= np.bincount(bars[:, 1], push[:, axis], len(points))
            force[:count] = 0.0
            trial = points + _TIME_STEP * force
            kept = outline.inside(trial[count:], clearance)
            points[count:][kept] = trial[count:][kept]
    return points


def _thinned(points: Array, size: SizeField, count: int) -> Array:
    """Drop interior points that are crowded: nearest neighbour closer than six tenths of the wanted edge."""
    tree = cKDTree(points)
    distance, neighbour = tree.query(points[count:], k=2, workers=for_nodes(len(points)))
    own = np.arange(count, len(points))
    other = np.where(neighbour[:, 0] == own, neighbour[:, 1], neighbour[:, 0])
    crowded = distance[:, 1] < 0.6 * size(points[count:])
    drop = crowded & ((other < count) | (own > other))
    return np.concatenate([points[:count], points[count:][~drop]])


def _delaunay(points: Array) -> Ints:
    """Return the Delaunay triangles, anticlockwise, without the slivers between points on a straight edge."""
    triangles = Delaunay(points).simplices.astype(np.int64)
    a, b, c = (points[triangles[:, i]] for i in range(3))
    double = cross2(b - a, c - a)
    triangles[double < 0] = triangles[double < 0][:, [0, 2, 1]]
    longest = np.max([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return triangles[np.abs(double) > 1e-6 * longest]
