"""Dirty triangle surfaces made into closed solids where that takes only a little, and refused with the place where not.

Corners that nearly coincide are welded, with the smallest tolerance that closes the surface; facets without area and
doubled ones go; the winding is made consistent and outward. How far any corner moved is stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from hyperfab.errors import InputError
from hyperfab.surface import Soundness, consistently_wound, soundness

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Welding distances tried, as shares of the surface's size; gaps beyond the last are holes.
WELDS = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 5e-4)


@dataclass(frozen=True)
class Repaired:
    """A closed surface: ``vertices`` (n, 3) [mm], ``triangles`` (m, 3) outward, and what was done to get there."""

    vertices: Array
    triangles: Index
    deviation_mm: float
    notes: tuple[str, ...]


def repaired(vertices: Array, triangles: Index, name: str) -> Repaired:
    """Return a closed, outward surface; InputError naming facet and place where it has holes or crossings.

    >>> corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> inward = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]])
    >>> repaired(corner, inward, "tip.stl").notes
    ('the surface was inside out and was turned over',)
    """
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    found = soundness(vertices, triangles)
    for share in WELDS:
        points, faces, moved = _welded(vertices, triangles, share * size)
        found = soundness(points, faces)
        if found.closed:
            return _outward(points, faces, moved, share * size, len(triangles) - len(faces), found)
    raise _refusal(vertices, triangles, soundness(vertices, triangles), name)


def _welded(vertices: Array, triangles: Index, distance: float) -> tuple[Array, Index, float]:
    if distance > 0.0:
        pairs = cKDTree(vertices).query_pairs(distance, output_type="ndarray")
        graph = sparse.coo_matrix(
            (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(vertices),) * 2
        )
        count, label = connected_components(graph, directed=False)
        weight = np.bincount(label, minlength=count)
        points = np.stack([np.bincount(label, vertices[:, i], count) / weight for i in range(3)], axis=1)
        moved = float(np.linalg.norm(points[label] - vertices, axis=1).max())
        faces = label[triangles].astype(np.int64)
    else:
        points, faces, moved = vertices, triangles, 0.0
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces = faces[distinct]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return points, faces[np.sort(first)], moved


def _outward(
    points: Array, faces: Index, moved: float, distance: float, dropped: int, found: Soundness
) -> Repaired:
    notes = []
    if moved > 0.0:
        notes.append(
            f"corners closer than {distance:.2g} mm were welded; none moved more than {moved:.2g} mm"
        )
    if dropped:
        notes.append(f"{dropped} facets without area or doubled were left out")
    if not found.consistent:
        faces, turned = consistently_wound(points, faces)
        notes.append(f"{len(turned)} facets wound the other way were turned")
    volume = soundness(points, faces).volume_mm3
    if volume < 0.0:
        faces = faces[:, ::-1].copy()
        notes.append("the surface was inside out and was turned over")
    used, small = np.unique(faces, return_inverse=True)
    return Repaired(points[used], small.reshape(-1, 3).astype(np.int64), moved, tuple(notes))


def _refusal(vertices: Array, triangles: Index, found: Soundness, name: str) -> InputError:
    crowded = len(found.crowded_facets) > 0 and found.open_edges == 0
    facet = int((found.crowded_facets if crowded else found.open_facets)[0])
    x, y, z = vertices[triangles[facet]].mean(axis=0)
    what = (
        f"{found.crowded_edges} edges have more than two facets"
        if crowded
        else f"the surface is not closed: {found.open_edges} open edges"
    )
    return InputError(
        f"{what}, one at ({x:.4g}, {y:.4g}, {z:.4g}) mm",
        file=name,
        facet=facet + 1,
        remedy="close the surface in the program that made it",
    )
