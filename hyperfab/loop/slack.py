"""A sheet mounted slack, told by one that bears at once: pushed less deep, it is stretched alike."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array
from hyperfab.membrane.punch import Sphere

#: Depths the way over the punch is known at, and how far beyond the deepest: where depth is counted from may move.
_GRID, _BEYOND = 400, 1.25
#: How much of its greatest depth a slack sheet is to be stretched over at least, and the most it may be slack by.
_BEARS, _MOST = 0.5, 0.06


@dataclass(frozen=True)
class Slack:
    """The ways from the highest point of a ball of ``radius`` to the nearest of the rim, ``reach`` away, at depths up
    to the ``deepest`` [mm].

    A slack sheet bears from the depth on at which that way is as long as the sheet is there. Its force over depth has a
    bend there that moves as it is slacker; over the depth at which a sheet without slack is stretched as much it has
    none. It is told over that, in parts of its own greatest one.
    """

    radius: float
    reach: float
    deepest: float

    @cached_property
    def _ways(self) -> tuple[Array, Array]:
        """Squares of depths, and the ways there: these go with those as soon as the sheet bears."""
        depth = np.linspace(0.0, _BEYOND * self.deepest, _GRID)
        ball = Sphere(self.radius)
        return depth**2, np.array([ball.way(self.reach, float(one)) for one in depth])

    def over(self, larger: float) -> Slack:
        """Return the same of a ball so much larger [mm]."""
        return replace(self, radius=self.radius + larger) if larger else self

    @property
    def most(self) -> float:
        """How slack a sheet may be at most."""
        squares, ways = self._ways
        least, whole = np.interp(np.square([_BEARS * self.deepest, self.deepest]), squares, ways)
        return max(min(1.0 - float(least / whole), _MOST), 0.0)

    def taut(self, depth: Array, added: float) -> Array:
        """Return the depths (m,) at which a sheet that bears at once is stretched as one slack by ``added``, below 0,
        is at ``depth`` (m,).

        >>> slack = Slack(40.0, 100.0, 50.0)
        >>> slack.taut(np.array([10.0, 25.0, 50.0]), -0.03).round(2).tolist()
        [0.0, 4.17, 42.59]
        """
        if added >= 0.0:
            return depth
        squares, ways = self._ways
        here = np.interp(np.square(np.maximum(depth, 0.0)), squares, ways)
        return np.asarray(np.sqrt(np.interp((1.0 + added) * here, ways, squares)))

    def knots(self, depth: Array, added: float) -> Array:
        """Return where among knots depths (m,) lie: the greatest depth is the greatest knot, whatever the slack."""
        if added >= 0.0:
            return depth
        greatest = float(self.taut(np.array([self.deepest]), added)[0])
        return np.asarray(self.taut(depth, added) * (self.deepest / greatest))

    def depths(self, knots: Array, added: float) -> Array:
        """Return the depths (k,) of knots (k,).

        >>> slack = Slack(40.0, 100.0, 50.0)
        >>> bool(np.allclose(slack.knots(slack.depths(np.array([5.0, 50.0]), -0.04), -0.04), [5.0, 50.0], rtol=1e-4))
        True
        """
        if added >= 0.0:
            return knots
        squares, ways = self._ways
        greatest = float(self.taut(np.array([self.deepest]), added)[0])
        way = np.interp(np.square(knots * (greatest / self.deepest)), squares, ways) / (1.0 + added)
        return np.asarray(np.sqrt(np.interp(way, ways, squares)))
