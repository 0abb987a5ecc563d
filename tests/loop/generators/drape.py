"""A square net on a ball, by minimising its energy: none of hyperfab's own code.

mm, N, MPa. Nodes that would lie in the ball are pushed out by a stiff penalty; friction is a spring towards where a
node touched first, cut off at the coefficient times the pressure, over many steps of the ball's way up.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

Array = NDArray[np.float64]

IDS = ("friction", "shear-stiffness", "pretension", "gravity", "mold-size")
#: What no entry of the catalogue says: a camera out of square, a sheet creased across, a net read in the wrong scale.
OUTSIDE = ("skewed-camera", "crease", "lens")
SIDE, BALL, DEPTH, NODES, THICK = 200.0, 60.0, 50.0, 21, 1.0
#: Where the ball's middle is, along warp and weft.
ASIDE = (0.0, 0.0)
WARP, WEFT, POWER, HELD = 0.30, 0.20, 0.5, 2.0


@dataclass
class Truth:
    """Effects with their sizes; how the fabric differs from its document within what is known of it."""

    effects: tuple[str, ...]
    size: dict[str, Array] = field(default_factory=dict)
    soft: tuple[float, float] = (1.0, 1.0)


def draw(random: Generator, effects: tuple[str, ...], larger: float = 1.0) -> Truth:
    """Return a sheet with effects of random size, ``larger`` than usual."""
    soft = 1.0 + 0.05 * random.standard_normal(2)
    sizes = {name: np.array([min(larger * random.uniform(0.5, 1.0), 1.4), random.uniform()]) for name in effects}
    return Truth(effects, sizes, (float(soft[0]), float(soft[1])))


def stress(stretch: Array, modulus: float) -> tuple[Array, Array]:
    """Return the nominal stress of a thread and its slope: modulus times strain, stiffening with its square."""
    e = np.maximum(stretch - 1.0, 0.0)
    return modulus * e * (1.0 + POWER * e), np.where(e > 0.0, modulus * (1.0 + 2.0 * POWER * e), 0.0)


class Net:
    """The springs of the sheet with its truth."""

    def __init__(self, truth: Truth) -> None:
        size = truth.size
        n, h = NODES, SIDE / (NODES - 1)
        index = np.arange(n * n).reshape(n, n)
        warp = np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1)
        weft = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1)
        edge_warp = np.isin(warp[:, 0] % n, (0, n - 1))
        edge_weft = np.isin(weft[:, 0] // n, (0, n - 1))
        pre = 1.0 + 0.08 * size.get("pretension", np.zeros(2))[0]
        # As wide as the sheet is before it is stretched over the frame.
        area = THICK * h / pre
        parts = [
            (warp, h / pre, area * np.where(edge_warp, 0.5, 1.0), WARP * truth.soft[0]),
            (weft, h / pre, area * np.where(edge_weft, 0.5, 1.0), WEFT * truth.soft[1]),
        ]
        # A trellis resists the turning of its threads at each crossing: of every cell the four corners, a node and its
        # neighbours along the two threads, each with a quarter of the cell's volume.
        self.corners = np.concatenate(
            [
                np.stack([at.ravel(), along.ravel(), across.ravel()], axis=1)
                for at, along, across in (
                    (index[:-1, :-1], index[1:, :-1], index[:-1, 1:]),
                    (index[1:, 1:], index[:-1, 1:], index[1:, :-1]),
                    (index[1:, :-1], index[:-1, :-1], index[1:, 1:]),
                    (index[:-1, 1:], index[1:, 1:], index[:-1, :-1]),
                )
            ]
        )
        self.turning = 0.08 * size.get("shear-stiffness", np.zeros(2))[0] * 0.25 * THICK * (h / pre) ** 2
        self.ends = np.concatenate([p[0] for p in parts])
        self.rest = np.concatenate([np.full(len(p[0]), p[1]) for p in parts])
        self.area = np.concatenate([p[2] for p in parts])
        self.modulus = np.concatenate([np.full(len(p[0]), p[3]) for p in parts])
        share = np.outer(*(np.where(np.isin(np.arange(n), (0, n - 1)), 0.5, 1.0) * h for _ in range(2)))
        self.weight = share.ravel() / pre**2 * 2000.0 * size.get("gravity", np.zeros(2))[0] * 9.80665e-9
        self.mu = 0.4 * size.get("friction", np.zeros(2))[0]
        self.ball = BALL * (1.0 + 0.05 * size.get("mold-size", np.zeros(2))[0])
        u = np.linspace(-0.5 * SIDE, 0.5 * SIDE, n)
        x, y = np.meshgrid(u, u, indexing="ij")
        self.flat = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
        self.free = (np.abs(self.flat[:, :2]).max(axis=1) < 0.5 * SIDE - 1e-9).nonzero()[0]

    def rest_at(self, depth: float, start: Array, anchors: Array | None) -> tuple[Array, Array]:
        """Return the nodes at equilibrium with the ball's top at ``depth``, and the pressure on each [N]."""
        x, centre = start.copy(), np.array([*ASIDE, depth - self.ball])
        hard, held = 60.0, HELD
        dofs = (3 * self.free[:, None] + np.arange(3)).ravel()
        for step in range(200):
            force, rows, cols, vals = np.zeros_like(x), [], [], []
            force[:, 2] -= self.weight
            a, b = self.ends.T
            d = x[b] - x[a]
            length = np.linalg.norm(d, axis=1)
            way = d / length[:, None]
            s, k = stress(length / self.rest, self.modulus)
            pull = s * self.area
            np.add.at(force, a, pull[:, None] * way)
            np.add.at(force, b, -pull[:, None] * way)
            outer = way[:, :, None] * way[:, None, :]
            block = (k * self.area / self.rest)[:, None, None] * outer
            block += (pull / length)[:, None, None] * (np.eye(3) - outer)
            for p, q, sign in ((a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)):
                _add(rows, cols, vals, p, q, sign * block)
            if self.turning:
                self._turn_back(x, force, rows, cols, vals)
            away = x - centre
            far = np.linalg.norm(away, axis=1)
            normal = away / far[:, None]
            inside = np.flatnonzero(far < self.ball)
            pressure = np.zeros(len(x))
            pressure[inside] = hard * (self.ball - far[inside])
            force += pressure[:, None] * normal
            touch = hard * normal[inside, :, None] * normal[inside, None, :]
            if anchors is not None:
                known = inside[np.isfinite(anchors[inside, 0])]
                slip = x[known] - (anchors[known] + centre)
                slip -= np.sum(slip * normal[known], axis=1)[:, None] * normal[known]
                size = np.linalg.norm(slip, axis=1)
                drag = np.minimum(held * size, self.mu * pressure[known])
                force[known] -= (drag / np.maximum(size, 1e-12))[:, None] * slip
                touch = touch.copy()
                stiff = drag / np.maximum(size, 1e-9)
                where = np.searchsorted(inside, known)
                touch[where] += np.where(size > 1e-9, stiff, held)[:, None, None] * np.eye(3)
            for i in range(3):
                for j in range(3):
                    rows.append(3 * inside + i)
                    cols.append(3 * inside + j)
                    vals.append(touch[:, i, j])
            size_all = 3 * len(x)
            matrix = sparse.csr_matrix(
                (np.concatenate(vals), (np.concatenate(rows), np.concatenate(cols))),
                shape=(size_all, size_all),
            )[dofs][:, dofs] + 1e-6 * sparse.eye(len(dofs))
            residual = force.ravel()[dofs]
            if np.abs(residual).max() < 1e-6:
                break
            move = spsolve(matrix.tocsc(), residual)
            move *= min(1.0, 4.0 / max(float(np.abs(move).max()), 1e-12))
            flatx = x.ravel()
            flatx[dofs] += move * (1.0 if step < 40 else 0.5)
            x = flatx.reshape(-1, 3)
        return x, pressure

    def _turn_back(self, x: Array, force: Array, *entries: list[Array]) -> None:
        """Add the moments on the corners: an angle turns as the end of a thread moves at right angles to it."""
        o, a, b = self.corners.T
        p, q = x[a] - x[o], x[b] - x[o]
        long_p, long_q = np.linalg.norm(p, axis=1)[:, None], np.linalg.norm(q, axis=1)[:, None]
        u, v = p / long_p, q / long_q
        sine = np.linalg.norm(np.cross(u, v), axis=1)[:, None]
        cosine = np.sum(u * v, axis=1)[:, None]
        by_a, by_b = (v - cosine * u) / (sine * long_p), (u - cosine * v) / (sine * long_q)
        ends = ((o, -by_a - by_b), (a, by_a), (b, by_b))
        for one, way in ends:
            np.add.at(force, one, -self.turning * np.arctan2(cosine, sine) * way)
            for other, back in ends:
                _add(*entries, one, other, self.turning * way[:, :, None] * back[:, None, :])

    def drape(self) -> Array:
        """Return the nodes (n, n, 3) at the full depth."""
        x = self.flat.copy()
        x[:, 2] += 1e-3 * np.exp(-np.sum(x[:, :2] ** 2, axis=1) / 200.0)
        anchors = np.full_like(x, np.nan)
        steps = np.linspace(0.0, DEPTH, 26 if self.mu else 6)[1:]
        for depth in steps:
            x, pressure = self.rest_at(float(depth), x, anchors if self.mu else None)
            if self.mu:
                centre = np.array([*ASIDE, depth - self.ball])
                touching = pressure > 0.0
                new = touching & ~np.isfinite(anchors[:, 0])
                anchors[new] = x[new] - centre
                anchors[~touching] = np.nan
                # Where it slips, the anchor follows so far that the drag is just what rubbing can bear.
                old = touching & np.isfinite(anchors[:, 0])
                slip = x[old] - centre - anchors[old]
                size = np.linalg.norm(slip, axis=1)
                most = self.mu * pressure[old] / HELD
                anchors[old] += np.where(size > most, 1.0 - most / np.maximum(size, 1e-12), 0.0)[:, None] * slip
        return x.reshape(NODES, NODES, 3)


