"""The textbook's way on the same sheet: Newton's method, SciPy's sparse direct solver, an active contact set.

``direct.py PROBLEM.npz FOUND.npz SECONDS``. One grid, from the same start; a node on the mold moves in the tangent
plane of its facet (on an edge, in the mean one) and is set back on the nearest point. Distances come from hyperfab's
search tree; the rest is NumPy's.
"""

import sys
import time

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from hyperfab.surface import Surface


class Net:
    """Linear springs that push as well as pull."""

    def __init__(self, problem):
        self.a, self.b = problem["springs"].T
        self.rest, self.k = problem["rest"], problem["stiffness"]
        self.free = ~problem["fixed"]

    def forces(self, x):
        way = x[self.b] - x[self.a]
        length = np.linalg.norm(way, axis=1)
        pull = self.k * (length - self.rest)
        f = np.zeros_like(x)
        each = (pull / length)[:, None] * way
        for end, sign in ((self.a, 1.0), (self.b, -1.0)):
            for axis in range(3):
                f[:, axis] += sign * np.bincount(end, each[:, axis], len(x))
        return 0.5 * (pull * (length - self.rest)).sum(), f, np.abs(pull).max()

    def stiffness(self, x):
        way = x[self.b] - x[self.a]
        length = np.linalg.norm(way, axis=1)
        t = way / length[:, None]
        across = np.maximum(self.k * (1.0 - self.rest / length), 1e-6 * self.k)
        block = (self.k - across)[:, None, None] * t[:, :, None] * t[:, None, :]
        block += across[:, None, None] * np.eye(3)
        axes = np.arange(3)
        rows, columns, values = [], [], []
        for p, q, sign in (
            (self.a, self.a, 1.0),
            (self.b, self.b, 1.0),
            (self.a, self.b, -1.0),
            (self.b, self.a, -1.0),
        ):
            rows.append((3 * p[:, None, None] + axes[:, None] + 0 * axes[None, :]).ravel())
            columns.append((3 * q[:, None, None] + 0 * axes[:, None] + axes[None, :]).ravel())
            values.append(sign * block.ravel())
        size = 3 * len(x)
        return csc_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (size, size))


def projector(normal, touching, free):
    """Sparse projector onto what the nodes may do: all, the tangent plane, nothing."""
    n = len(normal)
    blocks = np.eye(3) - touching[:, None, None] * normal[:, :, None] * normal[:, None, :]
    blocks *= free[:, None, None]
    at = 3 * np.arange(n)[:, None, None]
    axes = np.arange(3)
    rows = (at + axes[:, None] + 0 * axes[None, :]).ravel()
    columns = (at + 0 * axes[:, None] + axes[None, :]).ravel()
    return csc_array((blocks.ravel(), (rows, columns)), (3 * n, 3 * n))


def onto(surface, x, touching, free):
    """Nodes inside, and those that touch, on the mold; who touches now, and the normals there."""
    near = surface.nearest(x)
    touching = free & (touching | (near.distance < 0.0))
    x = np.where(touching[:, None], near.point, x)
    return x, touching, surface.feature_normals[near.face, near.feature]


def main():
    path, out, seconds = sys.argv[1:]
    problem = np.load(path)
    net, surface = Net(problem), Surface(problem["vertices"], problem["faces"])
    surface.nearest(problem["x"][:1])  # compiles
    start = time.process_time()
    x, touching, normal = onto(surface, problem["x"], np.zeros(len(problem["x"]), bool), net.free)
    energy, f, strongest = net.forces(x)
    line, best, kept, paused = [], np.inf, x, 0.0
    for _ in range(200):
        touching &= (f * normal).sum(1) <= 1e-9 * strongest
        q = projector(normal, touching, net.free)
        r = q @ f.ravel()
        pause = time.process_time()
        error = np.sqrt(((x - problem["reference"]) ** 2).sum(1).mean())
        line.append((pause - start - paused, error))
        if error < best:
            best, kept = error, x
        paused += time.process_time() - pause
        if np.abs(r).max() <= 1e-10 * strongest or line[-1][0] > float(seconds):
            break
        held = eye_array(len(r), format="csc") - q
        d = (q @ splu(q @ net.stiffness(x) @ q + held).solve(r)).reshape(x.shape)
        alpha, slope = 1.0, float(r @ d.ravel())
        while True:
            trial, touched, normals = onto(surface, x + alpha * d, touching, net.free)
            e, ft, s = net.forces(trial)
            if e <= energy - 1e-4 * alpha * slope + 1e-13 * energy or alpha < 1e-6:
                break
            alpha *= 0.5
        if alpha < 1e-6:
            break
        x, touching, normal, energy, f, strongest = trial, touched, normals, e, ft, s
    np.savez(out, line=line, x=kept)
    import scipy

    print(f"SciPy {scipy.__version__}")


if __name__ == "__main__":
    main()
