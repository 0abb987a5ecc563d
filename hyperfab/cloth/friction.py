"""Coulomb friction of the sheet on the mold, and of its edges under a blank holder.

A node sticks to the place where it stood, or landed, when the load step began while the force along the surface is
below ``mu`` times its normal force; else it slides, and friction has this size and points against the way it slid.
Under the blank holder the largest force is given: its force a unit length times the node's share of the edge. With
the normal forces of the last step of Newton's method friction is the slope of ``sum c |s|``, s the way slid, so that
each step lowers the springs' energy plus what rubbing costs, and the linear systems stay symmetric.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel

from .galerkin import times
from .mold import FREE, States
from .state import State

#: A node that slid less than this share of the spacing still counts as being where it stuck.
STUCK = 1e-5

# How a node rubs: not at all, sticking, just let go, sliding.
NONE, STICKS, STARTS, SLIDES = 0, 1, 2, 3


class Friction(NamedTuple):
    """Friction during one load step.

    mu        coefficient on the mold
    near      mm: STUCK times the spacing
    holder    (n, m) N: largest force of the blank holder on a node
    anchor    (n, m, 3) mm: where each node stood on the mold, or would land, when the step began
    anchored  (n, m) where there is such a place, with its ``contact`` and ``slot`` (n, m)
    """

    mu: float
    near: float
    holder: Array
    anchor: Array
    anchored: npt.NDArray[np.bool_]
    contact: States
    slot: Ints
    stick_slip: States
    most: Array  # (n, m) N, the largest friction
    way: Array  # (n, m, 3) the way slid, of length 1, on an edge also across it; shorter where a node sticks
    slid: Array  # (n, m) mm
    blocked: npt.NDArray[np.bool_]

    @classmethod
    def begun(
        cls,
        mu: float,
        near: float,
        holder: Array,
        anchor: Array,
        anchored: npt.NDArray[np.bool_],
        contact: States,
        slot: Ints,
    ) -> Friction:
        """Return friction of a step in which no node has rubbed yet."""
        n, m = holder.shape
        state = np.zeros((n, m), np.int8), np.zeros((n, m)), np.zeros((n, m, 3)), np.zeros((n, m))
        return cls(mu, near, holder, anchor, anchored, contact, slot, *state, np.zeros((n, m), np.bool_))

    def resist(self, x: Array, contact: States, press: Array, q: Array, r: Array) -> tuple[float, int]:
        """Take friction off the unbalanced forces ``r`` and the directions ``q`` a node can move in.

        Returns the largest unbalanced force left and its node (flat index).
        """
        worst, where = _resist(self, x, contact, press, q, r)
        return worst, where

    def stiffen(self, q: Array, extra: Array) -> None:
        """Add to the nodes' own stiffness that the friction of a sliding node turns with its way."""
        _stiffen(self, q, extra)

    def spent(self, x: Array, trial: State, q: Array) -> float:
        """Work in N mm that rubbing takes, at the present largest forces, on the way from ``x`` to ``trial``.

        Nodes that slid back to where they came from are stopped there, at their anchors.
        """
        _catch(self, trial.x, trial.contact, trial.slot, trial.clear)
        return float(_cost(self, x, trial.x, q))

    def against(self, x: Array) -> Array:
        """(n, m, 3) N: friction on nodes that have slid to ``x``, of the size last found."""
        slid = x - self.anchor
        length = np.linalg.norm(slid, axis=2)
        slides = (self.stick_slip > NONE) & (length >= self.near)
        return np.where(slides, -self.most / np.maximum(length, self.near), 0.0)[:, :, None] * slid

    def forces(self) -> Array:
        """(n, m, 3) N: friction on each node."""
        return np.where((self.stick_slip > NONE)[:, :, None], -self.most[:, :, None] * self.way, 0.0)


