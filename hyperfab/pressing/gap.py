"""The gap from each point of the male to the female: nearest, along the male's normal, along the closing axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.pressing.curved import CREASE_DEG, smooth_normals
from hyperfab.pressing.mold import LOOKING, Mold
from hyperfab.pressing.projection import smooth_gap
from hyperfab.surface import Surface

#: Beyond this angle between the male's normal and the direction to the nearest point the three gaps part company.
OBLIQUE_DEG = 30.0


@dataclass(frozen=True)
class Front:
    """The molding part of the male: its own vertex numbering.

    ``vertices`` (n, 3), ``faces`` (m, 3), unit vertex ``normals`` (n, 3), face ``areas`` (m,), ``of_mold`` (n,) the
    vertices' numbers in the whole mold, ``flange`` (m,) the faces of the flat rim around the molding surface.
    """

    vertices: Array
    faces: Ints
    normals: Array
    areas: Array
    of_mold: Ints
    flange: Flags

    @cached_property
    def molding_areas(self) -> Array:
        """Area (n,) [mm^2] of the molding surface, which the flange is no part of, that belongs to each vertex."""
        return vertex_areas(self, ~self.flange)


@dataclass(frozen=True)
class Gap:
    """The gap at n points: ``nearest`` [mm], negative inside the female; ``direction`` (n, 3), from the female's
    nearest point to the point: the gradient of ``nearest``; the ``face`` of the female that is nearest; ``at_border``
    where that is an open edge of the female.
    """

    nearest: Array
    direction: Array
    face: Ints
    at_border: Flags


def nearest_gap(points: Array, female: Mold, order: Ints | None = None) -> Gap:
    """Return the nearest signed gap at ``points`` (n, 3), a little faster with an ``order`` in which neighbours follow
    each other."""
    surface = female.surface
    near = surface.nearest(points, order=order)
    border = _at_border(female, near.face, near.feature)
    if not female.smooth:
        return Gap(near.distance, near.normal, near.face, border)
    curving = female.curving
    distance, gradient, face = smooth_gap(
        np.ascontiguousarray(points),
        near.distance,
        near.face,
        near.normal,
        surface.vertices,
        surface.faces,
        curving.bulge,
        curving.skew,
        curving.room,
        *surface.incident,
    )
    return Gap(distance, gradient, face, border)


def normal_gap(points: Array, normals: Array, female: Mold) -> Array:
    """Return the gap (n,) [mm] along the male's ``normals``; NaN where the normal misses the female.

    Points inside the female (overlap) find it backwards, with a negative gap.
    """
    gap, face = female.surface.along(points, normals)
    hit = np.flatnonzero(face >= 0)
    ends = points[hit] + gap[hit, None] * normals[hit]
    gap[hit] += female.curving.reach(face[hit], ends, normals[hit])
    return gap


def axial_gap(points: Array, female: Mold) -> Array:
    """Return the gap (n,) [mm] along the closing axis; NaN where no female lies above."""
    far = 1.0 + max(0.0, float(points[:, 2].max() - female.front.vertices[:, 2].min()))
    return gap_towards(points, female, np.array([0.0, 0.0, 1.0]), far)


def gap_towards(points: Array, mold: Mold, way: Array, far: float) -> Array:
    """Return the gap (n,) [mm] along a unit ``way`` (3,) to the front of a mold; NaN where it does not lie there.

    It is looked for from ``far`` [mm] behind the points, outside of all: molds that overlap have a negative gap.
    """
    along = np.broadcast_to(way, points.shape)
    t, face = mold.front.ray(points - far * way, along)
    hit = np.flatnonzero(face >= 0)
    gap = np.full(len(points), np.nan)
    ends = points[hit] + (t[hit] - far)[:, None] * way
    gap[hit] = t[hit] - far + mold.front_curving.reach(face[hit], ends, along[hit])
    return gap


def molding_front(male: Mold, female: Mold) -> Front:
    """Return the part of the male that molds: the faces that look at the female, and upright walls opposite to it."""
    surface = male.surface
    upright = np.flatnonzero(np.abs(surface.normals[:, 2]) <= 0.02)
    chosen = male.looking.copy()
    if len(upright):
        centres = male.vertices[male.faces[upright]].mean(axis=1)
        normals = surface.normals[upright]
        t, face = female.surface.ray(centres + 1e-6 * normals, normals)
        opposed = (face >= 0) & ((female.surface.normals[face] * normals).sum(axis=1) < 0.0)
        own, _ = surface.ray(centres + 1e-6 * normals, normals)
        chosen[upright[opposed & (t < own)]] = True
    used, faces = np.unique(male.faces[chosen], return_inverse=True)
    part = Surface(male.vertices[used], faces)
    if male.drawn is None:
        return Front(part.vertices, faces, smooth_normals(part), part.areas, used, _flange(part))
    # Facets that were cut are unlike around a corner: the normals are those of the facets as drawn, and so is the rim.
    normals = np.zeros_like(part.vertices)
    np.add.at(normals, faces, male.drawn.corner_normals(male.vertices)[chosen])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    whole = male.drawn.whole(male.vertices)
    looking = whole.normals[:, 2] > LOOKING
    flange = np.zeros(len(whole.faces), dtype=bool)
    flange[looking] = _flange(Surface(whole.vertices, whole.faces[looking]))
    return Front(part.vertices, faces, normals, part.areas, used, flange[male.drawn.of[chosen]])


def touch_gap(front: Front, nearest: Array, along_normal: Array) -> Array:
    """Return the gap (n,) [mm] that decides whether the sandwich is touched: the one its column meets.

    The sandwich stands on the male along its normal. Where the normal misses the female, or is no single direction
    because the vertex lies on a crease, the nearest gap takes its place.
    """
    corner = front.normals[front.faces]
    a, b, c = (front.vertices[front.faces[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    length = np.linalg.norm(flat, axis=1)
    cosine = (corner * flat[:, None]).sum(axis=2) / np.where(length > 0.0, length, 1.0)[:, None]
    creased = np.zeros(len(front.vertices), dtype=bool)
    creased[front.faces[cosine < np.cos(np.radians(CREASE_DEG))]] = True
    return np.where(np.isnan(along_normal) | creased, nearest, along_normal)


def oblique(front: Front, gap: Gap) -> Flags:
    """Points whose nearest direction leaves the male's normal by more than OBLIQUE_DEG."""
    cosine = -(front.normals * gap.direction).sum(axis=1)
    return np.asarray(cosine < np.cos(np.radians(OBLIQUE_DEG)))