def _add(rows: list[Array], cols: list[Array], vals: list[Array], p: Array, q: Array, blocks: Array) -> None:
    """Add the 3x3 blocks that nodes p have with nodes q to a matrix's entries."""
    axes = np.arange(3)
    rows.append(np.broadcast_to(3 * p[:, None, None] + axes[None, :, None], blocks.shape).ravel())
    cols.append(np.broadcast_to(3 * q[:, None, None] + axes[None, None, :], blocks.shape).ravel())
    vals.append(blocks.ravel())


@cache
def _draped(effects: tuple[str, ...], sizes: tuple[float, ...], soft: tuple[float, float]) -> Array:
    return Net(Truth(effects, {k: np.array([v, 0.0]) for k, v in zip(effects, sizes, strict=True)}, soft)).drape()


def measure(truth: Truth, random: Generator, noise: float, protocol: str) -> tuple[Array, Array]:
    """Return markers on the flat sheet (m, 2) and where they are found (m, 3): ``rich`` 120, ``poor`` 25, ``all`` 225,
    ``free`` and ``top`` those far from the middle and near it."""
    inside = tuple(name for name in truth.effects if name in IDS)
    nodes = _draped(inside, tuple(float(truth.size[name][0]) for name in inside), truth.soft)
    u = np.linspace(-0.5 * SIDE, 0.5 * SIDE, NODES)
    # Markers sit on threads' crossings: no interpolation of ours comes in.
    inner = np.array([(i, j) for i in range(1, NODES - 1) for j in range(1, NODES - 1)])
    far = np.abs(u[inner]).max(axis=1) / (0.5 * SIDE)
    inner = inner[{"free": far > 0.6, "top": far < 0.45}.get(protocol, far < 2.0)]
    count = min({"rich": 120, "poor": 25, "all": 225, "free": 144, "top": 49}[protocol], len(inner))
    chosen = inner[random.choice(len(inner), count, replace=False)]
    flat = np.stack([u[chosen[:, 0]], u[chosen[:, 1]]], axis=1)
    found = _seen(truth, flat, nodes[chosen[:, 0], chosen[:, 1]])
    return flat, found + noise * random.standard_normal(found.shape)


