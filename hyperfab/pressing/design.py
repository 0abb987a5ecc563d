"""The male surface that leaves the same gap everywhere: the female, offset inward."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import InputError
from hyperfab.pressing.curved import Curving, one_sided
from hyperfab.pressing.dense import bent, dense
from hyperfab.pressing.gap import molding_front, nearest_gap
from hyperfab.pressing.mold import Mold, mold
from hyperfab.surface import Surface
from hyperfab.surface.topology import compact

#: The male must look up by at least this much, or it cannot be drawn out of the part.
_DRAFT = 0.0
#: An offset that comes nearer to the female than asked for, by this share, has folded over itself.
_FOLDED = 0.01
#: Facets of the male turn by no more [deg] from corner to corner, and their edges are chords within so much [mm]: a
#: blend that the female has in few facets is written in as many as it takes to say how it is curved.
_TURN_DEG, _CHORD = 12.0, 0.03
#: A vertex stands off the female by what is asked to so much [mm], in so many steps, no further than so many times it.
_MET, _STEPS, _FURTHEST = 1e-7, 20, 2.0


@dataclass(frozen=True)
class Design:
    """``vertices`` (n, 3) [mm] and ``faces`` (m, 3) of the male, in the hot press frame; the ``spread`` [mm] of the
    gap it leaves at its vertices, greatest less least."""

    vertices: Array
    faces: Ints
    spread: float


@dataclass(frozen=True)
class Offset:
    """What a male is offset from: the ``front`` of the smooth ``female`` in facets that turn by little, and the unit
    ``ways`` (n, 3) of its vertices, along the smooth normal; half way between the sides of a crease."""

    female: Mold
    front: Surface
    ways: Array


def offset(female: Mold) -> Offset:
    """Return what a male is offset from."""
    front = Surface(*compact(female.vertices, female.front.faces))
    curve = female.front_curving
    fine, normals = bent(Curving(front, curve.normals, curve.bulge, curve.skew), np.radians(_TURN_DEG), _CHORD)
    of, _, sides = one_sided(fine.faces, normals)
    ways = np.stack([np.bincount(of, weights=sides[:, k], minlength=len(fine.vertices)) for k in range(3)], axis=1)
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    return Offset(female, fine, np.where(length > 0.0, ways / np.where(length > 0.0, length, 1.0), 0.0))


def constant_gap(base: Offset, gap: float | Array) -> Design:
    """Return the male that leaves ``gap`` [mm] to the (hot) female everywhere, or (n,) at each vertex of its front.

    Every vertex of the female's front is moved along the smooth surface's normal until the nearest gap is that. Raises
    InputError with the place where the offset folds over itself (the female is hollowed more sharply than the gap
    allows) or would be undercut.
    """
    front, female = base.front, base.female
    each = np.broadcast_to(np.asarray(gap, dtype=float), len(front.vertices))
    far = each
    for step in range(_STEPS + 1):
        vertices = front.vertices + far[:, None] * base.ways
        found = nearest_gap(vertices, female)
        off = each - found.nearest
        if np.abs(off).max() <= _MET or step == _STEPS:
            break
        rate = (found.direction * base.ways).sum(axis=1)
        far = np.clip(far + off / np.maximum(rate, 1.0 / _FURTHEST), 0.0, _FURTHEST * each)
    male = Surface(vertices, front.faces[:, ::-1])
    turned = (male.normals * front.normals).sum(axis=1) >= 0.0
    # Beyond a middle of curvature edges are turned round, though where both ways are facets are not turned over.
    edges = (np.roll(one[front.faces], -1, axis=1) - one[front.faces] for one in (vertices, front.vertices))
    turned |= (np.multiply(*edges).sum(axis=2) <= 0.0).any(axis=1)
    _refuse(turned, front, "folds over itself")
    _refuse(male.normals[:, 2] <= _DRAFT, front, "is undercut")
    near = (found.nearest < (1.0 - _FOLDED) * each)[front.faces].any(axis=1)
    least = float(each.min())
    _refuse(np.asarray(near), front, f"comes nearer to the female than {least:g} mm and would cut into itself")
    return Design(vertices, male.faces, float(np.ptp(found.nearest)))


def gaps(male: Mold, female: Mold) -> tuple[Array, Array]:
    """Return the nearest gaps (n,) [mm] that a male leaves to the female, both hot, where a press with it would look,
    and the places (n, 3); where the female ends none is told."""
    up = np.array([0.0, 0.0, 1.0])
    surface, drawn = dense(male.surface, up, female.surface, male.smooth, edges=True)
    front = molding_front(mold(surface.vertices, surface.faces, 1, male.mount, male.smooth, drawn), female)
    there = front.molding_areas > 0.0
    found = nearest_gap(front.vertices[there], female)
    return found.nearest[~found.at_border], front.vertices[there][~found.at_border]


def _refuse(faces: Flags, front: Surface, what: str) -> None:
    bad = np.flatnonzero(faces)
    if len(bad):
        worst = bad[np.argmax(front.areas[bad])]
        x, y, z = front.vertices[front.faces[worst]].mean(axis=0)
        raise DesignRefused(what, (float(x), float(y), float(z)), len(bad))


class DesignRefused(InputError):
    """There is no such male: ``what`` is wrong at the place ``at`` (3,) [mm], in the press frame."""

    def __init__(self, what: str, at: tuple[float, float, float], faces: int) -> None:
        super().__init__(f"the surface of constant gap {what}")
        self.what, self.at, self.faces = what, at, faces


def with_back(vertices: Array, faces: Ints, height: float) -> tuple[Array, Ints]:
    """Close an open front with side walls and a flat back at ``height`` [mm], its mounting face.

    A front with several borders, or one that reaches below the back, is returned as it is.

    >>> import numpy as np
    >>> points, faces = with_back(np.eye(3), np.array([[0, 1, 2]]), -5.0)
    >>> len(points), len(faces)
    (7, 10)
    """
    surface = Surface(vertices, faces)
    open_edge = surface.twins < 0
    tail = np.concatenate([faces[open_edge[:, k], k] for k in range(3)])
    head = np.concatenate([faces[open_edge[:, k], (k + 1) % 3] for k in range(3)])
    after = dict(zip(tail.tolist(), head.tolist(), strict=True))
    if not after or len(after) != len(tail) or vertices[:, 2].min() <= height:
        return vertices, faces
    ring = [int(tail[0])]
    while after[ring[-1]] != ring[0] and len(ring) <= len(after):
        ring.append(after[ring[-1]])
    if len(ring) != len(after):
        return vertices, faces
    rim = np.array(ring)
    foot = vertices[rim].copy()
    foot[:, 2] = height
    below = np.arange(len(rim)) + len(vertices)
    rim_on, below_on = np.roll(rim, -1), np.roll(below, -1)
    middle = np.full(len(rim), len(vertices) + len(rim))
    walls = [
        np.stack([rim_on, rim, below], axis=-1),
        np.stack([rim_on, below, below_on], axis=-1),
        np.stack([below_on, below, middle], axis=-1),
    ]
    points = np.concatenate([vertices, foot, foot.mean(axis=0, keepdims=True)])
    return points, np.concatenate([faces, *walls])
