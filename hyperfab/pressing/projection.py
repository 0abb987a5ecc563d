"""The nearest point of the smooth surface behind the facets, compiled.

The surface is one of curved patches, a facet each, that meet in the same curve along every edge (``Curving``). Of the
patch under the nearest facet and of those around it that may be nearer, the nearest point counts: the distance to a
surface without gaps is continuous, wherever the patch changes, and its gradient is the direction to the nearest point.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import inlined, kernel, part
from hyperfab.surface.bvh import closest_on_triangle

#: A foot is found where Newton's method moves it by less than this share of the patch; beyond so many sizes of the
#: patch it is on an edge.
_FOUND, _ROUNDS, _FAR = 1e-11, 30, 30.0
#: Of patches that are as near as each other, to this share, the first one met is told: that under the nearest facet.
_AS_NEAR = 1e-12


@kernel
def smooth_gap(
    points: Array,
    distance: Array,
    face: Ints,
    away: Array,
    vertices: Array,
    faces: Ints,
    bulge: Array,
    skew: Array,
    room: Array,
    first: Ints,
    facets: Ints,
) -> tuple[Array, Array, Ints]:
    """Return the signed distance (n,) of ``points`` (n, 3) from the smooth surface, its gradient (n, 3), and the facet
    (n,) whose patch is nearest.

    The points' ``distance`` (n,) from the facets, the nearest ``face`` (n,) and the unit vector ``away`` (n, 3) from
    it. Of the surface: ``vertices``, ``faces``, the ``bulge``, ``skew`` and ``room`` of ``Curving``, and the ``facets``
    at each vertex, from ``first`` on.

    Where the foot lies within a patch its normal tells the side; on an edge or a corner, as on a border or a crease,
    the facets do, unless the point lies between them and the patches.
    """
    out, gradient, patch = np.empty(len(points)), np.empty((len(points), 3)), np.empty(len(points), np.int64)
    corner, terms, x, xu, xv = np.empty((3, 3)), np.empty((10, 3)), np.empty(3), np.empty(3), np.empty(3)
    foot, normal = np.empty(3), np.empty(3)
    for i in range(len(points)):
        f, p = face[i], points[i]
        best, best_inside, near = np.inf, False, 0.0
        # The nearest facet's own patch, then those around it: no other is near enough where facets are small
        # against the molds' curvature.
        for turn in range(-1, 3):
            begin, end = 0, 1
            if turn >= 0:
                begin, end = first[faces[f, turn]], first[faces[f, turn] + 1]
            for k in range(begin, end):
                other = f if turn < 0 else facets[k]
                if turn >= 0 and (other == f or _met_before(faces, f, turn, other)):
                    continue
                for a in range(3):
                    for c in range(3):
                        corner[a, c] = vertices[faces[other, a], c]
                if turn >= 0:
                    y0, y1, y2, _ = closest_on_triangle(corner, p[0], p[1], p[2])
                    far = np.sqrt((p[0] - y0) ** 2 + (p[1] - y1) ** 2 + (p[2] - y2) ** 2)
                    if far - room[other] > best:
                        continue
                _terms(corner, bulge, skew, other, terms)
                u, v, inside = _foot(terms, p)
                _place(terms, u, v, x, xu, xv)
                far = np.sqrt((p[0] - x[0]) ** 2 + (p[1] - x[1]) ** 2 + (p[2] - x[2]) ** 2)
                if far < best * (1.0 - _AS_NEAR):
                    best, best_inside, patch[i], near = far, inside, other, max(near, room[other])
                    foot[:] = x
                    for c in range(3):
                        normal[c] = xu[(c + 1) % 3] * xv[(c + 2) % 3] - xu[(c + 2) % 3] * xv[(c + 1) % 3]
        size = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        height = 0.0
        for c in range(3):
            normal[c] = normal[c] / size if size > 0.0 else away[i, c]
            height += (p[c] - foot[c]) * normal[c]
        side = 1.0 if distance[i] >= 0.0 else -1.0
        if (best_inside or abs(distance[i]) <= 2.0 * near) and height != 0.0:
            side = 1.0 if height > 0.0 else -1.0
        out[i] = side * best
        for c in range(3):
            beside = side * (p[c] - foot[c]) / best if best > 0.0 else away[i, c]
            gradient[i, c] = normal[c] if best_inside else beside
    return out, gradient, patch


@part
def _met_before(faces: Ints, f: int, turn: int, other: int) -> bool:
    """Whether facet ``other`` touches a corner of ``f`` before that of ``turn``."""
    for k in range(turn):
        for v in range(3):
            if faces[other, v] == faces[f, k]:
                return True
    return False


@inlined
def _terms(corner: Array, bulge: Array, skew: Array, f: int, out: Array) -> None:
    """Fill the terms (10, 3) of a patch: those of 1, u, v, u^2, uv, v^2, u^3, u^2 v, u v^2, v^3.

    The patch is ``sum w_k corner_k + sum w_a w_b (bulge_ab + (w_a - w_b) skew_ab)`` in barycentric coordinates w, of
    which u and v are those of the second and the third corner.
    """
    for c in range(3):
        r0, r1, r2 = bulge[f, 0, c], bulge[f, 1, c], bulge[f, 2, c]
        q0, q1, q2 = skew[f, 0, c], skew[f, 1, c], skew[f, 2, c]
        out[0, c] = corner[0, c]
        out[1, c] = corner[1, c] - corner[0, c] + r0 + q0
        out[2, c] = corner[2, c] - corner[0, c] + r2 - q2
        out[3, c] = -r0 - 3.0 * q0
        out[4, c] = r1 - r0 - r2 + 2.0 * (q2 - q0)
        out[5, c] = -r2 + 3.0 * q2
        out[6, c] = 2.0 * q0
        out[7, c] = 3.0 * q0 + q1 - q2
        out[8, c] = q0 - q1 - 3.0 * q2
        out[9, c] = -2.0 * q2


@inlined
def _place(terms: Array, u: float, v: float, x: Array, xu: Array, xv: Array) -> None:
    """Fill a place (3,) of the patch and its derivatives (3,) by u and v."""
    for c in range(3):
        x[c], xu[c], xv[c] = _along(terms, c, u, v)


@part
def _foot(terms: Array, p: Array) -> Any:
    """Return u and v of the place of a patch that is nearest to ``p`` (3,), and whether it is within, on no edge."""
    u, v = 1.0 / 3.0, 1.0 / 3.0
    for _ in range(_ROUNDS):
        gu, gv, uu, uv, vv, cu, cw, cv = _rates(terms, u, v, p)
        hu, hw, hv = uu + cu, uv + cw, vv + cv
        det = hu * hv - hw * hw
        if not (det > 1e-3 * (uu * vv - uv * uv) and hu > 0.0):
            hu, hw, hv = uu, uv, vv  # beyond the centre of curvature: the way down all the same
            det = hu * hv - hw * hw
        if not det > 0.0:
            break  # a facet without area has its edges alone
        du, dv = (hw * gv - hv * gu) / det, (hw * gu - hu * gv) / det
        u, v = u + du, v + dv
        if abs(u) + abs(v) > _FAR:
            break
        if abs(du) + abs(dv) < _FOUND:
            if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                return u, v, True
            break
    # The nearest point of the triangle lies on an edge beyond which the foot was found.
    known = v < 0.0 or u + v > 1.0 or u < 0.0
    best, best_u, best_v = np.inf, 0.0, 0.0
    for k in range(3):
        if known and not (v < 0.0 if k == 0 else (u + v > 1.0 if k == 1 else u < 0.0)):
            continue
        # From corner k to the next.
        u0, v0 = 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0
        du, dv = (1.0 if k == 0 else -1.0 if k == 1 else 0.0), (0.0 if k == 0 else 1.0 if k == 1 else -1.0)
        t = 0.5
        for _ in range(_ROUNDS):
            gu, gv, uu, uv, vv, cu, cw, cv = _rates(terms, u0 + t * du, v0 + t * dv, p)
            square = du * du * uu + 2.0 * du * dv * uv + dv * dv * vv
            curved = square + du * du * cu + 2.0 * du * dv * cw + dv * dv * cv
            if not square > 0.0:
                break
            step = (du * gu + dv * gv) / (curved if curved > 1e-3 * square else square)
            moved = min(max(t - step, 0.0), 1.0)
            step, t = abs(moved - t), moved
            if step < _FOUND:
                break
        far = 0.0
        for c in range(3):
            x, _, _ = _along(terms, c, u0 + t * du, v0 + t * dv)
            far += (x - p[c]) ** 2
        if far < best:
            best, best_u, best_v = far, u0 + t * du, v0 + t * dv
    return best_u, best_v, False


@inlined
def _rates(terms: Array, u: float, v: float, p: Array) -> Any:
    """Derivatives of half the squared distance to ``p``: by u, v; the products of the patch's by uu, uv, vv; what its
    curvature adds to them."""
    gu, gv, uu, uv, vv, cu, cw, cv = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(3):
        x, xu, xv = _along(terms, c, u, v)
        off = x - p[c]
        gu, gv = gu + off * xu, gv + off * xv
        uu, uv, vv = uu + xu * xu, uv + xu * xv, vv + xv * xv
        cu += 2.0 * off * (terms[3, c] + 3.0 * u * terms[6, c] + v * terms[7, c])
        cw += off * (terms[4, c] + 2.0 * (u * terms[7, c] + v * terms[8, c]))
        cv += 2.0 * off * (terms[5, c] + 3.0 * v * terms[9, c] + u * terms[8, c])
    return gu, gv, uu, uv, vv, cu, cw, cv


@inlined
def _along(terms: Array, c: int, u: float, v: float) -> Any:
    """One coordinate of a place of the patch, and its derivatives by u and v."""
    k1, k2, k3, k4, k5 = terms[1, c], terms[2, c], terms[3, c], terms[4, c], terms[5, c]
    k6, k7, k8, k9 = terms[6, c], terms[7, c], terms[8, c], terms[9, c]
    x = terms[0, c] + u * (k1 + u * (k3 + u * k6)) + v * (k2 + v * (k5 + v * k9)) + u * v * (k4 + u * k7 + v * k8)
    xu = k1 + u * (2.0 * k3 + 3.0 * u * k6) + v * (k4 + 2.0 * u * k7 + v * k8)
    xv = k2 + v * (2.0 * k5 + 3.0 * v * k9) + u * (k4 + u * k7 + 2.0 * v * k8)
    return x, xu, xv
