"""The male surface that leaves the same gap everywhere: the female, offset inward."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import InputError
from hyperfab.pressing.curved import smooth_normals
from hyperfab.pressing.gap import nearest_gap
from hyperfab.pressing.mold import Mold
from hyperfab.surface import Surface
from hyperfab.surface.topology import compact

#: The male must look up by at least this much, or it cannot be drawn out of the part.
_DRAFT = 0.0
#: An offset that comes nearer to the female than asked for, by this share, has folded over itself; of a gap that
#: changes from place to place, more: it is less than what is asked for along the normal, by its slope.
_FOLDED, _FOLDED_UNEVEN = 0.01, 0.1


@dataclass(frozen=True)
class Design:
    """``vertices`` (n, 3) [mm] and ``faces`` (m, 3) of the male, in the hot press frame; the ``spread`` [mm] of the
    gap it leaves: greatest less least."""

    vertices: Array
    faces: Ints
    spread: float


def constant_gap(female: Mold, gap: float | Array) -> Design:
    """Return the male that leaves ``gap`` [mm] to the (hot) female everywhere, or (n,) at each vertex of its front.

    Every vertex of the female's front is moved by the gap along the smooth surface's normal. Raises InputError with
    the place where the offset folds over itself (the female is hollowed more sharply than the gap allows) or would
    be undercut.
    """
    front = Surface(*compact(female.vertices, female.front.faces))
    each = np.broadcast_to(np.asarray(gap, dtype=float), len(front.vertices))
    vertices = front.vertices + each[:, None] * smooth_normals(front)
    male = Surface(vertices, front.faces[:, ::-1])
    turned = (male.normals * front.normals).sum(axis=1) >= 0.0
    _refuse(turned, front, "folds over itself")
    _refuse(male.normals[:, 2] <= _DRAFT, front, "is undercut")
    found = nearest_gap(vertices, female).nearest
    folded = _FOLDED if np.ndim(gap) == 0 else _FOLDED_UNEVEN
    near = (found < (1.0 - folded) * each)[front.faces].any(axis=1)
    least = float(each.min())
    _refuse(np.asarray(near), front, f"comes nearer to the female than {least:g} mm and would cut into itself")
    return Design(vertices, male.faces, float(np.ptp(found)))


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
