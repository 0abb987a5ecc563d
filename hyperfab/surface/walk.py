"""Nearest points and ray hits found by walking from triangle to triangle, for points close above a surface.

Close to a surface a search tree is at its worst: a sphere that touches the surface touches hundreds of boxes. A walk
starts where the last point ended, crosses a few edges and is there. It finds a local answer; whoever uses it compares
a sample with the exact tree, which takes over where a walk is lost.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hyperfab.numerics.kernels import kernel, part

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Small = npt.NDArray[np.int32]

#: Points are taken in blocks, so that a signal is seen between them.
BLOCK = 100_000
#: Facets from which a lost walk may start again.
ANCHORS = 800


class Walker:
    """A surface prepared for walks: ``vertices`` (n, 3), ``faces`` (m, 3), consistently wound.

    >>> import numpy as np
    >>> walker = Walker(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    >>> found = walker.nearest(np.array([[0.2, 0.5, 2.0]]), np.array([[0.0, 0.0, -1.0]]))
    >>> float(found.distance2[0]), float(found.along[0]), int(found.face[0])
    (4.0, 2.0, 1)
    """

    def __init__(self, vertices: Floats, faces: Ints) -> None:
        self.vertices: Floats = np.ascontiguousarray(vertices, dtype=float)
        self.faces: Small = np.ascontiguousarray(faces, dtype=np.int32)
        self.first, self.incident = _incidence(self.faces, len(self.vertices))
        self.twins = _twins(self.faces, self.first, self.incident)

    def nearest(self, points: Floats, directions: Floats, order: Ints | None = None) -> Found:
        """Walk to the nearest point of each of ``points`` (n, 3), and along ``directions`` (n, 3) to the surface.

        Points are taken in ``order`` (n,), or in that of ``along_a_curve``.
        """
        order = along_a_curve(points) if order is None else order
        n = len(points)
        found = Found(
            np.full(n, np.inf),
            np.empty((n, 3)),
            np.full(n, -1),
            np.zeros(n, np.int64),
            np.zeros(n),
            np.full(n, np.nan),
            np.full(n, -1),
        )
        last = np.array([-1])
        for start in range(0, n, BLOCK):
            _walk_all(
                points,
                directions,
                order[start : start + BLOCK],
                self.vertices,
                self.faces,
                self.twins,
                self.first,
                self.incident,
                last,
                found.distance2,
                found.point,
                found.face,
                found.feature,
                found.side,
                found.along,
                found.hit,
            )
        return found


class Found:
    """What walks found for n points: squared ``distance2`` (n,) to the nearest ``point`` (n, 3), its ``face`` and
    ``feature`` (as ``Surface.nearest`` counts them), the ``side`` (n,) on which the point lies: 1 outside, -1 inside,
    by the normal of face, edge or vertex; distance ``along`` (n,) the
    direction to the face ``hit``. A walk that lost its way leaves NaN and -1."""

    def __init__(
        self,
        distance2: Floats,
        point: Floats,
        face: Ints,
        feature: Ints,
        side: Floats,
        along: Floats,
        hit: Ints,
    ) -> None:
        self.distance2, self.point, self.face, self.feature = distance2, point, face, feature
        self.side = side
        self.along, self.hit = along, hit


@kernel
def _incidence(faces: Small, count: int) -> tuple[Small, Small]:
    first = np.zeros(count + 1, np.int32)
    for f in range(faces.shape[0]):
        for k in range(3):
            first[faces[f, k] + 1] += 1
    for v in range(count):
        first[v + 1] += first[v]
    place = first[:-1].copy()
    incident = np.empty(3 * faces.shape[0], np.int32)
    for f in range(faces.shape[0]):
        for k in range(3):
            v = faces[f, k]
            incident[place[v]] = f
            place[v] += 1
    return first, incident


@kernel
def _twins(faces: Small, first: Small, incident: Small) -> Small:
    """Facet across each edge ab, bc, ca: the one that runs along it the other way; -1 where there is none."""
    twins = np.full(faces.shape, -1, np.int32)
    for f in range(faces.shape[0]):
        for k in range(3):
            a, b = faces[f, k], faces[f, (k + 1) % 3]
            for i in range(first[a], first[a + 1]):
                g = incident[i]
                if (
                    (faces[g, 0] == b and faces[g, 1] == a)
                    or (faces[g, 1] == b and faces[g, 2] == a)
                    or (faces[g, 2] == b and faces[g, 0] == a)
                ):
                    twins[f, k] = g
                    break
    return twins


def along_a_curve(points: Floats) -> Ints:
    """Return the order (n,) of ``points`` (n, 3) along Morton's curve, so that each is near the one before."""
    low, span = points.min(axis=0), max(float(np.ptp(points, axis=0).max()), 1e-300)
    return np.argsort(_morton((points - low) * (1023.0 / span)), kind="stable")


@kernel
def _morton(cells):  # type: ignore[no-untyped-def]
    out = np.empty(len(cells), np.int64)
    for i in range(len(cells)):
        code = np.int64(0)
        for k in range(3):
            cell = np.int64(cells[i, k])
            x = (cell | (cell << 16)) & 0x030000FF
            x = (x | (x << 8)) & 0x0300F00F
            x = (x | (x << 4)) & 0x030C30C3
            x = (x | (x << 2)) & 0x09249249
            code |= x << k
        out[i] = code
    return out


@part
def _closest(  # type: ignore[no-untyped-def]
    vertices, faces, f, x, y, z
):
    """Nearest point of facet ``f``: (squared distance, point, feature). Ericson (2005), section 5.1.5."""
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
    ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
    ux, uy, uz = vertices[b, 0] - ax, vertices[b, 1] - ay, vertices[b, 2] - az
    vx, vy, vz = vertices[c, 0] - ax, vertices[c, 1] - ay, vertices[c, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    d1 = ux * px + uy * py + uz * pz
    d2 = vx * px + vy * py + vz * pz
    uu = ux * ux + uy * uy + uz * uz
    uv = ux * vx + uy * vy + uz * vz
    vv = vx * vx + vy * vy + vz * vz
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    s, t, feature = 0.0, 0.0, 0
    vc = d1 * d4 - d3 * d2
    vb = d5 * d2 - d1 * d6
    va = d3 * d6 - d5 * d4
    if d1 <= 0.0 and d2 <= 0.0:
        feature = 4
    elif d3 >= 0.0 and d4 <= d3:
        s, feature = 1.0, 5
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s, feature = d1 / (d1 - d3), 1
    elif d6 >= 0.0 and d5 <= d6:
        t, feature = 1.0, 6
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t, feature = d2 / (d2 - d6), 3
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s, feature = 1.0 - t, 2
    else:
        scale = 1.0 / (va + vb + vc)
        s, t = vb * scale, vc * scale
    qx, qy, qz = ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz
    return (x - qx) ** 2 + (y - qy) ** 2 + (z - qz) ** 2, qx, qy, qz, feature


@part
def _to_nearest(  # type: ignore[no-untyped-def]
    vertices, faces, twins, first, incident, f, x, y, z
):
    """Descend to the nearest facet: over edges as long as that helps, then over all facets around the corners."""
    best, qx, qy, qz, feature = _closest(vertices, faces, f, x, y, z)
    for _ in range(100_000):
        if 1 <= feature <= 3:
            g = twins[f, feature - 1]
            if g >= 0:
                d, rx, ry, rz, other = _closest(vertices, faces, g, x, y, z)
                if d < best:
                    best, qx, qy, qz, feature, f = d, rx, ry, rz, other, g
                    continue
        home = f
        for k in range(3):
            v = faces[home, k]
            for i in range(first[v], first[v + 1]):
                g = incident[i]
                if g != home:
                    d, rx, ry, rz, other = _closest(vertices, faces, g, x, y, z)
                    if d < best:
                        best, qx, qy, qz, feature, f = d, rx, ry, rz, other, g
        if f == home:
            break
    return best, qx, qy, qz, feature, f


@part
def _to_hit(  # type: ignore[no-untyped-def]
    vertices, faces, twins, f, x, y, z, dx, dy, dz, limit
):
    """Cross edges towards the line from (x, y, z) along (dx, dy, dz): (distance, facet), or (nan, -1) when lost."""
    for _ in range(limit):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = vertices[a, 0] - x, vertices[a, 1] - y, vertices[a, 2] - z
        bx, by, bz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        cx, cy, cz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        # Moments of the edges about the line: none positive where it passes through the facet from its front.
        ab = dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)
        bc = dx * (by * cz - bz * cy) + dy * (bz * cx - bx * cz) + dz * (bx * cy - by * cx)
        ca = dx * (cy * az - cz * ay) + dy * (cz * ax - cx * az) + dz * (cx * ay - cy * ax)
        whole = ab + bc + ca
        if whole >= 0.0:
            return np.nan, -1
        room = -1e-12 * whole
        if ab <= room and bc <= room and ca <= room:
            nx = (by - ay) * (cz - az) - (bz - az) * (cy - ay)
            ny = (bz - az) * (cx - ax) - (bx - ax) * (cz - az)
            nz = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            return (ax * nx + ay * ny + az * nz) / whole, f
        if ab >= bc and ab >= ca:
            g = twins[f, 0]
        elif bc >= ca:
            g = twins[f, 1]
        else:
            g = twins[f, 2]
        if g < 0:
            return np.nan, -1
        f = g
    return np.nan, -1


@kernel
def _walk_all(  # type: ignore[no-untyped-def]
    points,
    directions,
    order,
    vertices,
    faces,
    twins,
    first,
    incident,
    last,
    distance2,
    point,
    face,
    feature,
    side,
    along,
    hit,
):
    f = last[0]
    limit = 100 + 4 * int(np.sqrt(faces.shape[0]))
    for i in order:
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        t, h = np.nan, -1
        for attempt in range(2):
            start = f
            if attempt == 1 or f < 0:
                start = _nearest_anchor(vertices, faces, x, y, z)
            t, h = _to_hit(vertices, faces, twins, start, x, y, z, dx, dy, dz, 8)
            start = h if h >= 0 else start
            d, qx, qy, qz, where, g = _to_nearest(vertices, faces, twins, first, incident, start, x, y, z)
            if h < 0:
                t, h = _to_hit(vertices, faces, twins, g, x, y, z, dx, dy, dz, limit)
            if h >= 0:
                # Only from a place that sees the point squarely does the next walk start.
                f = g
                break
        distance2[i], face[i], feature[i] = d, g, where
        side[i] = _side(vertices, faces, twins, first, incident, g, where, x - qx, y - qy, z - qz)
        point[i, 0], point[i, 1], point[i, 2] = qx, qy, qz
        along[i], hit[i] = t, h
    last[0] = f


@part
def _side(vertices, faces, twins, first, incident, f, feature, x, y, z):  # type: ignore[no-untyped-def]
    """On which side of a feature of facet ``f`` a point lies that stands off it by (x, y, z).

    The normal is that of the face, the mean of the edge's two, or the angle-weighted mean around the vertex, with
    which the sign is right there too (Baerentzen and Aanaes, IEEE TVCG 11 (2005) 243).
    """
    if feature <= 3:
        height = _height(vertices, faces, f, 0, x, y, z)[0]
        if feature >= 1 and twins[f, feature - 1] >= 0:
            height += _height(vertices, faces, twins[f, feature - 1], 0, x, y, z)[0]
        return -1.0 if height < 0.0 else 1.0
    v = faces[f, feature - 4]
    height = 0.0
    for i in range(first[v], first[v + 1]):
        g = incident[i]
        corner = 0 if faces[g, 0] == v else (1 if faces[g, 1] == v else 2)
        above, angle = _height(vertices, faces, g, corner, x, y, z)
        height += angle * above
    return -1.0 if height < 0.0 else 1.0


@part
def _height(vertices, faces, f, corner, x, y, z):  # type: ignore[no-untyped-def]
    """Share of (x, y, z) along the normal of facet ``f``, and the facet's angle at ``corner``."""
    a, b, c = faces[f, corner], faces[f, (corner + 1) % 3], faces[f, (corner + 2) % 3]
    ux, uy, uz = (
        vertices[b, 0] - vertices[a, 0],
        vertices[b, 1] - vertices[a, 1],
        vertices[b, 2] - vertices[a, 2],
    )
    vx, vy, vz = (
        vertices[c, 0] - vertices[a, 0],
        vertices[c, 1] - vertices[a, 1],
        vertices[c, 2] - vertices[a, 2],
    )
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    angle = np.arctan2(size, ux * vx + uy * vy + uz * vz)
    return ((nx * x + ny * y + nz * z) / size if size > 0.0 else 0.0), angle


@part
def _nearest_anchor(vertices, faces, x, y, z):  # type: ignore[no-untyped-def]
    """Of some hundred facets spread over the list, the one whose first corner is nearest."""
    best, found = np.inf, 0
    for f in range(0, faces.shape[0], max(faces.shape[0] // ANCHORS, 1)):
        v = faces[f, 0]
        d = (x - vertices[v, 0]) ** 2 + (y - vertices[v, 1]) ** 2 + (z - vertices[v, 2]) ** 2
        if d < best:
            best, found = d, f
    return found
