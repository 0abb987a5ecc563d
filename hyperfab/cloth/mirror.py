"""A sheet that is its own mirror image keeps so while it comes to rest: its steps are mirrored as its forces are.

Facets of a mold let a node rest on one or the next, and which it is hangs on the way there. Sweeps over the nodes in
their order lead a node and its mirror image on ways that differ by what the linear solver leaves, so that they end in
different facets. Where the unbalanced forces and the ways left to the nodes are mirror images, so is Newton's step: the
mean of a solution and its images is one that no solver's order has touched, and no further from the true one.
"""

from __future__ import annotations

from hyperfab.arrays import Array
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.threads import in_rows

#: Unbalanced forces that differ by less than this share of the largest are mirror images; directions, by the second.
FORCES, DIRECTIONS = 1e-2, 1e-5
#: The mirrors, of nodes and coordinates alike: x to -x, y to -y, and of a square grid x to y and x to -y.
MIRRORS = 4


@part
def _image(mirror: int, i: int, j: int, n: int, m: int) -> tuple[int, int, int, int, float, float]:
    """The image of node (i, j), the coordinates that become x and y there, and their signs."""
    if mirror == 0:
        return n - 1 - i, j, 0, 1, -1.0, 1.0
    if mirror == 1:
        return i, m - 1 - j, 0, 1, 1.0, -1.0
    if mirror == 2:
        return j, i, 1, 0, 1.0, 1.0
    return m - 1 - j, n - 1 - i, 1, 0, -1.0, -1.0


@kernel
def _is_even(r: Array, q: Array, mirror: int, forces: float, start: int, end: int) -> bool:
    """Are forces r (n, m, 3) and projectors q (n, m, 6) of rows ``start:end`` those of their image?"""
    n, m = r.shape[0], r.shape[1]
    for i in range(start, end):
        for j in range(m):
            k, l, a, b, sx, sy = _image(mirror, i, j, n, m)
            if i * m + j > k * m + l:
                continue
            f, g, p, o = r[i, j], r[k, l], q[i, j], q[k, l]
            if (
                abs(f[0] - sx * g[a]) > forces
                or abs(f[1] - sy * g[b]) > forces
                or abs(f[2] - g[2]) > forces
                or abs(p[0] - o[3 * a]) > DIRECTIONS
                or abs(p[3] - o[3 * b]) > DIRECTIONS
                or abs(p[5] - o[5]) > DIRECTIONS
                or abs(p[1] - sx * sy * o[1]) > DIRECTIONS
                or abs(p[2] - sx * o[2 + 2 * a]) > DIRECTIONS
                or abs(p[4] - sy * o[2 + 2 * b]) > DIRECTIONS
            ):
                return False
    return True


@kernel
def mean(d: Array, mirror: int) -> None:
    """d (n, m, 3) = the mean of d and its image by one of the mirrors."""
    n, m = d.shape[0], d.shape[1]
    for i in range(n):
        for j in range(m):
            k, l, a, b, sx, sy = _image(mirror, i, j, n, m)
            if i * m + j > k * m + l:
                continue
            u, v = d[i, j], d[k, l]
            x, y, z = 0.5 * (u[0] + sx * v[a]), 0.5 * (u[1] + sy * v[b]), 0.5 * (u[2] + v[2])
            u[0], u[1], u[2] = x, y, z
            v[a], v[b], v[2] = sx * x, sy * y, z


def even(d: Array, r: Array, q: Array, worst: float) -> None:
    """Mirror a step ``d`` (n, m, 3) as the forces ``r`` and projectors ``q`` (n, m, 6) are; ``worst``: largest r."""
    n, m = r.shape[:2]
    odd = [False] * MIRRORS

    def look(first: int, last: int) -> None:
        for mirror in range(MIRRORS if n == m else 2):
            if not odd[mirror] and not _is_even(r, q, mirror, FORCES * worst, first, last):
                odd[mirror] = True

    in_rows(look, n, m)
    for mirror in range(MIRRORS if n == m else 2):
        if not odd[mirror]:
            mean(d, mirror)
