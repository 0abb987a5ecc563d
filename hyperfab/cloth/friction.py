"""Coulomb friction of the sheet on the mold, and of its edges under a blank holder.

A node sticks to the place where it stood, or landed, when the load step began while the force along the surface is
below ``mu`` times its normal force; else it slides, and friction has this size and points against the way it slid.
Under the blank holder the largest force is given: its force a unit length times the node's share of the edge. With
the normal forces of the last step of Newton's method friction is the slope of ``sum c |s|``, s the way slid, so that
each step lowers the springs' energy plus what rubbing costs, and the linear systems stay symmetric.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel

from .mold import FREE, States

#: A node that slid less than this share of the spacing still counts as being where it stuck.
STUCK = 1e-5

# How a node rubs: not at all, sticking, just let go, sliding.
NONE, STICKS, STARTS, SLIDES = 0, 1, 2, 3


@dataclass
class Friction:
    """Friction during one load step.

    ``anchor`` (n, m, 3) mm: where each node stood on the mold, or would land, when the step began, with its
    ``contact`` and ``slot``; ``anchored`` (n, m) where there is such a place. ``holder`` (n, m) N: largest force of
    the blank holder on a node. ``near`` mm: STUCK times the spacing.
    """

    mu: float
    holder: Array
    anchor: Array
    anchored: npt.NDArray[np.bool_]
    contact: States
    slot: Ints
    near: float
    stick_slip: States = field(init=False)
    most: Array = field(init=False)  # (n, m) N, the largest friction
    way: Array = field(init=False)  # (n, m, 3) the way slid, of length 1; shorter where a node sticks
    slid: Array = field(init=False)  # (n, m) mm
    blocked: npt.NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        n, m = self.holder.shape
        self.stick_slip, self.most = np.zeros((n, m), np.int8), np.zeros((n, m))
        self.way, self.slid = np.zeros((n, m, 3)), np.zeros((n, m))
        self.blocked = np.zeros((n, m), np.bool_)

    def resist(self, x: Array, contact: States, press: Array, q: Array, r: Array) -> tuple[float, int]:
        """Take friction off the unbalanced forces ``r`` and the directions ``q`` a node can move in.

        Returns the largest unbalanced force left and its node (flat index).
        """
        return _resist(
            x,
            contact,
            press,
            self.mu,
            self.holder,
            self.anchor,
            self.anchored,
            self.near,
            self.blocked,
            q,
            r,
            self.stick_slip,
            self.most,
            self.way,
            self.slid,
        )

    def stiffen(self, q: Array, extra: Array) -> None:
        """Add to the nodes' own stiffness that the friction of a sliding node turns with its way."""
        _stiffen(q, self.stick_slip, self.most, self.way, self.slid, extra)

    def catch(self, x: Array, contact: States, slot: Ints, clear: Array) -> bool:
        """Stop nodes at their anchors that slid back to where they came from; True where there are such."""
        return bool(
            _catch(
                x,
                contact,
                slot,
                clear,
                self.anchor,
                self.contact,
                self.slot,
                self.stick_slip,
                self.way,
                self.blocked,
            )
        )

    def cost(self, x: Array, trial: Array, q: Array) -> float:
        """Work in N mm that rubbing takes, at the present largest forces, on the way from ``x`` to ``trial``."""
        return float(_cost(x, trial, q, self.stick_slip, self.most, self.way, self.slid))

    def forces(self) -> Array:
        """(n, m, 3) N: friction on each node."""
        return np.where((self.stick_slip > NONE)[:, :, None], -self.most[:, :, None] * self.way, 0.0)


@kernel
def _resist(
    x: Array,
    contact: States,
    press: Array,
    mu: float,
    holder: Array,
    anchor: Array,
    anchored: npt.NDArray[np.bool_],
    near: float,
    blocked: npt.NDArray[np.bool_],
    q: Array,
    r: Array,
    stick_slip: States,
    most: Array,
    way: Array,
    slid: Array,
) -> tuple[float, int]:
    n, m = x.shape[0], x.shape[1]
    s = np.empty(3)
    worst, where = 0.0, 0
    for i in range(n):
        for j in range(m):
            v, p = r[i, j], q[i, j]
            size = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            c = holder[i, j]
            if contact[i, j] != FREE:
                c += mu * press[i, j]
            stick_slip[i, j], most[i, j], slid[i, j] = NONE, 0.0, 0.0
            if c > 0.0 and anchored[i, j] and p[0] + p[3] + p[5] > 0.5:
                most[i, j] = c
                a, b, d = (
                    x[i, j, 0] - anchor[i, j, 0],
                    x[i, j, 1] - anchor[i, j, 1],
                    x[i, j, 2] - anchor[i, j, 2],
                )
                s[0] = p[0] * a + p[1] * b + p[2] * d
                s[1] = p[1] * a + p[3] * b + p[4] * d
                s[2] = p[2] * a + p[4] * b + p[5] * d
                length = np.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
                if length >= near:
                    stick_slip[i, j], slid[i, j] = SLIDES, length
                    for k in range(3):
                        way[i, j, k] = s[k] / length
                        v[k] -= c * way[i, j, k]
                elif size <= c or blocked[i, j]:
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
def _stiffen(q: Array, stick_slip: States, most: Array, way: Array, slid: Array, extra: Array) -> None:
    for i in range(q.shape[0]):
        for j in range(q.shape[1]):
            if stick_slip[i, j] == SLIDES:
                k, w, p, e = most[i, j] / slid[i, j], way[i, j], q[i, j], extra[i, j]
                e[0] += k * (p[0] - w[0] * w[0])
                e[1] += k * (p[1] - w[0] * w[1])
                e[2] += k * (p[2] - w[0] * w[2])
                e[3] += k * (p[3] - w[1] * w[1])
                e[4] += k * (p[4] - w[1] * w[2])
                e[5] += k * (p[5] - w[2] * w[2])


@kernel
def _catch(
    x: Array,
    contact: States,
    slot: Ints,
    clear: Array,
    anchor: Array,
    anchor_contact: States,
    anchor_slot: Ints,
    stick_slip: States,
    way: Array,
    blocked: npt.NDArray[np.bool_],
) -> bool:
    caught = False
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
            caught = caught or blocked[i, j]
            for k in range(3):
                x[i, j, k] = anchor[i, j, k]
            contact[i, j], slot[i, j], clear[i, j] = anchor_contact[i, j], anchor_slot[i, j], 0.0
    return caught


@kernel
def _cost(
    x: Array, trial: Array, q: Array, stick_slip: States, most: Array, way: Array, slid: Array
) -> float:
    total = 0.0
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            if stick_slip[i, j] < STARTS:
                continue
            p, w = q[i, j], way[i, j]
            a, b, d = trial[i, j, 0] - x[i, j, 0], trial[i, j, 1] - x[i, j, 1], trial[i, j, 2] - x[i, j, 2]
            u = slid[i, j] * w[0] + p[0] * a + p[1] * b + p[2] * d
            v = slid[i, j] * w[1] + p[1] * a + p[3] * b + p[4] * d
            z = slid[i, j] * w[2] + p[2] * a + p[4] * b + p[5] * d
            total += most[i, j] * (np.sqrt(u * u + v * v + z * z) - slid[i, j])
    return total
