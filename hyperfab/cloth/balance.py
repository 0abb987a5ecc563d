"""The balance of forces on a sheet at a place: contact decided, residual found. What every solver asks at each step."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.threads import in_rows

from .contact import Laid, move, settle
from .friction import Friction
from .membrane import energy_of
from .mirror import mean, mirrors, reflect
from .mold import Mold
from .net import Sheet
from .state import Equilibrium, State, Step

#: Springs whose forces stay below their section's stiffness times this are unstretched but for rounding.
RELAXED = 1e-8
#: A node's unbalanced force is rounding below the stiffest spring's stiffness times this share of the sheet's size.
ROUNDED = 4.0 * float(np.finfo(float).eps)


class Balance:
    """Forces ``f``, projectors ``q`` on the allowed subspaces, unbalanced forces ``r`` and contact forces ``press``.

    A node is let go by the mold when pulled off it by more than a thousandth of ``tolerance`` (relative). ``even``:
    where sheet and mold are their own mirror image, so is what is sought.
    """

    def __init__(self, sheet: Sheet, mold: Mold, tolerance: float, even: bool = True) -> None:
        n, m = sheet.n, sheet.m
        self.size, self.fixed, self.tolerance = (n, m), sheet.fixed, tolerance
        self.model = energy_of(sheet, mold)
        self.f: Array = np.zeros((n, m, 3))
        self.r: Array = np.zeros((n, m, 3))
        self.q: Array = np.zeros((n, m, 6))
        self.press: Array = np.zeros((n, m))
        self.before: Ints = np.full((n, m), -1)  # facet of each node before its last step
        self.stiffness = stiffness_scale(sheet)
        # What a sheet that only just touches the mold is measured by: its own forces are rounding.
        relaxed = RELAXED * sheet.skew * float(self.model.net.rest.max())
        self.unstretched = self.stiffness * max(relaxed, ROUNDED * max(sheet.size) / tolerance)
        self.mirrors = mirrors(sheet, mold) if even else ()
        self._free = sheet.fixed
        for axis in self.mirrors:
            if self.size[axis] % 2:  # the nodes in the plane stay in it
                np.moveaxis(self.fixed, axis, 0)[self.size[axis] // 2] |= np.uint8(1 << axis)
        self.energy, self.strongest = 0.0, 0.0
        self.worst, self.where, self.contacts, self.released = 0.0, 0, 0, 0

    @property
    def residual(self) -> float:
        """Largest unbalanced nodal force over the largest spring force."""
        return self.worst / max(self.strongest, self.unstretched)

    @property
    def rounding(self) -> float:
        """Energy in N mm below which a difference means nothing."""
        return 1e-9 * abs(self.energy) + self.unstretched * float(self.model.net.rest.max())

    def forces(self, now: State) -> None:
        """Find the energy and the forces."""
        self.energy, self.strongest = self.found(now, self.f)

    def found(self, at: State, f: Array) -> tuple[float, float]:
        """Energy and largest spring force at a place, and into ``f`` the forces."""
        energy, strongest = self.model.forces(at.x, at.clear, f)
        for axis in self.mirrors:
            mean(f, axis)
            self.model.push[axis] = 0.0
        return energy, strongest

    def even(self, now: State) -> None:
        """Let nodes follow their images where sheet and mold are their own mirror image."""
        for axis in self.mirrors:
            reflect(now, axis, self.model.mold, self.fixed)

    def lean(self) -> None:
        """Seek shapes that are not even from now on."""
        self.mirrors, self.fixed = (), self._free

    def settle(self, now: State, friction: Friction | None = None) -> None:
        """Decide the contact of every node under the forces; nodes put onto a valley or off an edge change them."""
        self.released = 0
        while True:
            released, moved = self._settled(now, self.f if friction is None else self.f + friction.against(now.x))
            self.released += released
            if not moved:
                return
            self.forces(now)

    def _settled(self, now: State, rubbed: Array) -> tuple[int, int]:
        """Decide the contact once: how many nodes were let go, and how many moved."""
        n, m = self.size
        mold, found = self.model.mold, {}
        given = (mold, self.model.net, self.laid(), self.fixed, 1e-3 * self.tolerance * self.strongest)

        def work(first: int, last: int) -> None:
            found[first] = settle(now, self.f, rubbed, *given, self.before, self.q, self.r, self.press, first, last)

        # A node that is put beside a sharp edge changes the pull on the next.
        if len(mold.creases.corners):
            work(0, n)
        else:
            in_rows(work, n, m)
        parts = [found[first] for first in sorted(found)]
        self.worst, self.where = max(((part[0], part[1]) for part in parts), key=lambda one: one[0])
        self.contacts, released, moved = (sum(part[k] for part in parts) for k in (2, 3, 4))
        return released, moved

    def laid(self) -> Laid:
        """Springs laid over sharp edges at the place of the last forces, their ways, and those of each node."""
        return Laid(self.model.springs, self.model.ways, self.model.hinges())

    def move(self, now: State, d: Array, alpha: float, out: State, laid: Laid | None = None) -> None:
        """``out`` = nodes at ``now.x + alpha d``, back on the mold where they touch it; ``laid`` as at ``now``."""
        laid, mold = laid or self.laid(), self.model.mold
        in_rows(lambda first, last: move(now, d, alpha, mold, out, laid, first, last), *self.size)
        self.even(out)

    def line(self, iteration: int, alpha: float = 1.0, inner: int = 0) -> Step:
        """A line of the history."""
        return Step(
            self.size,
            iteration,
            self.energy,
            self.residual,
            self.contacts,
            alpha,
            inner,
            self.released > 0,
        )

    def ended(self, now: State, status: str, history: list[Step]) -> Equilibrium:
        """The end of a solve at ``now``, converged where ``status`` is empty."""
        return Equilibrium(
            now,
            not status,
            self.energy,
            self.worst,
            self.residual,
            divmod(self.where, self.size[1]),
            self.press,
            self.f,
            self.r,
            self.model.springs,
            self.model.ways[:, 12],
            self.model.over(now.x),
            self.model.push,
            status,
            history,
        )


def stiffness_scale(sheet: Sheet) -> float:
    """Stiffness of the stiffest spring at rest, N/mm."""
    net = sheet.arrays
    warp, weft = sheet.warp(1.0 + 1e-9)[2][0], sheet.weft(1.0 + 1e-9)[2][0]
    return float(max(warp * net.warp_area.max() / net.rest[0], weft * net.weft_area.max() / net.rest[1]))
