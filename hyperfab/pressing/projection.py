"""From the nearest point on the facets to the nearest distance from the smooth surface behind them, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.numerics.kernels import kernel, part


@kernel
def smooth_gap(
    points: Array,
    distance: Array,
    projection: Array,
    away: Array,
    face: Ints,
    border: Flags,
    vertices: Array,
    faces: Ints,
    normals: Array,
    rise: Array,
    smooth: Flags,
    least: float,
) -> tuple[Array, Array]:
    """Return distance (n,) and direction (n, 3) of ``points`` (n, 3) from the smooth surface.

    The points' ``distance`` (n,) from the facets, their ``projection`` (n, 3) on facet ``face`` (n,), the unit vector
    ``away`` (n, 3) from it; ``border`` says where the foot lies on an open edge. Of the surface: ``vertices``,
    ``faces``, the ``normals`` at the vertices, ``rise`` and ``smooth`` of ``Curving``; ``least`` is the cosine of the
    angle between ``away`` and the facet's normal up to which the foot counts as lying under the point.
    """
    out, direction = np.empty(len(points)), np.empty((len(points), 3))
    corner = np.empty((3, 3))
    for i in range(len(points)):
        f = face[i]
        for k in range(3):
            for a in range(3):
                corner[k, a] = vertices[faces[f, k], a]
        n, double = _normal(corner)
        weight = _weights(corner, n, double, projection[i])
        height = weight[0] * weight[1] * rise[f, 0] + weight[1] * weight[2] * rise[f, 1]
        height += weight[2] * weight[0] * rise[f, 2]
        size = np.sqrt(double) if double > 0.0 else 1.0
        along = (away[i, 0] * n[0] + away[i, 1] * n[1] + away[i, 2] * n[2]) / size
        if smooth[f] and not border[i] and along > least:
            # The facet's foot lies a little beside that of the smooth surface. The distance to the tangent plane there
            # is right to second order all the same, the distance to the foot itself would be too long. Along ``away``
            # the lift is the same from either facet of an edge.
            mx = my = mz = 0.0
            for k in range(3):
                v = faces[f, k]
                mx += weight[k] * normals[v, 0]
                my += weight[k] * normals[v, 1]
                mz += weight[k] * normals[v, 2]
            length = np.sqrt(mx * mx + my * my + mz * mz)
            mx, my, mz = mx / length, my / length, mz / length
            out[i] = (
                (points[i, 0] - projection[i, 0] - height * away[i, 0]) * mx
                + (points[i, 1] - projection[i, 1] - height * away[i, 1]) * my
                + (points[i, 2] - projection[i, 2] - height * away[i, 2]) * mz
            )
            direction[i, 0], direction[i, 1], direction[i, 2] = mx, my, mz
        else:
            # At an open edge, on a crease, or far beside a face, the distance is that of the facets.
            out[i] = distance[i] - height * along
            direction[i] = away[i]
    return out, direction


@part
def _normal(corner: Array) -> Any:
    """Normal of a triangle (3, 3), twice its area long, and its square."""
    ux, uy, uz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
    vx, vy, vz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return (x, y, z), x * x + y * y + z * z


@part
def _weights(corner: Array, n: tuple[float, float, float], double: float, at: Array) -> Any:
    """Barycentric coordinates of a point ``at`` (3,) of a triangle (3, 3), kept within it."""
    px, py, pz = at[0] - corner[0, 0], at[1] - corner[0, 1], at[2] - corner[0, 2]
    ux, uy, uz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
    vx, vy, vz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
    whole = double if double > 0.0 else 1.0
    wb = (py * vz - pz * vy) * n[0] + (pz * vx - px * vz) * n[1] + (px * vy - py * vx) * n[2]
    wc = (uy * pz - uz * py) * n[0] + (uz * px - ux * pz) * n[1] + (ux * py - uy * px) * n[2]
    wb, wc = wb / whole, wc / whole
    wa = 1.0 - wb - wc
    return min(max(wa, 0.0), 1.0), min(max(wb, 0.0), 1.0), min(max(wc, 0.0), 1.0)
