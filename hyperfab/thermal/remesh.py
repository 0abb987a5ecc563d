"""STL surfaces of many facets meshed anew, and the mesh laid back on the surface it was made from.

Each facet of an STL part would become a face of the solid: thousands of them make tiny tetrahedra and slow booleans.
The surface is therefore meshed anew at about the wanted edge length, finer where that would stray; then the nodes of
the ten-node tetrahedra, those in the middle of edges too, are laid on the given surface. The curved facets follow
it an order closer than flat ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import NotConverged
from hyperfab.surface import Surface
from hyperfab.surface.topology import sides
from hyperfab.thermal.geometry import Body, Geometry, Stl
from hyperfab.thermal.mesh import EDGES, oriented, six_volumes, twisted
from hyperfab.thermal.mesher import RawMesh, mesh_surface

#: Rounds of refinement where the new surface strays, and the longest edges tried first, as shares of mesh_size: the
#: mesher gives up on some edge lengths and not on others.
ROUNDS = 6
SHARES = (1.0, 0.8, 0.6)
#: Seconds for each try.
PATIENCE = 30.0
#: The distance of a curved facet falls with the third power of its edge; edges are not cut below this share at once.
ORDER = 3.0
LEAST_CUT = 0.4
#: The mesher smooths what sizes it is given, so they are asked for smaller.
HARDER = 0.7
#: Each facet is looked at on this many pieces a side.
PIECES = 4
#: A node is not moved where an element would fall below this share of its volume.
LEAST_VOLUME = 0.3
#: How closely the nodes inside follow those on the surface, relative to the moves.
FOLLOWS = 1e-3


@dataclass(frozen=True)
class Remeshed:
    """A coarser surface, with the given one as its ``fine``, and how far its curved facets lie from it [mm]."""

    surface: Stl
    deviation: float


def remesh_surface(
    given: Stl,
    mesh_size: float,
    tolerance: float,
    *,
    waiting: Callable[[float], None] = lambda seconds: None,
) -> Remeshed | None:
    """Mesh a closed surface anew with edges up to ``mesh_size`` [mm], until curved facets keep to ``tolerance`` [mm].

    Returns the closest of some rounds, and None where the mesher makes nothing of the surface.
    """
    onto = Surface(given.vertices, given.triangles)
    sizes = np.full(len(given.vertices), mesh_size)
    best: Remeshed | None = None
    failures = 0
    for _ in range(ROUNDS):
        finer = sizes < 0.999 * mesh_size
        points = np.column_stack([given.vertices[finer], sizes[finer]])
        try:
            vertices, triangles = mesh_surface(
                given, SHARES[failures] * mesh_size, points, patience=PATIENCE, waiting=waiting
            )
        except NotConverged:
            failures += 1
            if failures == len(SHARES):
                break
            continue
        curved = _curved(vertices, triangles, onto)
        near = curved.nearest(given.vertices)
        strays = np.abs(near.distance)
        deviation = float(max(strays.max(), np.abs(onto.nearest(curved.vertices).distance).max()))
        if best is None or deviation < best.deviation:
            best = Remeshed(Stl(vertices, triangles, given.name, fine=given), deviation)
        if deviation <= tolerance:
            break
        facet = near.face // PIECES**2
        worst = np.zeros(len(triangles))
        np.maximum.at(worst, facet, strays)
        corners = vertices[triangles]
        edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        wanted = edge * np.clip((tolerance / np.maximum(worst, 1e-300)) ** (1 / ORDER), LEAST_CUT, 1.0)
        stray = worst[facet] > tolerance
        sizes[stray] = np.minimum(sizes, wanted[facet])[stray] * HARDER
    return best


def as_given(volumes: Array, geometry: Geometry) -> Array:
    """Return the volume of each part [mm^3] by the surfaces that coarser ones stand for, of its ``volumes`` by these.

    A cavity is taken from the first part that holds its middle; bodies count as if none of a part overlapped.
    """
    found = volumes.copy()
    bounds = [part.bounds for part in geometry.parts]
    for number, part in enumerate(geometry.parts):
        found[number] += _gained(part)
    for cavity in geometry.cavities:
        middle = np.mean(cavity.bounds, axis=0)
        holds = [bool(np.all((low <= middle) & (middle <= high))) for low, high in bounds]
        if any(holds):
            found[holds.index(True)] -= _gained(cavity)
    return found


def _gained(body: Body) -> float:
    """Return by how much the surfaces given hold more than the coarser ones [mm^3]."""
    pairs = [(one.fine, one) for one in body.shapes if isinstance(one, Stl) and one.fine is not None]
    corners = [[of.vertices[of.triangles] for of in pair] for pair in pairs]
    fine, coarse = (sum(float(np.linalg.det(pair[i]).sum()) for pair in corners) for i in (0, 1))
    return (fine - coarse) / 6.0


def laid_back(raw: RawMesh, geometry: Geometry) -> RawMesh:
    """Move the nodes on coarser STL surfaces onto the surfaces these stand for.

    Only nodes whose every facet lies on one such surface move, and none that would spoil an element. Where curved
    elements would turn inside out, those inside move along.
    """
    shapes = [
        shape for body in (*geometry.parts, *geometry.cavities) for shape in body.shapes
        if isinstance(shape, Stl) and shape.fine is not None
    ]  # fmt: skip
    if not shapes:
        return raw
    low, high = geometry.bounds
    tight = 1e-6 * float(np.linalg.norm(high - low))
    points = raw.points.copy()
    corners = raw.points[raw.surface]
    ends, middles = _edge_nodes(raw)
    moved = np.zeros(len(points), dtype=bool)
    for shape in shapes:
        assert shape.fine is not None
        coarse = Surface(shape.vertices, shape.triangles)
        at = np.concatenate([corners.reshape(-1, 3), corners.mean(axis=1)])
        near = np.abs(coarse.nearest(at).distance) <= tight
        lies = near[: corners.shape[0] * 3].reshape(-1, 3).all(axis=1) & near[corners.shape[0] * 3 :]
        vertices = np.setdiff1d(raw.surface[lies], raw.surface[~lies])
        mine = _on(ends, raw.surface[lies]) & ~_on(ends, raw.surface[~lies])
        chosen = np.concatenate([vertices, middles[mine]])
        onto = Surface(shape.fine.vertices, shape.fine.triangles)
        points[chosen] = onto.nearest(raw.points[chosen]).point
        moved[chosen] = True
    if twisted(points[oriented(raw.points, raw.elements)]).any():
        held = np.concatenate([raw.surface.ravel(), middles[_on(ends, raw.surface)]])
        points, moved = _carried(raw, points, held), np.ones(len(points), dtype=bool)
    return replace(raw, points=_unspoiled(raw, points, moved, ends, middles))


def _carried(raw: RawMesh, points: Array, held: Ints) -> Array:
    """Return ``points`` with all but those ``held`` moved as the mean of their neighbours, nearer ones the more."""
    pairs = np.unique(np.sort(raw.elements[:, list(combinations(range(10), 2))].reshape(-1, 2), axis=1), axis=0)
    # The mean over a six-node facet is that of its edge nodes: corners of the surface carry nothing.
    pairs = pairs[~np.isin(pairs, np.intersect1d(held, raw.elements[:, :4])).any(axis=1)]
    pull = 1.0 / np.sum((raw.points[pairs[:, 0]] - raw.points[pairs[:, 1]]) ** 2, axis=1)
    count = len(points)
    near = sparse.coo_matrix((pull, pairs.T), shape=(count, count)).tocsr()
    near = near + near.T
    free = np.setdiff1d(np.unique(raw.elements), held)
    total = np.asarray(near.sum(axis=1)).ravel()[free]
    inside = sparse.diags(total) - near[free][:, free]
    moves = points - raw.points
    moves[free] = 0.0
    for axis, load in enumerate((near[free] @ moves).T):
        moves[free, axis], left = cg(inside, load, rtol=FOLLOWS, M=sparse.diags(1.0 / total))
        if left:
            raise NotConverged("the nodes inside the mesh do not follow its surface", remedy="take another mesh_size")
    return np.asarray(raw.points + moves)


def standing_for(geometry: Geometry, coarser: Callable[[Stl], Stl]) -> Geometry:
    """Return the geometry with ``coarser`` put in for its STL surfaces."""

    def body(given: Body) -> Body:
        shapes = tuple(coarser(shape) if isinstance(shape, Stl) else shape for shape in given.shapes)
        return Body(given.name, shapes, given.mesh_size)

    return Geometry(tuple(map(body, geometry.parts)), tuple(map(body, geometry.cavities)), geometry.patches)


def _unspoiled(raw: RawMesh, points: Array, moved: Flags, ends: Ints, middles: Ints) -> Array:
    """Put vertices back where elements would be squashed; edge nodes between them then follow the chord."""
    before = np.abs(six_volumes(raw.points[raw.elements]))
    back = np.zeros(len(points), dtype=bool)
    for _ in range(10):
        bad = np.abs(six_volumes(points[raw.elements])) < LEAST_VOLUME * before
        if not bad.any():
            break
        nodes = np.unique(raw.elements[bad])
        nodes = nodes[moved[nodes]]
        points[nodes] = raw.points[nodes]
        back[nodes] = True
    # An edge node whose edge was moved but which itself stayed lies in the middle again.
    loose = ~moved[middles] | back[middles]
    dragged = loose & (moved[ends] & ~back[ends]).any(axis=1)
    points[middles[dragged]] += (points[ends[dragged]] - raw.points[ends[dragged]]).mean(axis=1)
    return points


def _edge_nodes(raw: RawMesh) -> tuple[Ints, Ints]:
    """Return the ends (e, 2), sorted, and the middle nodes (e,) of all edges."""
    ends = np.sort(raw.elements[:, EDGES].reshape(-1, 2), axis=1)
    middles, first = np.unique(raw.elements[:, 4:].ravel(), return_index=True)
    return ends[first], middles


def _on(ends: Ints, triangles: Ints) -> Flags:
    """Whether an edge is one of the triangles'."""
    size = int(ends.max()) + 1
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=1)
    found: Flags = np.isin(ends[:, 0] * size + ends[:, 1], sides[:, 0] * size + sides[:, 1])
    return found


def _curved(vertices: Array, triangles: Ints, onto: Surface) -> Surface:
    """Return the six-node facets with their edge nodes on a surface, each cut into PIECES squared flat ones."""
    count = len(triangles)
    edges, number = sides(triangles, len(vertices))
    nodes = np.concatenate([vertices, onto.nearest(vertices[edges].mean(axis=1)).point])
    six = np.concatenate([triangles, len(vertices) + number], axis=1)
    grid = [(i, j) for i in range(PIECES + 1) for j in range(PIECES + 1 - i)]
    place = {pair: number for number, pair in enumerate(grid)}
    b, c = np.array(grid).T / PIECES
    a = 1.0 - b - c
    values = np.stack([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a], axis=1)
    small = []
    for i, j in grid:
        if i + j < PIECES:
            small.append((place[i, j], place[i + 1, j], place[i, j + 1]))
        if i + j < PIECES - 1:
            small.append((place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]))
    points = np.einsum("gi,fik->fgk", values, nodes[six]).reshape(-1, 3)
    faces = (np.arange(count) * len(grid))[:, None, None] + np.array(small)
    return Surface(points, faces.reshape(-1, 3))
