"""Dirty triangle surfaces made into closed solids where that takes only a little, and refused with the place where not.

Corners that nearly coincide are welded, with the smallest tolerance that closes the surface; corners on the middle of
a neighbour's edge split it; facets without area and doubled ones go; the winding is made consistent and outward. How
far any corner moved is stated. Several closed pieces are told apart: their union is meant, and a piece turned inward
inside another is a void.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.surface import Soundness, Surface, consistently_wound, soundness
from hyperfab.surface.soundness import bodies
from hyperfab.surface.topology import compact, twin_edges
from hyperfab.surface.weld import WELDS, open_edges, rim, size_of, welded

#: Those tried on the rims of gaps alone; gaps beyond the last are holes.
GAPS = (1e-3, 2e-3)
#: An edge goes through a facet where both its ends lie further away from it than this share of the size.
THROUGH = 1e-6


@dataclass(frozen=True)
class Repaired:
    """A closed surface: ``vertices`` (n, 3) [mm], ``triangles`` (m, 3) outward, and what was done to get there."""

    vertices: Array
    triangles: Ints
    deviation_mm: float
    notes: tuple[str, ...]


def as_typed(vertices: Array) -> Array:
    """Return coordinates (n, 3) [mm] rounded to the decimal place that single precision still tells apart.

    An STL keeps some seven digits: 20 mm that are written in inch or metres come back a millionth of a millimetre off,
    and a face that was drawn on that of a box would not touch it.

    >>> as_typed(np.array([[np.float32(-20 / 25.4) * 25.4, 4.0, 100.0]]))
    array([[-20.,   4., 100.]])
    """
    largest = float(np.abs(vertices).max())
    digits = -int(np.ceil(np.log10(np.finfo(np.float32).eps * largest))) if largest > 0.0 else 0
    rounded: Array = np.round(vertices, digits)
    return rounded


def repaired(vertices: Array, triangles: Ints, name: str) -> Repaired:
    """Return a closed, outward surface; InputError naming facet and place where it has holes or crossings.

    >>> corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> inward = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]])
    >>> repaired(corner, inward, "tip.stl").notes
    ('the surface was inside out and was turned over',)
    """
    size = size_of(vertices)
    everywhere = np.ones(len(vertices), dtype=bool)
    for share in WELDS + GAPS:
        where = everywhere if share in WELDS else rim(vertices, triangles)
        one = welded(vertices, triangles, share * size, where)
        points, moved = one.vertices, one.moved
        # A facet between three corners in a line closes the surface, and no mesher takes it: its neighbour is split.
        tall = _heights(points, one.faces) > WELDS[1] * size
        for sought in [one.faces] if tall.all() else [one.faces[tall], one.faces]:
            faces, strayed, split = _stitched(points, sought, max(share * size, WELDS[1] * size))
            found = soundness(points, faces)
            if found.closed:
                notes = _said(share * size, moved, len(triangles) - len(sought), strayed, split)
                return _outward(points, faces, max(moved, strayed), notes, found)
    raise _refusal(vertices, triangles, soundness(vertices, triangles), name)


def pieces(vertices: Array, triangles: Ints) -> list[tuple[Array, Ints]]:
    """Return the closed pieces whose union a closed surface means, each with the voids inside it.

    A piece that faces inward is a void of the smallest piece around it; where there is none it is turned over.

    >>> corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    >>> outward = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> len(pieces(np.concatenate([corner, corner + 5]), np.concatenate([outward, outward + 4])))
    2
    """
    count, label = bodies(twin_edges(triangles)[0])
    if count == 1:
        return [(vertices, triangles)]
    parts = [triangles[label == number] for number in range(count)]
    volumes = [soundness(vertices, part).volume_mm3 for part in parts]
    solid: dict[int, list[Ints]] = {i: [parts[i]] for i in range(count) if volumes[i] > 0.0}
    outer = {i: Surface(*compact(vertices, parts[i])) for i in solid}
    for i in range(count):
        if i in solid:
            continue
        corner = vertices[parts[i][0, 0]]
        around = [j for j in outer if outer[j].nearest(corner[None]).distance[0] < 0.0]
        if around:
            solid[min(around, key=lambda j: volumes[j])].append(parts[i])
        else:
            solid[i] = [parts[i][:, ::-1].copy()]
    return [compact(vertices, np.concatenate(faces)) for faces in solid.values()]


def crossing(vertices: Array, triangles: Ints) -> tuple[int, Array] | None:
    """Return a facet that goes through another one and the place, or None: edges are followed as rays.

    >>> flat = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1], [9, 9, 0.0]])
    >>> crossing(flat, np.array([[0, 1, 2], [3, 4, 5]]))
    (0, array([1., 1., 0.]))
    """
    size = size_of(vertices)
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    owner = np.repeat(np.arange(len(triangles)), 3)
    start, way = vertices[tail], vertices[head] - vertices[tail]
    surface = Surface(vertices, triangles)
    t, hit = surface.ray(start + THROUGH * way, (1.0 - 2.0 * THROUGH) * way)
    near = np.flatnonzero((hit >= 0) & (t < 1.0))
    apart = ~(triangles[hit[near]][:, :, None] == np.stack([tail[near], head[near]], axis=1)[:, None]).any((1, 2))
    near = near[apart]
    first, normal = vertices[triangles[hit[near], 0]], surface.normals[hit[near]]
    deep = [np.abs(np.einsum("ij,ij->i", vertices[ends[near]] - first, normal)) for ends in (tail, head)]
    through = near[np.minimum(*deep) > THROUGH * size]
    if len(through) == 0:
        return None
    edge = int(through[0])
    return int(owner[edge]), start[edge] + t[edge] * way[edge]


def _heights(points: Array, faces: Ints) -> Array:
    """Return the height (m,) of each facet over its longest side."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    longest = np.linalg.norm(np.stack([b - a, c - b, a - c]), axis=2).max(axis=0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.where(longest > 0.0, longest, 1.0))


