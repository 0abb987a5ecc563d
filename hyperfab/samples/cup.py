"""A parametric cup, male and female, whose normal gap is known exactly everywhere.

The male is ``P(u, v) = (A u + k z, B v, z)`` with the dome ``z = H w^2 (1 + c (1 - w))``,
``w = max(0, 1 - u^2 - v^2)``; the flange is the flat rest of the square |u|, |v| <= 1.3. The female is
``P + t n``, n the male's unit normal and ``t = 3 + 3 S(u^2 + v^2)`` mm, S the smooth step ``q^2 (3 - 2 q)``:
the gap along the male's normal is exactly t, 3 mm at the apex and 6 mm on the flange. Only sums, products and
square roots enter, so the files have the same bytes everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints

A_MM, B_MM, H_MM = 90.0, 80.0, 70.0
K_LEAN, C_FULLNESS = 0.12, 0.5
EDGE = 1.3
MALE_BACK_MM = -40.0
FEMALE_BACK_MM = H_MM + 60.0
#: The dome is inside |u|, |v| <= 1; the grid is fine up to here and coarse on the flat flange.
_FINE = 1.02


@dataclass(frozen=True)
class Solid:
    """A closed triangle surface with outward normals: ``vertices`` (n, 3) [mm], ``faces`` (m, 3)."""

    vertices: Array
    faces: Ints


def male_cup(cells_u: int = 92, cells_v: int = 84) -> Solid:
    """Return the male mold as a watertight solid; its mounting face is z = -40 mm.

    >>> male_cup(8, 8).vertices[:, 2].min()
    np.float64(-40.0)
    """
    surface = _surface(cells_u, cells_v, gap=False)
    return closed_below(surface, MALE_BACK_MM)


def female_cup(cells_u: int = 88, cells_v: int = 90) -> Solid:
    """Return the female mold as a watertight solid; its mounting face is z = 130 mm.

    >>> female_cup(8, 8).vertices[:, 2].max()
    np.float64(130.0)
    """
    surface = _surface(cells_u, cells_v, gap=True)
    return closed_below(surface, FEMALE_BACK_MM, facing_up=False)


def male_point(u: Array, v: Array) -> tuple[Array, Array]:
    """Return the male's points (..., 3) [mm] and unit normals (..., 3) at parameters ``u``, ``v``."""
    q = u * u + v * v
    w = np.maximum(0.0, 1.0 - q)
    z = H_MM * w * w * (1.0 + C_FULLNESS * (1.0 - w))
    # dz/dw; dw/du = -2 u inside the dome, and dz/dw vanishes with w, so no case is needed outside.
    slope = H_MM * w * (2.0 * (1.0 + C_FULLNESS) - 3.0 * C_FULLNESS * w)
    z_u, z_v = -2.0 * u * slope, -2.0 * v * slope
    normal = np.stack([-B_MM * z_u, -A_MM * z_v, A_MM * B_MM + K_LEAN * B_MM * z_u], axis=-1)
    length = np.sqrt(normal[..., 0] ** 2 + normal[..., 1] ** 2 + normal[..., 2] ** 2)
    return np.stack([A_MM * u + K_LEAN * z, B_MM * v, z], axis=-1), normal / length[..., None]


def normal_gap(u: Array, v: Array) -> Array:
    """Return the exact gap [mm] along the male's normal, before any growth or travel."""
    q = np.clip(u * u + v * v, 0.0, 1.0)
    return 3.0 + 3.0 * q * q * (3.0 - 2.0 * q)


def _surface(cells_u: int, cells_v: int, gap: bool) -> Array:
    """The molding surface on a grid, (cells_u + 5, cells_v + 5, 3)."""
    u, v = np.meshgrid(_lines(cells_u), _lines(cells_v), indexing="ij")
    points, normals = male_point(u, v)
    return points + normal_gap(u, v)[..., None] * normals if gap else points


def _lines(cells: int) -> Array:
    fine = np.arange(cells + 1) * (2.0 * _FINE / cells) - _FINE
    return np.concatenate([[-EDGE, -1.16], fine, [1.16, EDGE]])


def closed_below(surface: Array, back: float, facing_up: bool = True) -> Solid:
    """Return a grid of points (n, m, 3) [mm] closed with side walls and a flat back at z = ``back``."""
    rows, columns = surface.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    # Male and female are cut along different diagonals, so that their facets never correspond.
    turned = quads if facing_up else np.roll(quads, 1, axis=1)
    top = np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])

    ring = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    points = surface.reshape(-1, 3)
    foot = points[ring].copy()
    foot[:, 2] = back
    below = np.arange(len(ring)) + len(points)
    centre = np.full(len(ring), len(points) + len(ring))
    ring_on, below_on = np.roll(ring, -1), np.roll(below, -1)
    upper = np.stack([ring, below, ring_on], axis=-1)
    lower = np.stack([below, below_on, ring_on], axis=-1)
    floor = np.stack([below, centre, below_on], axis=-1)

    vertices = np.concatenate([points, foot, [[0.0, 0.0, back]]])
    faces = np.concatenate([top, upper, lower, floor])
    return Solid(np.round(vertices, 5), faces if facing_up else faces[:, ::-1].copy())


def plate(low: float, high: float, half: float = 60.0) -> Solid:
    """Return a square plate between two heights [mm], ``half`` of its side to each side of the axis.

    >>> plate(-20.0, 0.0).vertices.shape, plate(-20.0, 0.0).faces.shape
    ((8, 3), (12, 3))
    """
    corner = np.stack(np.meshgrid([-half, half], [-half, half], [low, high], indexing="ij"), axis=-1)
    quads = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return Solid(corner.reshape(-1, 3), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