def vertex_areas(front: Front, faces: Flags) -> Array:
    """Return the area (n,) [mm^2] that belongs to each vertex: a third of its faces, of those chosen."""
    share = np.where(faces, front.areas, 0.0) / 3.0
    areas = np.bincount(front.faces.ravel(), weights=np.repeat(share, 3), minlength=len(front.vertices))
    return np.asarray(areas, dtype=float)


def _at_border(female: Mold, face: Ints, feature: Ints) -> Flags:
    """Whether the nearest feature is an open edge, or a vertex of one."""
    open_edge, border_vertex = female.border
    on_edge = np.flatnonzero((feature >= 1) & (feature <= 3))
    at_vertex = np.flatnonzero(feature >= 4)
    found = np.zeros(len(face), dtype=bool)
    found[on_edge] = open_edge[face[on_edge], feature[on_edge] - 1]
    found[at_vertex] = border_vertex[female.faces[face[at_vertex], feature[at_vertex] - 4]]
    return found


def _flange(front: Surface) -> Flags:
    """Faces of the flat rim: at the front's lowest level, flat across the axis, while the rest rises clearly above.

    Its share must be worth mentioning (3 %); a front that is flat throughout has no flange. A mesh need not follow
    the line where the rim begins to rise. Of the faces across it those count as rim whose slope is less than an
    eighth of that of the next faces inward: where a blend of constant curvature begins in the middle of a face of
    width h, its slope is kappa h / 8, and that of the next ones kappa h on average.
    """
    heights = front.vertices[front.faces][..., 2]
    low, rise = float(heights.min()), float(np.ptp(heights))
    span = float(np.ptp(front.vertices[:, :2], axis=0).max())
    ground = front.vertices[:, 2] <= low + 1e-5 * span
    on_ground = ground[front.faces].sum(axis=1)
    flat = on_ground == 3
    if rise < 0.05 * span or front.areas[flat].sum() < 0.03 * front.areas.sum():
        return np.zeros(len(front.faces), dtype=bool)
    slope = np.arccos(np.clip(front.normals[:, 2], -1.0, 1.0))
    across = (on_ground > 0) & ~flat
    rising = np.zeros(len(front.vertices), dtype=bool)
    rising[front.faces[across]] = True
    next_inward = (on_ground == 0) & (rising[front.faces].any(axis=1))
    if next_inward.any():
        flat |= across & (slope < np.median(slope[next_inward]) / 8.0)
    return np.asarray(flat)
