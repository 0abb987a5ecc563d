"""The sheet's energy on a mold with its forces and tangent: straight springs, and those laid over sharp edges."""

from __future__ import annotations

import numpy as np

from .creases import bend_forces, bend_stiffness, hinge_nodes
from .law import Floats
from .laying import find_bends
from .linear import Tangent
from .mold import Ints, Mold
from .net import Sheet, forces, stiffness

ROWS = 200_000  # nodes handled by one call of a kernel that searches the mold


class Energy:
    """Energy of a sheet on a mold. What ``forces`` finds out of a place, ``tangent`` builds on."""

    def __init__(self, sheet: Sheet, mold: Mold) -> None:
        self.net = sheet.arrays
        self.mold = mold
        self.springs: Ints = np.zeros((0, 4), np.int64)  # laid over edges at the last place
        self.ways: Floats = np.zeros((0, 13))
        self.push: Floats = np.zeros(3)  # N, of the edges on the sheet
        corners = mold.creases.corners
        self.highest = float(corners[:, :, 2].max()) if len(corners) else -np.inf  # of the sharp edges, mm
        self.straight = np.zeros((sheet.n, sheet.m, 2), np.bool_)  # springs not to be laid over edges

    def leave_corners(self, x: Floats) -> bool:
        """Leave the springs near corners of several sharp edges straight from now on; False where that is done or none.

        There a spring has ways around the corner that jump from one edge to another, and no equilibrium may exist.
        What it then cuts off the corner is part of the penetration reported.
        """
        creases = self.mold.creases
        corners = creases.corners[:, :2][(creases.meeting >= 0).any(2)]
        if not len(corners) or self.straight.any():
            return False
        reach = 3.0 * float(self.net.rest[:2].max())
        near = np.zeros(x.shape[:2], np.bool_)
        for corner in np.unique(corners, axis=0):
            near |= ((x - corner) ** 2).sum(2) < reach**2
        self.straight[:] = near[:, :, None]
        self.straight[:-1, :, 0] |= near[1:]
        self.straight[:, :-1, 1] |= near[:, 1:]
        return bool(near.any())

    def forces(self, x: Floats, clear: Floats, f: Floats) -> tuple[float, float]:
        """Forces on the nodes at x into ``f``; (energy N mm, largest spring force N)."""
        energy, largest = forces(x, self.net, f)
        self.push = np.zeros(3)
        if x[:, :, 2].min() > self.highest:  # no spring reaches down to a sharp edge
            self.springs, self.ways = self.springs[:0], self.ways[:0]
            return energy, largest
        self._lay(x, clear)
        if not len(self.springs):
            return energy, largest
        change, bent = bend_forces(x, self.net, self.springs, self.ways, f, self.push)
        return energy + change, max(largest, bent)

    def _lay(self, x: Floats, clear: Floats) -> None:
        n, m = x.shape[:2]
        room = max(256, 2 * len(self.springs))
        rows = max(1, ROWS // m)
        while True:
            springs, ways, found = np.empty((room, 4), np.int64), np.empty((room, 13)), 0
            for i in range(0, n, rows):
                found = find_bends(
                    x, clear, self.mold.creases, self.straight, springs, ways, i, min(i + rows, n), found
                )
            if found <= room:
                break
            room = found
        self.springs, self.ways = springs[:found], ways[:found]

    def hinges(self) -> Ints:
        """(n, m, 2) bent springs of each node as ``hinge_nodes`` numbers them."""
        found = np.zeros((*self.net.weight.shape, 2) if len(self.springs) else (0, 0, 2), np.int64)
        if len(self.springs):
            hinge_nodes(self.springs, found)
        return found

    def tangent(self, x: Floats, floor: float, out: Tangent) -> None:
        """Tangent at x, where ``forces`` was called last; slack springs keep the stiffness ``floor`` N/mm."""
        stiffness(x, self.net, floor, *out.blocks)
        out.extra[:] = 0.0
        out.springs, out.coupling = self.springs, np.empty((len(self.springs), 9))
        if len(self.springs):
            bend_stiffness(
                self.net, self.springs, self.ways, floor, out.warp, out.weft, out.extra, out.coupling
            )
