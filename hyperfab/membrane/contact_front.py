"""Where the sheet leaves a punch of any shape: the edge of contact as points on the element edges that cross it.

Contact may be anywhere, in several patches. An element corner counts as touching where most middles of the edges
around it do (on P2 elements corners carry almost no load). On an edge that leaves the punch the place is found as on
the sphere, by extrapolating the root of the gap to zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.mesh import SheetMesh

#: Where the gaps do not say where an edge is crossed: half-way between the last touching node and the next.
_MIDDLE, _LATE = 0.5, 0.75
_SIDES = np.array([[0, 1], [1, 2], [2, 0]])


@dataclass(frozen=True)
class ContactFront:
    """The edge of contact: ``crossings`` (k, 2) [mm] on it, and which ``nodes`` (n, 2) of the sheet lie ``inside``.

    ``area`` [mm²] is that of the whole contact.
    """

    crossings: Array
    nodes: Array
    inside: Flags
    area: float

    @property
    def mean(self) -> float:
        """Radius [mm] of the circle of the same area."""
        return float(np.sqrt(self.area / np.pi))

    def points(self) -> Array:
        """Return points (k, 2) on the edge; of a contact without one (a single node) the nodes inside."""
        return self.crossings if len(self.crossings) else self.nodes[self.inside]

    def encloses(self, points: Array) -> Flags:
        """Whether points (n, 2) lie in the contact: as the node next to them does."""
        return np.asarray(self.inside[cKDTree(self.nodes).query(points)[1]])

    def beyond(self, points: Array) -> Array:
        """Return how far (n,) [mm] points lie outside of the contact."""
        away, _ = cKDTree(self.points()).query(points)
        return np.where(self.encloses(points), 0.0, away)


def contact_front(mesh: SheetMesh, place: Array, touching: Flags, gap: Array) -> ContactFront:
    """Return the edge of contact in ``place`` (n, 2) [mm] of the nodes, from flags and ``gap`` (n,)."""
    corners = mesh.elements[:, :3]
    inside = touching.copy()
    if mesh.order == 2:
        seen, votes = np.zeros(mesh.corners), np.zeros(mesh.corners)
        for local, ends in zip((3, 4, 5), _SIDES, strict=True):
            for end in ends:
                np.add.at(seen, mesh.elements[:, end], 1.0)
                np.add.at(votes, mesh.elements[:, end], touching[mesh.elements[:, local]])
        inside[: mesh.corners] = votes > 0.5 * seen
    root = np.sqrt(np.maximum(gap, 0.0))
    part = np.empty((len(corners), 3))
    for side, (a, b) in enumerate(_SIDES):
        first, last = corners[:, a], corners[:, b]
        turned = ~inside[first]
        far = np.where(turned, first, last)
        middle = mesh.elements[:, 3 + side] if mesh.order == 2 else None
        share = _crossing(root, touching, far, middle)
        part[:, side] = np.where(turned, 1.0 - share, share)
    flags = inside[corners]
    crossed = flags != flags[:, [1, 2, 0]]
    start, end = place[corners], place[corners[:, [1, 2, 0]]]
    at = start + part[:, :, None] * (end - start)
    return ContactFront(at[crossed], place, inside, mesh.copies * _area(place[corners], flags, part))


def _crossing(root: Array, touching: Flags, far: Ints, middle: Ints | None) -> Array:
    """Return where (0 at the touching end, 1 at the other) edges leave the punch."""
    if middle is None:
        return np.full(len(far), _MIDDLE)
    grows = root[far] - root[middle]
    share = 0.5 - 0.5 * root[middle] / np.where(grows > 0.0, grows, np.inf)
    return np.where(touching[middle], _LATE, np.clip(share, 0.0, 0.5))


def _area(corner: Array, flags: Flags, part: Array) -> float:
    """Return the area inside of triangles (m, 3, 2) whose sides are crossed at ``part`` (m, 3) of their length."""
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    whole = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    count = flags.sum(axis=1)
    share = np.where(count == 3, 1.0, 0.0)
    for lone in range(3):
        # The corner that differs from the two others: its part of the triangle.
        own = part[:, lone] * (1.0 - part[:, (lone + 2) % 3])
        other = flags[:, [(lone + 1) % 3, (lone + 2) % 3]]
        share = np.where((count == 1) & flags[:, lone], own, share)
        share = np.where((count == 2) & ~flags[:, lone] & other.all(axis=1), 1.0 - own, share)
    return float((whole * share).sum())
