"""Where the sheet leaves the punch: the edge of contact, found between the nodes.

Outside the edge the gap grows as the square of the distance, so the root of the gap is extrapolated to zero. On P2
elements corners carry almost no consistent load, so middles of edges alone say where the sheet touches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array
from hyperfab.membrane.contact_front import ContactFront, contact_front
from hyperfab.membrane.equilibrium import Press, State

#: Nodes out to this many edge lengths beyond the last touching one take part.
_WINDOW = 4.0
_FEWEST_NODES = 6


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

    def encloses(self, points: Array) -> NDArray[np.bool_]:
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
    last = float(radius[inside].max()) if inside.any() else 0.0
    near = press.punch.near(state.places, state.depth)
    gap = near.gap
    if near.facet is not None:
        return contact_front(mesh, place, state.touching, gap)
    edge_length = float(mesh.node_size[np.argmin(np.abs(radius - last))])
    window = judge & ~state.touching & (gap > 0) & (radius < last + _WINDOW * edge_length)
    multiple = 2 if mesh.copies == 4 else 1
    while window.sum() < _FEWEST_NODES:
        edge_length *= 1.5
        window = judge & ~state.touching & (gap > 0) & (radius < last + _WINDOW * edge_length)
        if edge_length > press.sheet.reach:
            return ContactEdge(np.array([last]), multiple)
    count = min(5, max(1, int(window.sum()) // 8))
    shape = _basis(angle[window], count, multiple)
    # sqrt(gap) = k (r - a(angle)) + q (r - last)^2, with k a_j as unknowns.
    columns = np.column_stack([radius[window], (radius[window] - last) ** 2, -shape])
    found, *_ = np.linalg.lstsq(columns, np.sqrt(gap[window]), rcond=None)
    if found[0] <= 0:
        return ContactEdge(np.array([last]), multiple)
    return ContactEdge(found[2:] / found[0], multiple)


def _basis(angle: Array, count: int, multiple: int) -> Array:
    columns = [np.ones_like(angle)]
    for order in range(1, count):
        if multiple == 2:
            columns.append(np.cos(2 * order * angle))
        else:
            half = (order + 1) // 2
            columns.append(np.cos(half * angle) if order % 2 else np.sin(half * angle))
    return np.column_stack(columns)
