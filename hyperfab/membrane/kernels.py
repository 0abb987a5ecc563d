"""Compiled element loops: strains from nodal places, and forces and stiffness from stresses."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel


@kernel
def strains(places: Array, elements: Ints, gradients: Array) -> Array:
    """Return C11, C22, C12 (m q, 3) of the right Cauchy–Green tensor for nodal places (n, 3)."""
    count, points, shapes, _ = gradients.shape
    result = np.empty((count * points, 3))
    for e in range(count):
        for q in range(points):
            c11 = c22 = c12 = 0.0
            for i in range(3):
                f1 = f2 = 0.0
                for a in range(shapes):
                    x = places[elements[e, a], i]
                    f1 += x * gradients[e, q, a, 0]
                    f2 += x * gradients[e, q, a, 1]
                c11 += f1 * f1
                c22 += f2 * f2
                c12 += f1 * f2
            result[e * points + q, 0] = c11
            result[e * points + q, 1] = c22
            result[e * points + q, 2] = c12
    return result


@kernel
def assemble(
    places: Array,
    elements: Ints,
    gradients: Array,
    weights: Array,
    stress: Array,
    stiffness: Array,
    support: Array,
    block_of: Ints,
    turn: Ints,
    force: Array,
    data: Array,
) -> None:
    """Add the elements ``turn`` to nodal forces (n, 3) and to the stiffness as 3 × 3 blocks (blocks, 3, 3).

    ``weights`` (m, q) include the thickness; ``stress`` (m q, 3) and ``stiffness`` (m q, 6) as in Response;
    ``support`` (m q,) is a tension that enters the stiffness alone, not the forces: it carries Newton's method
    where the sheet has no stiffness of its own. ``block_of`` (m, a, a) is the block that a pair of element nodes
    adds to.
    """
    _, points, shapes, _ = gradients.shape
    deformation = np.empty((3, 2))
    b = np.empty((shapes, 3, 3))
    db = np.empty((3, 3))
    local = np.empty((shapes, shapes, 3, 3))
    order = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])
    for e in turn:
        local[:] = 0.0
        for q in range(points):
            w = weights[e, q]
            row = e * points + q
            s11, s22, s12 = stress[row, 0], stress[row, 1], stress[row, 2]
            deformation[:] = 0.0
            for a in range(shapes):
                for i in range(3):
                    x = places[elements[e, a], i]
                    deformation[i, 0] += x * gradients[e, q, a, 0]
                    deformation[i, 1] += x * gradients[e, q, a, 1]
            for a in range(shapes):
                g1, g2 = gradients[e, q, a, 0], gradients[e, q, a, 1]
                for i in range(3):
                    b[a, 0, i] = deformation[i, 0] * g1
                    b[a, 1, i] = deformation[i, 1] * g2
                    b[a, 2, i] = deformation[i, 0] * g2 + deformation[i, 1] * g1
                    force[elements[e, a], i] += w * (b[a, 0, i] * s11 + b[a, 1, i] * s22 + b[a, 2, i] * s12)
            for c in range(shapes):
                for k in range(3):
                    for i in range(3):
                        db[k, i] = w * (
                            stiffness[row, order[k, 0]] * b[c, 0, i]
                            + stiffness[row, order[k, 1]] * b[c, 1, i]
                            + stiffness[row, order[k, 2]] * b[c, 2, i]
                        )
                h1, h2 = gradients[e, q, c, 0], gradients[e, q, c, 1]
                carried = support[row]
                t1 = w * ((s11 + carried) * h1 + s12 * h2)
                t2 = w * (s12 * h1 + (s22 + carried) * h2)
                for a in range(c + 1):
                    geometric = gradients[e, q, a, 0] * t1 + gradients[e, q, a, 1] * t2
                    for i in range(3):
                        for j in range(3):
                            local[a, c, i, j] += b[a, 0, i] * db[0, j] + b[a, 1, i] * db[1, j] + b[a, 2, i] * db[2, j]
                        local[a, c, i, i] += geometric
        for c in range(shapes):
            for a in range(c + 1):
                upper, lower = block_of[e, a, c], block_of[e, c, a]
                for i in range(3):
                    for j in range(3):
                        data[upper, i, j] += local[a, c, i, j]
                        if a != c:
                            data[lower, j, i] += local[a, c, i, j]


@kernel
def polygon_distance(points: Array, vertices: Array) -> Array:
    """Return the distance (n,) of points (n, 2) to a closed polyline (k, 2), positive inside."""
    count = len(vertices)
    result = np.empty(len(points))
    for n in range(len(points)):
        x, y = points[n, 0], points[n, 1]
        least = np.inf
        inside = False
        for i in range(count):
            ax, ay = vertices[i, 0], vertices[i, 1]
            j = i + 1 if i + 1 < count else 0
            bx, by = vertices[j, 0], vertices[j, 1]
            ux, uy = bx - ax, by - ay
            vx, vy = x - ax, y - ay
            part = min(1.0, max(0.0, (ux * vx + uy * vy) / (ux * ux + uy * uy)))
            dx, dy = vx - part * ux, vy - part * uy
            least = min(least, dx * dx + dy * dy)
            if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * ux:
                inside = not inside
        result[n] = np.sqrt(least) if inside else -np.sqrt(least)
    return result
