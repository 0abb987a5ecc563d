"""The gap from each point of the male to the female: nearest, along the male's normal, along the closing axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.pressing.curved import one_sided
from hyperfab.pressing.mold import LOOKING, Mold, extent
from hyperfab.pressing.projection import smooth_gap
from hyperfab.surface import Surface
from hyperfab.surface.soundness import bodies

#: Beyond this angle between the male's normal and the direction to the nearest point the three gaps part company.
OBLIQUE_DEG = 30.0
#: So far [mm] before a facet a ray begins that is not to meet it.
_OFF = 1e-6
#: A front stands up where it rises by this share of its extent.
_RISES = 0.05
#: Of that extent, heights that are apart by no more are one level.
_LEVEL = 1e-5


@dataclass(frozen=True)
class Front:
    """The molding part of the male: its own vertex numbering, along creases a vertex for each side.

    ``vertices`` (n, 3), ``faces`` (m, 3), unit vertex ``normals`` (n, 3) of the smooth surface on the faces' side, face
    ``areas`` (m,), ``of_mold`` (n,) the vertices' numbers in the whole mold, ``flange`` (m,) the faces of the flat rim
    around the molding surface and of bodies that lie ``aside``, no higher than its lowest level: the area of these
    [mm^2].
    """

    vertices: Array
    faces: Ints
    normals: Array
    areas: Array
    of_mold: Ints
    flange: Flags
    aside: float = 0.0

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
    """Return the part of the male that molds: the faces that look at the female past all of the male, and upright walls
    opposite to it."""
    surface = male.surface
    chosen = male.looking.copy()
    looking, upright = np.flatnonzero(chosen), np.flatnonzero(np.abs(surface.normals[:, 2]) <= LOOKING)
    above = np.array([0.0, 0.0, 1.0])
    _, over = surface.ray(male.vertices[male.faces[looking]].mean(axis=1) + _OFF * above, above)
    chosen[looking[over >= 0]] = False
    rim, aside = _rim(male, chosen)
    if len(upright):
        centres = male.vertices[male.faces[upright]].mean(axis=1)
        normals = surface.normals[upright]
        t, face = female.surface.ray(centres + _OFF * normals, normals)
        opposed = (face >= 0) & ((female.surface.normals[face] * normals).sum(axis=1) < 0.0)
        own, _ = surface.ray(centres + _OFF * normals, normals)
        chosen[upright[opposed & (t < own)]] = True
    used, faces, normals = one_sided(male.faces[chosen], male.corner_normals[chosen])
    part = Surface(male.vertices[used], faces)
    return Front(
        part.vertices, faces, normals, part.areas, used, (rim | aside)[chosen], float(part.areas[aside[chosen]].sum())
    )


def touch_gap(nearest: Array, along_normal: Array) -> Array:
    """Return the gap (n,) [mm] that decides whether the sandwich is touched: the one its column meets.

    The sandwich stands on the male along its normal. Where that misses the female the nearest gap takes its place.
    """
    return np.where(np.isnan(along_normal), nearest, along_normal)


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


def _rim(male: Mold, looking: Flags) -> tuple[Flags, Flags]:
    """Faces (m,) of the flat rim and of bodies that lie aside, of those that are ``looking`` (m,): as they were drawn,
    as of facets that were cut some bulge a little below the rim."""
    whole = male.surface
    if male.drawn is not None:
        whole, cut = male.drawn.whole(male.vertices), looking
        looking = np.zeros(len(whole.faces), dtype=bool)
        looking[male.drawn.of[cut]] = True
    found = np.zeros((2, len(whole.faces)), dtype=bool)
    if looking.any():
        found[:, looking] = _flange(Surface(whole.vertices, whole.faces[looking]), bodies(whole.twins)[1][looking])
    rim, aside = found if male.drawn is None else found[:, male.drawn.of]
    return rim, aside


def _flange(front: Surface, body: Ints) -> tuple[Flags, Flags]:
    """Faces of the flat rim: at the front's lowest level, flat across the axis, while the rest rises clearly above.

    Its share must be worth mentioning (3 %); a front that is flat throughout has no flange. A mesh need not follow
    the line where the rim begins to rise. Of the faces across it those count as rim whose slope is less than an
    eighth of that of the next faces inward: where a blend of constant curvature begins in the middle of a face of
    width h, its slope is kappa h / 8, and that of the next ones kappa h on average.

    The mold is that ``body`` (m,) of its STL that stands up the most: under one that rises, others that lie no higher
    than its lowest level, as a bolster or a clamp, mold nothing and tell no level of its rim: the second flags told.
    """
    heights = front.vertices[front.faces][..., 2]
    low = float(heights.min())
    stands = np.bincount(body, weights=front.areas * front.normals[:, 2] * (heights.mean(axis=1) - low))
    own = body == body[np.argmax(stands[body])]
    span = extent(front.vertices, front.faces[own])
    if np.ptp(heights[own]) < _RISES * span:
        own[:] = True
        span = extent(front.vertices, front.faces)
    low, rise = float(heights[own].min()), float(np.ptp(heights[own]))
    # Within, facets that begin to rise from it dip below it by next to nothing, and are not level there.
    level = own & (np.ptp(heights, axis=1) <= _LEVEL * span) & (heights.max(axis=1) <= low + 5.0 * _LEVEL * span)
    ground = front.vertices[:, 2] <= (float(heights[level].min()) if level.any() else low) + _LEVEL * span
    on_ground = ground[front.faces].sum(axis=1)
    flat = on_ground == 3
    aside = ~own & (np.bincount(body, weights=~flat) == 0.0)[body]
    if rise < _RISES * span or front.areas[flat & own].sum() < 0.03 * front.areas[own].sum():
        return aside & False, aside
    slope = np.arccos(np.clip(front.normals[:, 2], -1.0, 1.0))
    across = (on_ground > 0) & ~flat
    rising = np.zeros(len(front.vertices), dtype=bool)
    rising[front.faces[across]] = True
    next_inward = (on_ground == 0) & (rising[front.faces].any(axis=1))
    if next_inward.any():
        flat |= across & (slope < np.median(slope[next_inward]) / 8.0)
    return flat, aside