@kernel
def _resist(rub: Friction, x: Array, contact: States, press: Array, q: Array, r: Array) -> tuple[float, int]:
    anchor, stick_slip, most, way, slid = rub.anchor, rub.stick_slip, rub.most, rub.way, rub.slid
    n, m = x.shape[0], x.shape[1]
    s = np.empty(3)
    worst, where = 0.0, 0
    for i in range(n):
        for j in range(m):
            v, p = r[i, j], q[i, j]
            size = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            c = rub.holder[i, j]
            if contact[i, j] != FREE:
                c += rub.mu * press[i, j]
            stick_slip[i, j], most[i, j], slid[i, j] = NONE, 0.0, 0.0
            if c > 0.0 and rub.anchored[i, j] and p[0] + p[3] + p[5] > 0.5:
                most[i, j] = c
                a, b, d = (
                    x[i, j, 0] - anchor[i, j, 0],
                    x[i, j, 1] - anchor[i, j, 1],
                    x[i, j, 2] - anchor[i, j, 2],
                )
                s[0], s[1], s[2] = times(p, a, b, d)
                if p[0] + p[3] + p[5] < 1.5:  # on an edge: the way that led onto it counts too
                    s[0], s[1], s[2] = a, b, d
                length = np.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
                if length >= rub.near:
                    stick_slip[i, j], slid[i, j] = SLIDES, length
                    for k in range(3):
                        way[i, j, k] = s[k] / length
                    w = way[i, j]
                    a, b, d = times(p, w[0], w[1], w[2])
                    v[0] -= c * a
                    v[1] -= c * b
                    v[2] -= c * d
                elif size <= c or rub.blocked[i, j]:
                    stick_slip[i, j] = STICKS
                    for k in range(6):
                        p[k] = 0.0
                    excess = max(size - c, 0.0) / size if size > 0.0 else 0.0
                    for k in range(3):
                        way[i, j, k] = (1.0 - excess) * v[k] / c
                        v[k] *= excess
                else:
                    stick_slip[i, j] = STARTS
                    for k in range(3):
                        way[i, j, k] = v[k] / size
                        v[k] *= 1.0 - c / size
                    w = way[i, j]
                    p[0], p[1], p[2] = w[0] * w[0], w[0] * w[1], w[0] * w[2]
                    p[3], p[4], p[5] = w[1] * w[1], w[1] * w[2], w[2] * w[2]
                size = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            elif c > 0.0 and contact[i, j] != FREE:
                stick_slip[i, j] = STICKS  # held by the corner it rests on
            if size > worst:
                worst, where = size, i * m + j
    return worst, where


@kernel
def _stiffen(rub: Friction, q: Array, extra: Array) -> None:
    for i in range(q.shape[0]):
        for j in range(q.shape[1]):
            if rub.stick_slip[i, j] == SLIDES:
                k, w, p, e = rub.most[i, j] / rub.slid[i, j], rub.way[i, j], q[i, j], extra[i, j]
                a, b, d = times(p, w[0], w[1], w[2])
                e[0] += k * (p[0] - a * a)
                e[1] += k * (p[1] - a * b)
                e[2] += k * (p[2] - a * d)
                e[3] += k * (p[3] - b * b)
                e[4] += k * (p[4] - b * d)
                e[5] += k * (p[5] - d * d)


@kernel
def _catch(rub: Friction, x: Array, contact: States, slot: Ints, clear: Array) -> None:
    anchor, stick_slip, way, blocked = rub.anchor, rub.stick_slip, rub.way, rub.blocked
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            blocked[i, j] = False
            if stick_slip[i, j] < STARTS:
                continue
            ahead = 0.0
            for k in range(3):
                ahead += (x[i, j, k] - anchor[i, j, k]) * way[i, j, k]
            if ahead > 0.0:
                continue
            blocked[i, j] = stick_slip[i, j] == STARTS
            for k in range(3):
                x[i, j, k] = anchor[i, j, k]
            contact[i, j], slot[i, j], clear[i, j] = rub.contact[i, j], rub.slot[i, j], 0.0


@kernel
def _cost(rub: Friction, x: Array, trial: Array, q: Array) -> float:
    stick_slip, most, way, slid = rub.stick_slip, rub.most, rub.way, rub.slid
    total = 0.0
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            if stick_slip[i, j] < STARTS:
                continue
            p, w = q[i, j], way[i, j]
            a, b, d = trial[i, j, 0] - x[i, j, 0], trial[i, j, 1] - x[i, j, 1], trial[i, j, 2] - x[i, j, 2]
            u, v, z = times(p, a, b, d)
            u, v, z = slid[i, j] * w[0] + u, slid[i, j] * w[1] + v, slid[i, j] * w[2] + z
            total += most[i, j] * (np.sqrt(u * u + v * v + z * z) - slid[i, j])
    return total
