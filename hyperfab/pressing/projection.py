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
    feature: Ints,
    border: Flags,
    vertices: Array,
    faces: Ints,
    normals: Array,
    rise: Array,
    smooth: Flags,
    least: float,
) -> tuple[Array, Array]:
    """Return the distance (n,) of ``points`` (n, 3) from the smooth surface, and its gradient (n, 3).

    The points' ``distance`` (n,) from the facets, their ``projection`` (n, 3) on facet ``face`` (n,) and on which
    ``feature`` of it (0 inside, 1 to 3 edge, 4 to 6 corner), the unit vector ``away`` (n, 3) from it; ``border`` says
    where the foot lies on an open edge. Of the surface: ``vertices``, ``faces``, the ``normals`` at the vertices,
    ``rise`` and ``smooth`` of ``Curving``; ``least`` is the cosine of the angle between ``away`` and the facet's
    normal up to which the foot counts as lying under the point.

    The distance is ``(distance - height) (away . m)`` with the smooth normal m, and ``distance - height (away . n)``
    with the facet's n where m is no guide. The gradient is that of the number returned, not of the surface it stands
    for: a force along it is the rate of the energy to rounding, however coarse the facets.
    """
    out, gradient = np.empty(len(points)), np.empty((len(points), 3))
    corner, of, m, flat = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    for i in range(len(points)):
        f, a = face[i], away[i]
        for k in range(3):
            for c in range(3):
                corner[k, c] = vertices[faces[f, k], c]
        n, double = _normal(corner)
        size = np.sqrt(double) if double > 0.0 else 1.0
        flat[0], flat[1], flat[2] = n[0] / size, n[1] / size, n[2] / size
        weight = _weights(corner, n, double, projection[i])
        _weight_rates(corner, flat, size, feature[i], of)
        height = weight[0] * weight[1] * rise[f, 0] + weight[1] * weight[2] * rise[f, 1]
        height += weight[2] * weight[0] * rise[f, 2]
        lift = distance[i] - height
        along = _dot(a, flat)
        curved = smooth[f] and not border[i] and along > least
        length = 1.0
        m[:] = flat
        if curved:
            # The facet's foot lies a little beside that of the smooth surface. The distance to the tangent plane there
            # is right to second order all the same, the distance to the foot itself would be too long. Along ``away``
            # the lift is the same from either facet of an edge.
            m[:] = 0.0
            for k in range(3):
                for c in range(3):
                    m[c] += weight[k] * normals[faces[f, k], c]
            length = np.sqrt(_dot(m, m))
            m /= length
        slope = _dot(a, m)
        # At an open edge, on a crease, or far beside a face, the distance is that of the facets.
        out[i] = lift * slope if curved else distance[i] - height * slope
        for c in range(3):
            gradient[i, c] = a[c] * (slope if curved else 1.0)
        for k in range(3):
            # What the height and the normal change by as the foot wanders over the facet.
            higher = weight[(k + 1) % 3] * rise[f, k] + weight[(k + 2) % 3] * rise[f, (k + 2) % 3]
            rate = -higher * slope
            if curved:
                v = faces[f, k]
                for c in range(3):
                    rate += lift / length * (a[c] - slope * m[c]) * normals[v, c]
            for c in range(3):
                gradient[i, c] += rate * of[k, c]
        if feature[i] > 0 and abs(distance[i]) > 0.0:
            # On an edge or a corner ``away`` turns with the point, about the edge.
            turning = (lift if curved else -height) / distance[i]
            edge = np.zeros(3)
            if feature[i] < 4:
                for c in range(3):
                    edge[c] = corner[feature[i] % 3, c] - corner[feature[i] - 1, c]
                edge /= np.sqrt(_dot(edge, edge))
            share = _dot(edge, m)
            for c in range(3):
                gradient[i, c] += turning * (m[c] - slope * a[c] - share * edge[c])
    return out, gradient


@part
def _dot(one: Array, two: Array) -> Any:
    return one[0] * two[0] + one[1] * two[1] + one[2] * two[2]


@part
def _weight_rates(corner: Array, flat: Array, double: float, feature: int, out: Array) -> None:
    """Gradients (3, 3) of the barycentric coordinates of a foot on a ``feature`` of a triangle, with its unit normal
    and twice its area, as the point above it moves."""
    out[:] = 0.0
    if feature == 0:
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            ex, ey, ez = corner[b, 0] - corner[a, 0], corner[b, 1] - corner[a, 1], corner[b, 2] - corner[a, 2]
            out[k, 0] = (flat[1] * ez - flat[2] * ey) / double
            out[k, 1] = (flat[2] * ex - flat[0] * ez) / double
            out[k, 2] = (flat[0] * ey - flat[1] * ex) / double
    elif feature < 4:
        a, b = feature - 1, feature % 3
        square = 0.0
        for c in range(3):
            out[b, c] = corner[b, c] - corner[a, c]
            square += out[b, c] * out[b, c]
        for c in range(3):
            out[b, c] /= square
            out[a, c] = -out[b, c]


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
