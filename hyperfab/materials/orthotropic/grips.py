"""A short strip held in grips: how much stiffer it answers than one that is free to contract and shear all along.

At the grips the strip keeps its width and its right angles, and where it is cut at a slant it wants to shear: a strip
shorter than twice its width has no part that the grips leave alone (the threads from both of them cross; a bias
extension test asks for 2 : 1 and more). The grips stay parallel and may shift sideways. The displacement is a
polynomial that vanishes at the grips (Ritz), the energy least: the answer comes from above as its degree grows.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import PchipInterpolator

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.materials.orthotropic.energy import Orthotropic
from hyperfab.materials.orthotropic.specimen import Frame, strip

#: Strips shorter than this many widths are nowhere free of their grips.
SHORT = 2.0
#: Polynomials each way; with 10 the load falls by less than 0.5 %, and then by nothing to speak of.
_DEGREE = 8
_POINTS = 10
_STEPS = 60
_CLOSED = 1e-9


#: Stretches where the answer of the grips is found; it is smooth between them.
_NODES = 9


def at_readings(law: Orthotropic, angle_deg: float | None, aspect: float | None, stretch: Array) -> Array:
    """Return how many times the load of a uniform strip a specimen takes at ``stretch`` (n,).

    It is 1 where grips count little: they do where it is cut at a slant and shorter than ``SHORT`` widths. Raises
    InputError where it has no equilibrium.
    """
    if aspect is None or angle_deg is None or aspect >= SHORT or angle_deg % 90.0 == 0.0:
        return np.ones(len(stretch))
    high = float(stretch.max())
    if not high > 1.0:
        return np.ones(len(stretch))
    nodes = 1.0 + (high - 1.0) * np.linspace(0.05, 1.0, _NODES)
    factor = stiffening(law, angle_deg, aspect, nodes)
    found = np.isfinite(factor)
    if not found.any():
        raise InputError(
            f"a strip {aspect:.2g} times as long as wide, cut at {angle_deg:g} deg, finds no equilibrium in its grips",
            remedy="give its stretch as measured away from the grips (a column stretch), or a longer strip",
        )
    if found.sum() == 1:
        return np.full(len(stretch), factor[found][0])
    known = nodes[found]
    return np.asarray(PchipInterpolator(known, factor[found])(np.clip(stretch, known[0], known[-1])))


def stiffening(law: Orthotropic, angle_deg: float, aspect: float, stretch: Array) -> Array:
    """Return how many times the load (n,) of a uniform strip one held in grips takes, pulled to ``stretch`` (n,).

    ``aspect`` is its length over its width. No number where no equilibrium is found.

    >>> rubber = Orthotropic.of({"C10_MPa": 0.2, "nu": 0.0})
    >>> stiffening(rubber, 45.0, 1.0, np.array([1.1])).round(6)
    array([1.])
    """
    lam = np.asarray(stretch, dtype=np.float64)
    shapes, weights = _shapes(aspect)
    frame = Frame.at(np.full(lam.size * len(weights), angle_deg))
    sides = np.stack([frame.tt, frame.nn, frame.tn], axis=1)[: len(weights)]

    def at(a: Array, rows: Ints) -> tuple[Array, Array, Array, Array]:
        """Energy (k,), its slopes (k, dofs), its curvature (k, dofs, dofs), and its slope by the stretch (k,)."""
        h = np.einsum("qid,kd->kqi", shapes, a)
        long, thin, slip, wide = lam[rows, None] + h[..., 0], h[..., 1], h[..., 2], 1.0 + h[..., 3]
        metric = [long**2 + slip**2, thin**2 + wide**2, long * thin + slip * wide]
        part = Frame(*(np.tile(axis, (len(rows), 1)) for axis in np.moveaxis(sides, 1, 0)))
        found = law.answer(part.strain(*(one.ravel() for one in metric)))
        sigma = 0.5 * np.einsum("qij,kqj->kqi", sides, found.stress.reshape(len(rows), -1, 3))
        moduli = found.stiffness.reshape(len(rows), -1, 3, 3)
        D = 0.25 * np.einsum("qij,kqjl,qml->kqim", sides, moduli, sides)
        B = np.zeros((*long.shape, 3, 4))
        B[..., 0, 0], B[..., 0, 2] = 2.0 * long, 2.0 * slip
        B[..., 1, 1], B[..., 1, 3] = 2.0 * thin, 2.0 * wide
        B[..., 2, 0], B[..., 2, 1], B[..., 2, 2], B[..., 2, 3] = thin, long, wide, slip
        H = np.einsum("kqai,kqab,kqbj->kqij", B, D, B)
        for one, i, j in ((0, 0, 0), (0, 2, 2), (1, 1, 1), (1, 3, 3)):
            H[..., i, j] += 2.0 * sigma[..., one]
        for i, j in ((0, 1), (1, 0), (2, 3), (3, 2)):
            H[..., i, j] += sigma[..., 2]
        slope = np.einsum("kqa,kqai->kqi", sigma, B)
        energy = found.energy.reshape(len(rows), -1) @ weights
        bent = np.einsum("qid,kqij,qje,q->kde", shapes, H, shapes, weights, optimize=True)
        pull = (sigma[..., 0] * 2.0 * long + sigma[..., 2] * thin) @ weights
        return energy, np.einsum("qid,kqi,q->kd", shapes, slope, weights), bent, pull

    free = strip(law, angle_deg, lam)
    stiff = float(np.abs(free.answer.stiffness).max())
    a = np.zeros((lam.size, shapes.shape[2]))
    every = np.arange(lam.size)
    energy, slope, bent, pull = at(a, every)
    open_ = every
    for _ in range(_STEPS):
        size = np.abs(pull[open_]) + 1e-3 * np.abs(bent[open_]).max(axis=(1, 2))
        open_ = open_[~(np.abs(slope[open_]).max(axis=1) <= _CLOSED * size)]
        if not len(open_):
            break
        values, vectors = np.linalg.eigh(bent[open_])
        values = np.maximum(np.abs(values), 1e-9 * np.abs(values).max(axis=1, keepdims=True))
        step = -np.einsum("kij,kj,klj,kl->ki", vectors, 1.0 / values, vectors, slope[open_])
        pending, length = np.arange(len(open_)), 1.0
        start = a[open_].copy()
        for _ in range(25):
            rows = open_[pending]
            with np.errstate(all="ignore"):
                trial = start[pending] + length * step[pending]
                got = at(trial, rows)
            # Near the least energy it is flat to rounding: there less force on the shapes counts.
            flat = np.abs(got[0] - energy[rows]) <= 1e-9 * np.abs(energy[rows]) + 1e-15 * stiff
            less = np.abs(got[1]).max(axis=1) < np.abs(slope[rows]).max(axis=1)
            fine = (got[0] < energy[rows]) | (flat & less)
            taken = rows[fine]
            a[taken] = trial[fine]
            for old, new in zip((energy, slope, bent, pull), got, strict=True):
                old[taken] = new[fine]
            pending, length = pending[~fine], 0.5 * length
            if not len(pending):
                break
    done = np.ones(lam.size, dtype=bool)
    done[open_] = False
    return np.asarray(np.where(done & free.closed, pull / free.stress, np.nan))


@cache
def _shapes(aspect: float) -> tuple[Array, Array]:
    """Return the slopes (points, 4, dofs) of the displacement's shapes and the points' weights, over half the strip.

    Slopes are u,x u,y v,x v,y of the displacement (u, v) along and across, where the strip is ``aspect`` long and 1
    wide. A half turn leaves the strip as it is, so that u and v are odd.
    """
    points, share = legendre.leggauss(_POINTS)
    half = points > 0.0
    x, y = (one.ravel() for one in np.meshgrid(points, points[half], indexing="ij"))
    weights = 0.5 * np.outer(share, share[half]).ravel()
    unit = np.eye(_DEGREE)
    pairs = [(i, j) for i in range(_DEGREE) for j in range(_DEGREE) if (i + j) % 2]
    shapes = np.zeros((len(x), 4, 2 * len(pairs) + 1))
    for k, (i, j) in enumerate(pairs):
        # (1 - x^2) P_i
        bubble = legendre.legmul([2.0 / 3.0, 0.0, -2.0 / 3.0], unit[i])
        along, across = legendre.legval(x, bubble), legendre.legval(y, unit[j])
        dx = legendre.legval(x, legendre.legder(bubble)) * 2.0 / aspect * across
        dy = along * legendre.legval(y, legendre.legder(unit[j])) * 2.0
        shapes[:, 0, 2 * k], shapes[:, 1, 2 * k] = dx, dy
        shapes[:, 2, 2 * k + 1], shapes[:, 3, 2 * k + 1] = dx, dy
    shapes[:, 2, -1] = 1.0
    return shapes, weights
