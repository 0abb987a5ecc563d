"""A mold as the kernels take it: triangles in a search tree, their neighbours, and its sharp edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hyperfab.arrays import Array, Ints
from hyperfab.surface import Surface, bvh

States = npt.NDArray[np.int8]

# State of a node: free, or 1 + the feature it lies on (0 face, 1-3 edges, 4-6 vertices).
FREE, ON_FACE = 0, 1

#: An edge that turns by more than this (radians) is sharp: springs are laid over it.
SHARP = 0.45


class Creases(NamedTuple):
    """Sharp convex edges of a mold in the order of their search tree."""

    corners: Array  # (c, 3, 3): the two ends, the second twice
    bounds: Array
    right: Ints
    start: Ints
    number: Ints
    normals: Array  # (c, 2, 3) of the two facets
    beyond: Ints  # (c, 2) the crease that goes on at each end, or -1
    meeting: Ints  # (c, 2, 4) creases that meet it at a corner of several, or -1
    facet: Ints  # (c, 2) slot of a facet of the mold, and which of its edges the crease is


class Mold(NamedTuple):
    """A surface as the kernels take it, facets in the order of the search tree."""

    corners: Array
    bounds: Array
    right: Ints
    start: Ints
    number: Ints
    normals: Array  # (k, 7, 3) of face, edges and vertices
    twins: Ints
    turn: Array
    vertex: Ints
    incident_first: Ints
    incident: Ints
    creases: Creases


def mold_of(surface: Surface, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mold:
    """Arrays of ``surface`` moved by ``shift`` mm."""
    order, back = surface.order, surface.slot_of_face
    twins = surface.twins[order]
    first, incident = surface.incident
    move = np.asarray(shift)
    return Mold(
        surface.corners + move,
        surface.bounds + np.concatenate([move, move]),
        surface.right,
        surface.start,
        surface.count,
        np.ascontiguousarray(surface.feature_normals[order]),
        np.where(twins >= 0, back[twins], -1),
        np.ascontiguousarray(surface.edge_turn[order]),
        np.ascontiguousarray(surface.faces[order]),
        first,
        back[incident],
        creases_of(surface, shift),
    )


def raised(mold: Mold, height: float) -> Mold:
    """The mold moved up by ``height`` mm."""
    if height == 0.0:
        return mold
    up, creases = np.array([0.0, 0.0, height]), mold.creases
    return mold._replace(
        corners=mold.corners + up,
        bounds=mold.bounds + np.concatenate([up, up]),
        creases=creases._replace(corners=creases.corners + up, bounds=creases.bounds + np.concatenate([up, up])),
    )


def creases_of(surface: Surface, shift: tuple[float, float, float]) -> Creases:
    """Sharp convex edges of ``surface`` moved by ``shift`` mm."""
    face, edge = np.nonzero(surface.edge_turn > SHARP)
    other = surface.twins[face, edge]
    once = face < other
    face, edge, other = face[once], edge[once], other[once]
    ends = np.stack([surface.faces[face, edge], surface.faces[face, (edge + 1) % 3]], 1)
    points = surface.vertices[ends] + np.asarray(shift)
    corners = np.ascontiguousarray(np.stack([points[:, 0], points[:, 1], points[:, 1]], 1))
    order, bounds, right, start, number = bvh.build(corners)
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    # A crease goes on at a vertex where exactly one other crease begins.
    count = np.bincount(ends.ravel(), minlength=len(surface.vertices))
    total = np.bincount(ends.ravel(), np.repeat(np.arange(len(ends)), 2), minlength=len(surface.vertices))
    beyond = np.where(count[ends] == 2, total[ends] - np.arange(len(ends))[:, None], -1).astype(np.int64)
    beyond = np.where(beyond >= 0, place[np.maximum(beyond, 0)] if len(place) else beyond, -1)
    normals = np.stack([surface.normals[face], surface.normals[other]], 1)
    return Creases(
        np.ascontiguousarray(corners[order]),
        bounds,
        right,
        start,
        number,
        np.ascontiguousarray(normals[order]),
        np.ascontiguousarray(beyond[order]),
        np.ascontiguousarray(_corners_of(ends, count, place)[order]),
        np.ascontiguousarray(np.stack([surface.slot_of_face[face], edge], 1)[order]),
    )


def _corners_of(ends: Ints, count: Ints, place: Ints) -> Ints:
    """(c, 2, 4) other creases, by their place in the tree, at each end where more than two meet."""
    out = np.full((len(ends), 2, 4), -1)
    at: dict[int, list[int]] = {}
    for crease, end in zip(*np.nonzero(count[ends] > 2), strict=True):
        at.setdefault(int(ends[crease, end]), []).append(int(crease))
    for crease, end in zip(*np.nonzero(count[ends] > 2), strict=True):
        others = [int(place[c]) for c in at[int(ends[crease, end])] if c != crease][:4]
        out[crease, end, : len(others)] = others
    return out
