"""The sheet's energy on a mold with its forces and tangent: straight springs, and those laid over sharp edges."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints

from .bends import farthest, find_bends
from .creases import bend_forces, bend_stiffness, hinge_nodes, unjoin
from .linear import Tangent
from .mold import Mold
from .net import Sheet, forces, stiffness
from .shear import shear_forces, shear_stiffness
from .state import State

ROWS = 200_000  # nodes handled by one call of a kernel that searches the mold
#: A spring's length that changes by this share of its rest length more than its ends move has jumped.
JUMP = 1e-8


class Energy:
    """Energy of a sheet on a mold. What ``forces`` finds out of a place, ``tangent`` builds on."""

    def __init__(self, sheet: Sheet, mold: Mold) -> None:
        self.net = sheet.arrays
        self.directions = 4 if self.net.sheared else 2  # forward neighbours that a node's forces hang on
        self.mold = mold
        self.springs: Ints = np.zeros((0, 4), np.int64)  # laid over edges at the last place
        self.ways: Array = np.zeros((0, 13))
        self.push: Array = np.zeros(3)  # N, of the edges on the sheet
        corners = mold.creases.corners
        self.highest = float(corners[:, :, 2].max()) if len(corners) else -np.inf  # of the sharp edges, mm
        self.reach = farthest(mold.creases)
        self.straight = np.zeros((sheet.n, sheet.m, 2), np.bool_)  # springs not to be laid over edges

    def leave(self, now: State, trial: State, where: int | None = None) -> bool:
        """Leave springs straight from now on whose way around an edge jumps between two places, ``now`` and ``trial``.

        Where edges meet, or beside a curved one, a spring has several ways around that jump from one to the next, and
        no equilibrium may exist. What it then cuts off the mold is part of the penetration reported. ``where``: leave
        the springs of this node (flat index) and its neighbours instead. False where there are none. What the last
        forces found of a place stays.
        """
        near = np.zeros(self.straight.shape, np.bool_)
        if where is None:
            before, after = self._lengths(now), self._lengths(trial)
            moved = np.linalg.norm(trial.x - now.x, axis=2)
            room = np.zeros(near.shape)
            room[:-1, :, 0], room[:, :-1, 1] = moved[1:] + moved[:-1], moved[:, 1:] + moved[:, :-1]
            near = np.abs(after - before) > 2.0 * room + JUMP * float(self.net.rest.max())
        else:
            i, j = divmod(where, near.shape[1])
            near[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2] = True
            springs, _ = self._found(now.x, now.clear)
            laid = np.zeros(near.shape, np.bool_)
            laid[springs[:, 0], springs[:, 1], springs[:, 2]] = True
            near &= laid
        near &= ~self.straight
        self.straight |= near
        return bool(near.any())

    def _lengths(self, at: State) -> Array:
        """(n, m, 2) mm: all springs, bent ones along their ways."""
        out = np.zeros(self.straight.shape)
        out[:-1, :, 0] = np.linalg.norm(np.diff(at.x, axis=0), axis=2)
        out[:, :-1, 1] = np.linalg.norm(np.diff(at.x, axis=1), axis=2)
        springs, ways = self._found(at.x, at.clear)
        out[springs[:, 0], springs[:, 1], springs[:, 2]] = ways[:, 12]
        return out

    def forces(self, x: Array, clear: Array, f: Array) -> tuple[float, float]:
        """Forces on the nodes at x into ``f``; (energy N mm, largest spring force N)."""
        energy, largest = forces(x, self.net, f)
        if self.net.sheared:
            energy += shear_forces(x, self.net, f)
        self._lay(x, clear)
        if not len(self.springs):
            return energy, largest
        change, bent = bend_forces(x, self.net, self.springs, self.ways, f, self.push)
        return energy + change, max(largest, bent)

    def _lay(self, x: Array, clear: Array) -> None:
        self.push = np.zeros(3)
        self.springs, self.ways = self._found(x, clear)

    def _found(self, x: Array, clear: Array) -> tuple[Ints, Array]:
        """Springs that are bent at a place, and their ways."""
        room = max(256, 2 * len(self.springs))
        springs, ways = np.empty((room, 4), np.int64), np.empty((room, 13))
        if x[:, :, 2].min() > self.highest:  # no spring reaches down to a sharp edge
            return springs[:0], ways[:0]
        n, m = x.shape[:2]
        rows = max(1, ROWS // m)
        while True:
            found = 0
            for i in range(0, n, rows):
                found = find_bends(
                    x, clear, self.mold, self.straight, self.reach, springs, ways, i, min(i + rows, n), found
                )
            if found <= room:
                return springs[:found], ways[:found]
            room = found
            springs, ways = np.empty((room, 4), np.int64), np.empty((room, 13))

    def over(self, x: Array) -> Array:
        """(k, 3) mm: where the bent springs run over their edges."""
        w = self.ways
        share = w[:, 9] / np.maximum(w[:, 9] + w[:, 10], 1e-300) * w[:, 11]
        start = x[self.springs[:, 0], self.springs[:, 1]]
        return np.asarray(start + w[:, 9:10] * w[:, :3] + share[:, None] * w[:, 6:9])

    def hinges(self) -> Ints:
        """(n, m, 2) bent springs of each node as ``hinge_nodes`` numbers them."""
        found = np.zeros((*self.net.weight.shape, 2) if len(self.springs) else (0, 0, 2), np.int64)
        if len(self.springs):
            hinge_nodes(self.springs, found)
        return found

    def tangent(self, x: Array, floor: float, out: Tangent) -> None:
        """Tangent at x, where ``forces`` was called last; slack springs keep the stiffness ``floor`` N/mm."""
        stiffness(x, self.net, floor, out.diag, out.off)
        if len(self.springs):
            unjoin(self.springs, out.diag, out.off)
            bend_stiffness(self.net, self.springs, self.ways, floor, out.diag, out.off)
        if self.net.sheared:
            shear_stiffness(x, self.net, out.diag, out.off)
