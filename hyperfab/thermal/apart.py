"""Bodies of a mold that touch no other: no heat passes to them, though the drawing may look as if it did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from hyperfab.surface import Surface
from hyperfab.surface.topology import compact
from hyperfab.thermal.mesh import FACETS, HeatMesh


@dataclass(frozen=True)
class Apart:
    """Bodies of the part numbers ``parts`` that touch nothing but each other, ``whole`` parts or some of their bodies;
    the nearest is of part ``nearest``, ``gap`` [m] away."""

    parts: tuple[int, ...]
    whole: bool
    nearest: int
    gap: float


def apart(mesh: HeatMesh) -> list[Apart]:
    """Return the bodies that hang together with the largest, by volume, neither directly nor through others.

    ``mesh`` is that of the mesher, before contacts double nodes: faces with a contact between them touch.
    """
    elements, vertices = mesh.elements, mesh.vertices
    links = np.stack([np.repeat(elements[:, 0], 3), elements[:, 1:4].ravel()])
    graph = sparse.coo_matrix((np.ones(links.shape[1], dtype=np.int8), links), shape=(vertices, vertices))
    count, label = connected_components(graph, directed=False)
    if count == 1:
        return []
    body = label[elements[:, 0]]
    outer = mesh.facets.outer
    element = mesh.facets.element[outer]
    faces = elements[element[:, None], FACETS[mesh.facets.local[outer], :3]]
    corners = mesh.points[elements[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    largest = int(np.bincount(body, volume).argmax())
    found = []
    for number in (number for number in range(count) if number != largest):
        own = body[element] == number
        here, there = (Surface(*compact(mesh.points, faces[which])) for which in (own, ~own))
        out, back = there.nearest(here.vertices), here.nearest(there.vertices)
        first, last = np.abs(out.distance).argmin(), np.abs(back.distance).argmin()
        gaps = abs(float(out.distance[first])), abs(float(back.distance[last]))
        facet = int(out.face[first])
        if gaps[1] < gaps[0]:
            facet = int(np.flatnonzero((there.faces == last).any(axis=1))[0])
        parts = np.unique(mesh.parts[body == number])
        whole = not np.isin(parts, mesh.parts[body != number]).any()
        nearest = int(mesh.parts[element[~own][facet]])
        found.append(Apart(tuple(parts.tolist()), whole, nearest, min(gaps)))
    return found


def barely(mesh: HeatMesh) -> list[tuple[int, int]]:
    """Return pairs of part numbers that meet in an edge or a point alone, and by no faces through other parts.

    ``mesh`` is that of the mesher: nodes that the two share carry heat, as much as the elements there are large.
    """
    count = int(mesh.parts.max()) + 1
    facets = mesh.facets
    joined = mesh.parts[np.stack([facets.element, facets.other])[:, ~facets.outer]]
    links = sparse.coo_matrix((np.ones(joined.shape[1]), joined), shape=(count, count))
    label = connected_components(links, directed=False)[1]
    if (label == label[0]).all():
        return []
    corners = np.stack([np.repeat(mesh.parts, 4), mesh.elements[:, :4].ravel()])
    has = sparse.coo_matrix((np.ones(corners.shape[1]), corners), shape=(count, mesh.vertices)).tocsr()
    shared = (has @ has.T).tocoo()
    return [(int(i), int(j)) for i, j in zip(shared.row, shared.col, strict=True) if i < j and label[i] != label[j]]