def _stitched(points: Array, faces: Ints, distance: float) -> tuple[Ints, float, int]:
    """Split facets at corners of others that lie on their open edges, within ``distance``.

    Returns the facets, how far such a corner lay from its edge at most, and how many edges were split.
    """
    strayed, split = 0.0, 0
    for _ in range(3):  # a facet may have three such edges; each round splits one of each facet
        face, ends = open_edges(faces)
        if len(face) == 0:
            break
        corners = np.unique(ends)
        tree = cKDTree(points[corners])
        added: list[list[int]] = []
        gone: set[int] = set()
        for f, (a, b) in zip(face.tolist(), ends.tolist(), strict=True):
            if f in gone:
                continue
            way = points[b] - points[a]
            length = float(np.linalg.norm(way))
            if length == 0.0:
                continue
            near = corners[tree.query_ball_point(0.5 * (points[a] + points[b]), 0.5 * length + distance)]
            along = (points[near] - points[a]) @ way / length**2
            off = np.linalg.norm(points[near] - points[a] - along[:, None] * way, axis=1)
            margin = distance / length
            on = (off <= distance) & (along > margin) & (along < 1.0 - margin) & (near != a) & (near != b)
            if not on.any():
                continue
            strayed = max(strayed, float(off[on].max()))
            chain = [a, *near[on][np.argsort(along[on], kind="stable")].tolist(), b]
            opposite = next(v for v in faces[f].tolist() if v not in (a, b))
            added += [[chain[i], chain[i + 1], opposite] for i in range(len(chain) - 1)]
            gone.add(f)
            split += 1
        if not gone:
            break
        kept = np.delete(faces, sorted(gone), axis=0)
        faces = np.concatenate([kept, np.array(added, dtype=np.int64)])
    return faces, strayed, split


def _said(distance: float, moved: float, dropped: int, strayed: float, split: int) -> list[str]:
    notes = []
    if moved > 0.0:
        notes.append(f"corners closer than {distance:.2g} mm were welded; none moved more than {moved:.2g} mm")
    if dropped:
        notes.append(f"{dropped} facets without area or doubled were left out")
    if split:
        notes.append(f"{split} edges were split at the corners that lie on them, {strayed:.2g} mm away at most")
    return notes


def _outward(points: Array, faces: Ints, moved: float, notes: list[str], found: Soundness) -> Repaired:
    if not found.consistent:
        faces, turned = consistently_wound(faces)
        notes.append(f"{len(turned)} facets wound the other way were turned")
    volume = soundness(points, faces).volume_mm3
    if volume < 0.0:
        faces = faces[:, ::-1].copy()
        notes.append("the surface was inside out and was turned over")
    return Repaired(*compact(points, faces), moved, tuple(notes))


def _refusal(vertices: Array, triangles: Ints, found: Soundness, name: str) -> InputError:
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