def _seen(truth: Truth, flat: Array, found: Array) -> Array:
    """Return places (m, 3) as a bad camera or a bad sheet has them."""
    size, found = truth.size, found.copy()
    if "skewed-camera" in size:
        big, share = size["skewed-camera"]
        angle = 2.0 * np.pi * share
        found[:, 2] += 0.008 * big * (found[:, 0] * np.cos(angle) + found[:, 1] * np.sin(angle))
    if "lens" in size:
        big, share = size["lens"]
        found[:, :2] *= 1.0 + 0.01 * big * np.sum((found[:, :2] / SIDE - 0.2 * share) ** 2, axis=1)[:, None]
    if "crease" in size:
        big, share = size["crease"]
        away = flat @ np.array([np.cos(np.pi * share), np.sin(np.pi * share)]) - 30.0
        found[:, 2] += 0.8 * big * np.exp(-((away / 9.0) ** 2))
    return found


def ball_stl(rings: int = 60, around: int = 120) -> bytes:
    """Return the ball's upper part as ASCII STL, closed below, its top at z = 0."""
    theta = np.linspace(0.0, 0.55 * np.pi, rings + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    points = [np.array([0.0, 0.0, BALL])]
    points += [
        BALL * np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)]) for t in theta[1:] for p in phi
    ]
    points.append(np.array([0.0, 0.0, BALL * np.cos(theta[-1])]))
    faces = []
    for j in range(around):
        k = (j + 1) % around
        faces.append((0, 1 + j, 1 + k))
        for i in range(rings - 1):
            a, b = 1 + i * around, 1 + (i + 1) * around
            faces += [(a + j, b + j, b + k), (a + j, b + k, a + k)]
        last = 1 + (rings - 1) * around
        faces.append((last + j, len(points) - 1, last + k))
    lines = ["solid ball"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {points[i][0]:.10g} {points[i][1]:.10g} {points[i][2] - BALL:.10g}" for i in face]
        lines += ["endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid ball"]) + "\n").encode()


def thread_csv(modulus: float) -> str:
    """Return the law of a thread as a uniaxial test."""
    e = np.linspace(0.0, 1.0, 201)
    rows = [f"{a:.6g},{b:.10g}" for a, b in zip(e, stress(1.0 + e, modulus)[0], strict=True)]
    return "\n".join(["strain [-],stress [MPa]", *rows]) + "\n"
