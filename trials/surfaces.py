"""Triangle surfaces for the hunts: written out with all digits, moved, split, shuffled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from cloth_molds import height_block
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Solid:
    """A triangle surface: ``vertices`` (n, 3) [mm] and ``faces`` (m, 3)."""

    vertices: Array
    faces: Ints

    def moved(self, matrix: Any = 1.0, shift: Any = 0.0) -> Solid:
        """Return it scaled or turned by ``matrix``, then shifted; its outside stays outside."""
        matrix = np.asarray(matrix, dtype=float) * np.eye(3) if np.ndim(matrix) < 2 else np.asarray(matrix, float)
        faces = self.faces[:, ::-1] if np.linalg.det(matrix) < 0.0 else self.faces
        return Solid(self.vertices @ matrix.T + shift, faces)

    def split(self) -> Solid:
        """Return the same surface with every facet split in four."""
        v, f = self.vertices, self.faces
        edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
        unique, back = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = back.reshape(3, -1) + len(v)
        a, b, c = f.T
        parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        return Solid(np.concatenate([v, v[unique].mean(axis=1)]), np.concatenate([np.stack(p, 1) for p in parts]))

    def shuffled(self, seed: int = 1) -> Solid:
        """Return it with facets in another order, each beginning at another corner."""
        rng = np.random.default_rng(seed)
        start = rng.integers(3, size=len(self.faces))
        turned = np.take_along_axis(self.faces, (start[:, None] + np.arange(3)) % 3, axis=1)
        return Solid(self.vertices, turned[rng.permutation(len(turned))])

    def stl(self, unit: float = 1.0) -> str:
        """Return an ASCII STL with all digits, in units of ``unit`` mm."""
        rows = ["solid s"]
        for corners in (self.vertices / unit)[self.faces]:
            rows += ["facet normal 0 0 0", "outer loop"]
            rows += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
            rows += ["endloop", "endfacet"]
        return "\n".join([*rows, "endsolid s", ""])


def turned_about(axis: str, degrees: float) -> Array:
    """Return the rotation by ``degrees`` about a coordinate axis."""
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def graph(
    height: Callable[[Array, Array], Array], half: tuple[float, float], cells: tuple[int, int], base: float
) -> Solid:
    """Return a block of half sides ``half`` with upright walls down to ``base``; its top is a graph on ``cells``."""
    block = height_block(height, half, cells, base)
    return Solid(block.vertices, block.faces)


def ball(radius: float, rings: int = 24, around: int = 48, to_deg: float = 180.0, height: float = 0.0) -> Solid:
    """Return a ball about (0, 0, height), or its cap up to an angle from the top, closed below by a point."""
    theta = np.linspace(0.0, np.radians(to_deg), rings + 1)[1 : rings + (to_deg < 180.0)]
    phi = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    ring = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), 0 * phi + 1),
        ],
        -1,
    ).reshape(-1, 3)
    low = [0.0, 0.0, -1.0 if to_deg >= 180.0 else float(np.cos(theta[-1]))]
    return _lathed(np.concatenate([[[0.0, 0.0, 1.0]], ring, [low]]) * radius + [0.0, 0.0, height], len(theta), around)


def lathe(profile: Array, around: int) -> Solid:
    """Return a body turned about z: ``profile`` (k, 2) radii and heights, the first and the last on the axis."""
    phi = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    inner = [np.column_stack([r * np.cos(phi), r * np.sin(phi), np.full(around, z)]) for r, z in profile[1:-1]]
    points = np.concatenate([[[0.0, 0.0, profile[0][1]]], *inner, [[0.0, 0.0, profile[-1][1]]]])
    return _lathed(points, len(inner), around)


def _lathed(points: Array, rings: int, around: int) -> Solid:
    j = np.arange(around)
    k, last = (j + 1) % around, 1 + (rings - 1) * around
    faces = [np.column_stack([0 * j, 1 + j, 1 + k])]
    for i in range(rings - 1):
        a, b = 1 + i * around, 1 + (i + 1) * around
        faces += [np.column_stack([a + j, b + j, b + k]), np.column_stack([a + j, b + k, a + k])]
    faces.append(np.column_stack([last + j, 0 * j + len(points) - 1, last + k]))
    return Solid(points, np.concatenate(faces))


def joined(*solids: Solid) -> Solid:
    """Return several surfaces as one."""
    starts = np.cumsum([0, *(len(one.vertices) for one in solids)])
    faces = [one.faces + start for one, start in zip(solids, starts, strict=False)]
    return Solid(np.concatenate([one.vertices for one in solids]), np.concatenate(faces))
