"""Molds with bosses, pits, folds and bumps, drawn at random, and their gaps by trying every facet.

PYTHONPATH=.:tests python -m rough_molds 10000
"""

import sys

import numpy as np
from numba import njit

from hyperfab.samples.cup import female_cup, male_cup
from hyperfab.surface import Surface

KINDS = ("boss", "pit", "fold", "bumpy")


@njit(cache=True)
def brute(points, corners):
    """Distance (n,) to the nearest of ``corners`` (m, 3, 3), by its plane and its three sides.

    Facets are skipped only where the sphere around their first corner that holds them is further than one found.
    """
    first = np.ascontiguousarray(corners[:, 0])
    radius = np.zeros(len(first))
    for t in range(len(first)):
        for v in range(1, 3):
            side = corners[t, v] - corners[t, 0]
            radius[t] = max(radius[t], np.sqrt(_dot(side, side)))
    out = np.empty(len(points))
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        best = np.inf
        for t in range(len(first)):
            best = min(best, (x - first[t, 0]) ** 2 + (y - first[t, 1]) ** 2 + (z - first[t, 2]) ** 2)
        best = np.sqrt(best)
        for t in range(len(first)):
            far = (x - first[t, 0]) ** 2 + (y - first[t, 1]) ** 2 + (z - first[t, 2]) ** 2
            if far <= (best + radius[t]) ** 2 * (1.0 + 1e-12) + 1e-12:
                best = min(best, _to_facet(points[i], corners[t]))
        out[i] = best
    return out


@njit(cache=True)
def _to_facet(p, corner):
    a, b, c = corner[0], corner[1], corner[2]
    sides = ((a, b), (b, c), (c, a))
    n = _cross(b - a, c - a)
    size = np.sqrt(_dot(n, n))
    if size > 0.0:
        n /= size
        height = _dot(p - a, n)
        foot, inside = p - height * n, True
        for s, e in sides:
            inside = inside and _dot(_cross(e - s, foot - s), n) >= 0.0
        if inside:
            return abs(height)
    best = np.inf
    for s, e in sides:
        side = e - s
        long = _dot(side, side)
        share = min(max(_dot(p - s, side) / long, 0.0), 1.0) if long > 0.0 else 0.0
        off = s + share * side - p
        best = min(best, np.sqrt(_dot(off, off)))
    return best


# numpy's own sums and products take seconds to compile.
@njit(cache=True)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _cross(a, b):
    out = np.empty(3)
    out[0], out[1], out[2] = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return out


def displaced(vertices, faces, centre, height, width):
    """The vertices moved by height exp(-|x - centre|^2 / width^2) along the outward normals."""
    normals = Surface(vertices, faces).vertex_normals
    bell = np.exp(-((vertices - centre) ** 2).sum(axis=1) / width**2)
    return vertices + height * bell[:, None] * normals


def split(vertices, faces):
    """The same surface with every facet split in four."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    unique, back = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = back.reshape(3, -1) + len(vertices)
    a, b, c = faces.T
    parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    return np.concatenate([vertices, vertices[unique].mean(axis=1)]), np.concatenate(
        [np.stack(part, axis=1) for part in parts]
    )


def cups(cells=0):
    """The sample's male and female, or both with ``cells`` cells a side: vertices and faces."""
    male, female = (male_cup(cells, cells), female_cup(cells, cells)) if cells else (male_cup(), female_cup())
    return (male.vertices, male.faces), (female.vertices, female.faces)


def rough_cup(rng):
    """The sample's female with one boss or pit: r 2 to 6 mm, 1 to 4 mm high, anywhere."""
    (points, _), (vertices, faces) = cups()
    centre = vertices[rng.integers(len(vertices))]
    height = rng.uniform(1.0, 4.0) * rng.choice([-1.0, 1.0])
    return points, displaced(vertices, faces, centre, height, rng.uniform(1.0, 3.0)), faces


def rough_sheet(rng, kind, cells=26):
    """A bent sheet with what ``kind`` says, and points around it: (points, vertices, faces)."""
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-30.0, 30.0, cells + 1)], indexing="ij"), axis=-1)
    grid = grid.reshape(-1, 2) + rng.uniform(-0.3, 0.3, (len(grid.reshape(-1, 2)), 2))
    number = np.arange(len(grid)).reshape(cells + 1, cells + 1)
    a, b, c, d = (x.ravel() for x in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = rng.permutation(np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))
    height = (grid**2 @ rng.uniform(-0.01, 0.01, 2)) + grid @ rng.uniform(-0.5, 0.5, 2)
    if kind == "fold":
        for _ in range(rng.integers(1, 4)):
            angle, at = rng.uniform(0.0, np.pi), rng.uniform(-20.0, 20.0)
            height += rng.uniform(-2.0, 2.0) * np.abs(grid @ [np.cos(angle), np.sin(angle)] - at)
    if kind == "bumpy":
        for _ in range(4):
            wave, phase = rng.uniform(-1.5, 1.5, 2), rng.uniform(0.0, 6.0)
            height += rng.uniform(0.1, 1.5) * np.sin(grid @ wave + phase)
    vertices = np.column_stack([grid, height])
    if kind in ("boss", "pit"):
        for _ in range(rng.integers(1, 4)):
            sign = 1.0 if kind == "boss" else -1.0
            centre = vertices[rng.integers(len(vertices))]
            vertices = displaced(vertices, faces, centre, sign * rng.uniform(1.0, 9.0), rng.uniform(1.0, 5.0))
    near = vertices[rng.integers(len(vertices), size=200)]
    points = np.concatenate(
        [
            near + rng.normal(0.0, 4.0, near.shape),
            near + np.array([0.0, 0.0, 3.0]),
            rng.uniform(-40.0, 40.0, (50, 3)),
        ]
    )
    return points, vertices, faces


def worst(points, vertices, faces):
    """Largest error [mm] of the distances to a mold."""
    found = np.abs(Surface(vertices, faces).nearest(points).distance)
    return float(np.abs(found - brute(points, vertices[faces])).max())


def main(count):
    """Print the largest error over ``count`` molds of each kind in turn; fail where one is beyond 1e-9 mm."""
    largest = dict.fromkeys(KINDS, 0.0)
    for seed in range(count):
        kind = KINDS[seed % len(KINDS)]
        largest[kind] = max(largest[kind], worst(*rough_sheet(np.random.default_rng(seed), kind)))
    for kind, error in largest.items():
        print(f"{kind:>6}: {count // len(KINDS)} molds, 450 points each, largest error {error:.1e} mm")
    return int(max(largest.values()) > 1e-9)


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
