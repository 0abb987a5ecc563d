"""Drucker stability of a sheet's law in all directions of its plane."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array
from hyperfab.materials.orthotropic.energy import Answer


def least_modulus(own: Answer, C: Array) -> Array:
    """Return the least over the largest eigenvalue (n,) of the moduli of the Kirchhoff stress's Jaumann rate.

    ``own`` is the law's answer at C11, C22, C12 (n, 3). Negative where more strain in some direction of the plane
    takes less stress (Drucker); not a number where the law has none.
    """
    angle = 0.5 * np.arctan2(2.0 * C[:, 2], C[:, 0] - C[:, 1])
    mean, radius = 0.5 * (C[:, 0] + C[:, 1]), np.hypot(0.5 * (C[:, 0] - C[:, 1]), C[:, 2])
    c1 = mean + radius
    c2 = np.maximum((C[:, 0] * C[:, 1] - C[:, 2] ** 2) / c1, 1e-12)
    l1, l2 = np.sqrt(c1), np.sqrt(c2)
    cos2, sin2 = np.cos(2.0 * angle), np.sin(2.0 * angle)
    cc, ss, cs = 0.5 * (1.0 + cos2), 0.5 * (1.0 - cos2), 0.5 * sin2
    one, two = np.stack([cc, ss, 2.0 * cs], axis=1), np.stack([ss, cc, -2.0 * cs], axis=1)
    both = np.stack([-2.0 * cs, 2.0 * cs, 2.0 * cos2], axis=1)
    T = np.stack([one * c1[:, None], two * c2[:, None], 0.5 * both * (l1 * l2)[:, None]], axis=1)
    t = np.einsum("nij,nj->ni", T, own.stress)
    M = np.einsum("nij,njk,nlk->nil", T, own.stiffness, T)
    # The Jaumann rate adds half of delta tau in all its symmetries.
    M[:, 0, 0] += 2.0 * t[:, 0]
    M[:, 1, 1] += 2.0 * t[:, 1]
    M[:, 2, 2] += 0.5 * (t[:, 0] + t[:, 1])
    M[:, 0, 2] += t[:, 2]
    M[:, 2, 0] += t[:, 2]
    M[:, 1, 2] += t[:, 2]
    M[:, 2, 1] += t[:, 2]
    finite = np.isfinite(M).all(axis=(1, 2))
    values = np.linalg.eigvalsh(np.where(finite[:, None, None], M, np.eye(3)))
    largest = np.abs(values).max(axis=1)
    return np.where(finite, values[:, 0] / np.where(largest > 0.0, largest, 1.0), np.nan)
