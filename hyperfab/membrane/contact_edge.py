"""Where the sheet leaves the punch: the edge of contact, found between the nodes.

Outside the edge the gap grows as the square of the distance, so the root of the gap is extrapolated to zero. On P2
elements corners carry almost no consistent load, so middles of edges alone say where the sheet touches: a corner counts
as touching where most middles of the edges around it do. The edge is a closed curve around the axis of a sphere; of a
punch of any shape, whose contact may be anywhere, in several patches, it is the points on the element edges that cross
it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.equilibrium import Press, State
from hyperfab.membrane.mesh import SheetMesh, interpolate
from hyperfab.numerics.vectors import cross2

#: Nodes out to this many edge lengths beyond the edge take part.
_WINDOW = 4.0
_FEWEST_NODES = 6
#: Harmonics at most: cosines up to the eighth of a quarter, cosines and sines up to the fourth of a whole sheet.
_MOST_HARMONICS = {2: 5, 1: 9}
#: How often the window is laid along the edge that was found in it.
_SWEEPS = 4
#: Angles at which a curve is asked: far more than it has harmonics.
_AROUND = 360


@dataclass(frozen=True)
class ContactEdge:
    """A closed curve around the punch's axis: radius [mm] = sum of ``harmonics`` a_j cos(j m angle).

    ``multiple`` m is 2 where both axes are symmetry lines; with m = 1 sines follow the cosines.
    """

    harmonics: Array
    multiple: int

    @property
    def mean(self) -> float:
        """Mean radius [mm]."""
        return float(self.harmonics[0])

    def radius(self, angle: Array) -> Array:
        """Return the radius at polar angles."""
        return np.asarray(_basis(angle, len(self.harmonics), self.multiple) @ self.harmonics)

    def points(self, count: int = 720) -> Array:
        """Return points (count, 2) on the curve."""
        angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
        return np.asarray(self.radius(angle)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))

    def beyond(self, points: Array) -> Array:
        """Return how far (n,) [mm] points (n, 2) lie outside of the circle of the mean radius."""
        return np.asarray(np.maximum(np.hypot(points[:, 0], points[:, 1]) - self.mean, 0.0))

    def encloses(self, points: Array) -> Flags:
        """Whether points (n, 2) lie inside the curve."""
        return np.hypot(points[:, 0], points[:, 1]) < self.radius(np.arctan2(points[:, 1], points[:, 0]))


def contact_edge(press: Press, state: State, *, deformed: bool = False) -> ContactEdge | ContactFront | None:
    """Return the edge of contact, on the undeformed sheet or in ``deformed`` places; None without contact.

    That of a sphere is a curve around its axis; that of a punch with facets may lie anywhere.
    """
    mesh = press.sheet.mesh
    if not state.touching.any() or state.force <= 0.0:
        return None
    place = state.places[:, :2] if deformed else mesh.nodes
    radius, angle = np.hypot(place[:, 0], place[:, 1]), np.arctan2(place[:, 1], place[:, 0])
    judge = np.arange(len(place)) >= (mesh.corners if mesh.order == 2 else 0)
    judge &= press.sheet.pattern.free[:, 2]
    inside = state.touching & judge
    near = press.punch.near(state.places, state.depth)
    gap = near.gap
    if near.facet is not None:
        return contact_front(mesh, place, state.touching, gap)
    multiple = 2 if mesh.copies == 4 else 1
    if deformed and (near.normal[inside, 2] < 0.0).any():
        return _carried_along(contact_edge(press, state), mesh, state.places)
    outside = judge & ~state.touching & (gap > 0)
    harmonics, edge_length = _about(mesh, place, inside, multiple)
    for _ in range(_SWEEPS):
        beyond = radius - ContactEdge(harmonics, multiple).radius(angle)
        window = outside & (beyond < _WINDOW * edge_length)
        while window.sum() < _FEWEST_NODES and edge_length <= press.sheet.reach:
            edge_length *= 1.5
            window = outside & (beyond < _WINDOW * edge_length)
        if window.sum() < _FEWEST_NODES:
            break
        moved = _moved(harmonics, beyond[window], angle[window], np.sqrt(gap[window]), multiple)
        if moved is None:
            break
        harmonics = moved
    return ContactEdge(harmonics, multiple)


def _carried_along(edge: ContactEdge | ContactFront | None, mesh: SheetMesh, places: Array) -> ContactEdge | None:
    """Return where an edge on the undeformed sheet lies in ``places``: below the equator the radius says no longer
    which nodes lie outside.
    """
    if not isinstance(edge, ContactEdge):
        return None
    angle = np.linspace(0.0, 2 * np.pi / mesh.copies, _AROUND, endpoint=mesh.copies > 1)
    points = edge.radius(angle)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    x, y, _ = interpolate(mesh, places, points).T
    return ContactEdge(_harmonics(np.hypot(x, y), np.arctan2(y, x), len(edge.harmonics), edge.multiple), edge.multiple)


def _about(mesh: SheetMesh, place: Array, inside: Flags, multiple: int) -> tuple[Array, float]:
    """Return harmonics of a curve between the nodes ``inside`` and their neighbours, and how long edges are there."""
    sides = mesh.elements[:, 3:] if mesh.order == 2 else mesh.elements
    pairs = sides[:, _SIDES].reshape(-1, 2)
    crossed = pairs[inside[pairs[:, 0]] != inside[pairs[:, 1]]]
    if not len(crossed):
        radius = np.hypot(place[:, 0], place[:, 1])
        last = float(radius[inside].max()) if inside.any() else 0.0
        return np.array([last]), float(mesh.node_size[np.argmin(np.abs(radius - last))])
    x, y = place[crossed].mean(axis=1).T
    count = min(_MOST_HARMONICS[multiple], max(1, len(crossed) // 4))
    return _harmonics(np.hypot(x, y), np.arctan2(y, x), count, multiple), float(np.median(mesh.node_size[crossed]))


def _harmonics(radius: Array, angle: Array, count: int, multiple: int) -> Array:
    """Return the harmonics of the curve nearest to points (n,) in polar coordinates."""
    found, *_ = np.linalg.lstsq(_basis(angle, count, multiple), radius, rcond=None)
    return np.asarray(found)


def _moved(harmonics: Array, beyond: Array, angle: Array, root: Array, multiple: int) -> Array | None:
    """Return the harmonics of the curve on which ``root`` (n,), the root of the gap, vanishes; None if there is none.

    ``beyond`` (n,) [mm] is how far nodes lie outside of the curve of ``harmonics``:
    root = k(angle) (beyond - shift(angle)) + q beyond^2. How steeply the gap opens, k, changes around the edge
    where the tensions along and across it do.
    """
    count = min(_MOST_HARMONICS[multiple], max(1, len(beyond) // 8))
    shape = _basis(angle, count, multiple)
    columns = np.column_stack([shape * beyond[:, None], -shape, beyond**2])
    found, *_ = np.linalg.lstsq(columns, root, rcond=None)
    around = np.linspace(0.0, 2 * np.pi, _AROUND, endpoint=False)
    steep, rise = (_basis(around, count, multiple) @ found[part : part + count] for part in (0, count))
    if steep.min() <= 0.0:
        return None
    moved = ContactEdge(harmonics, multiple).radius(around) + rise / steep
    return _harmonics(moved, around, max(count, len(harmonics)), multiple)


def _basis(angle: Array, count: int, multiple: int) -> Array:
    columns = [np.ones_like(angle)]
    for order in range(1, count):
        if multiple == 2:
            columns.append(np.cos(2 * order * angle))
        else:
            half = (order + 1) // 2
            columns.append(np.cos(half * angle) if order % 2 else np.sin(half * angle))
    return np.column_stack(columns)


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
        if not inside.any():  # a tip, and no side beside it
            inside = touching.copy()
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
    whole = 0.5 * np.abs(cross2(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    count = flags.sum(axis=1)
    share = np.where(count == 3, 1.0, 0.0)
    for lone in range(3):
        # The corner that differs from the two others: its part of the triangle.
        own = part[:, lone] * (1.0 - part[:, (lone + 2) % 3])
        other = flags[:, [(lone + 1) % 3, (lone + 2) % 3]]
        share = np.where((count == 1) & flags[:, lone], own, share)
        share = np.where((count == 2) & ~flags[:, lone] & other.all(axis=1), 1.0 - own, share)
    return float((whole * share).sum())
