"""A sheet of any symmetry that carries no compression: the relaxed energy of its law.

A thin sheet gives up width in fine wrinkles at no cost. With n the direction across the wrinkles in the undeformed
sheet and a >= 0 what they take up, it stores

    W*(C) = min over a, n of W(C + a n n)

(Pipkin, IMA J. Appl. Math. 36 (1986) 85; Steigmann, Proc. R. Soc. Lond. A 429 (1990) 141). At the minimum the law's
stress at C + a n n has no part on n. Where no direction is stretched the sheet is slack; where the law's own stress is
nowhere compression nothing is given up. For an isotropic law n lies along the smaller stretch, in general it turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.materials.orthotropic.energy import Answer, least_modulus
from hyperfab.membrane.tension_field import SLACK, WRINKLED, Principal, Response, principal_directions

#: Stress on n, over the larger stress of the sheet, that counts as none.
_CLOSED = 1e-11
#: And what is left of it at most where rounding lets no step lower the energy.
_NEARLY = 1e-7
_STEPS = 50
#: A strain no larger than this is rounding.
_RESTING = 1e-12
#: Rounding of energy and stress, over a modulus: what a law sums are terms of that size, however little is strained.
_ROUNDING = 1e-15
#: Largest turn of n (radians) in one step.
_LARGEST_TURN = 0.3
#: Directions tried where the one the law presses in leads nowhere.
_DIRECTIONS = 24
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class Unrelaxed(Protocol):
    """A law of a sheet that bears compression too."""

    def answer(self, strain: Array) -> Answer:
        """Answer to the right Cauchy-Green tensors (n, 3): C11, C22, C12."""

    def thickness_stretch(self, strain: Array) -> Array:
        """Return the thickness stretch (n,)."""


@dataclass(frozen=True)
class RelaxedSheet:
    """The tension field of a law."""

    law: Unrelaxed

    def __call__(self, strain: Array) -> Response:
        """Answer to the right Cauchy-Green tensors (n, 3)."""
        found = self._relaxed(strain)
        D = found.stiffness
        return Response(found.energy, found.stress, np.stack([D[:, i, j] for i, j in _PAIRS], axis=1), found.state)

    def principal(self, strain: Array) -> Principal:
        """Return principal stretches, and the principal Cauchy stresses at the width the sheet takes by itself."""
        c1, c2, _, _ = principal_directions(strain)
        found = self._relaxed(strain)
        C, S = found.natural, found.stress
        area2 = np.maximum(C[:, 0] * C[:, 1] - C[:, 2] ** 2, 1e-300)
        thickness = np.where(found.state == SLACK, 1.0, self.law.thickness_stretch(C))
        # Principal values of F S F'/J are those of S C/J, J the area stretch times the thickness stretch.
        scale = 1.0 / (thickness * np.sqrt(area2))
        trace = S[:, 0] * C[:, 0] + S[:, 1] * C[:, 1] + 2.0 * S[:, 2] * C[:, 2]
        product = (S[:, 0] * S[:, 1] - S[:, 2] ** 2) * area2
        spread = np.sqrt(np.maximum(0.25 * trace**2 - product, 0.0))
        cauchy = np.column_stack([0.5 * trace + spread, 0.5 * trace - spread]) * scale[:, None]
        cauchy[found.state == SLACK] = 0.0
        cauchy[found.state == WRINKLED, 1] = 0.0
        return Principal(np.sqrt(np.column_stack([c1, c2])), cauchy, thickness, _nominal(S, strain))

    def margin(self, strain: Array) -> Array:
        """Return the stability margin at the width the sheet takes by itself.

        The least over the largest eigenvalue of the moduli that take the rate of strain to the Jaumann rate of the
        Kirchhoff stress: positive where more strain in any direction of the plane takes more stress.
        """
        found = self._relaxed(strain)
        C = np.where((found.state == SLACK)[:, None], np.array([1.0, 1.0, 0.0]), found.natural)
        return least_modulus(self.law.answer(C), C)

    def _relaxed(self, strain: Array) -> _Found:
        C = np.array(strain, dtype=np.float64)
        own = self.law.answer(C)
        found = _Found(own.energy, own.stress, own.stiffness, np.zeros(len(C), np.int8), C.copy())
        slack = principal_directions(C)[0] <= 1.0
        S = own.stress
        pressed = (S[:, 0] + S[:, 1] < 0.0) | (S[:, 0] * S[:, 1] < S[:, 2] ** 2)
        # At rest rounding says which way the law presses: no wrinkle is to be found there.
        resting = np.abs(C - np.array([1.0, 1.0, 0.0])).max(axis=1) <= _RESTING
        wrinkled = np.flatnonzero(pressed & ~slack & ~resting)
        found.state[slack] = SLACK
        found.energy[slack], found.stress[slack], found.stiffness[slack] = 0.0, 0.0, 0.0
        found.natural[slack] = np.array([1.0, 1.0, 0.0])
        if len(wrinkled):
            # At first across the larger stress: there the law presses.
            along = 0.5 * np.arctan2(2.0 * S[wrinkled, 2], S[wrinkled, 0] - S[wrinkled, 1])
            with np.errstate(all="ignore"):  # beyond a law's limit, and where it falls without end
                self._wrinkle(found, wrinkled, C[wrinkled], along + 0.5 * np.pi)
        return found

    def _wrinkle(self, found: _Found, rows: Ints, C: Array, angle: Array) -> None:
        """Give up what the sheet cannot press at ``rows``; ``angle`` is a first guess of n."""
        own = Answer(found.energy[rows], found.stress[rows], found.stiffness[rows])
        a, angle, closed = self._minimum(C, angle, own)
        lost = np.flatnonzero(~closed & ~_falls(own))
        if len(lost):
            # Seldom: look all round, and go on from the least energy.
            many = np.repeat(C[lost], _DIRECTIONS, axis=0)
            tries = np.tile(np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS, len(lost))
            tried = self.law.answer(many)
            taken, turned, _ = self._minimum(many, tries, tried)
            energy = tried.energy.reshape(len(lost), -1)
            best = np.argmin(np.where(np.isfinite(energy), energy, np.inf), axis=1) + _DIRECTIONS * np.arange(len(lost))
            a[lost], angle[lost] = taken[best], turned[best]
            _put(own, lost, tried, best)
        falls = _falls(own)
        own.energy[falls], own.stress[falls], own.stiffness[falls] = np.nan, np.nan, np.nan
        u, w, _ = _axes(angle)
        gradient_angle = 0.5 * np.einsum("nj,nj->n", w, own.stress)
        Du, Dw = np.einsum("njk,nk->nj", own.stiffness, u), np.einsum("njk,nk->nj", own.stiffness, w)
        B = np.stack([0.5 * Du, 0.5 * a[:, None] * Dw], axis=1)
        H = _hessian(own, a, u, w, gradient_angle, angle)
        back = np.linalg.solve(_regular(H), B)
        found.energy[rows], found.stress[rows] = own.energy, own.stress
        found.stiffness[rows] = own.stiffness - np.einsum("nij,nik->njk", B, back)
        found.natural[rows] = C + a[:, None] * _dyad(angle)
        found.state[rows] = WRINKLED

    def _minimum(self, C: Array, angle: Array, own: Answer) -> tuple[Array, Array, Flags]:
        """Return a, the angle of n, and whether no stress is left on n; Newton's method on the energy.

        ``own`` (n) is the law's answer at ``C``, and in the end at what was found.
        """
        a, angle = np.zeros(len(C)), angle.copy()
        closed = np.zeros(len(C), bool)
        left = np.arange(len(C))
        for _ in range(_STEPS):
            u, w, _ = _axes(angle[left])
            stress, stiffness = own.stress[left], own.stiffness[left]
            on_n = np.einsum("nj,nj->n", u, stress)
            across = 0.5 * np.einsum("nj,nj->n", w, stress)
            size = np.abs(stress[:, 0]) + np.abs(stress[:, 1]) + 1e-9 * np.abs(stiffness[:, 0, 0])
            noise = _ROUNDING * np.abs(stiffness[:, 0, 0])
            done = (np.abs(on_n) + np.abs(across) <= np.maximum(_CLOSED * size, noise)) & (a[left] > 0.0)
            closed[left[done]] = True
            # Width costs energy at once in a direction that is pulled.
            keep = ~done & (own.energy[left] >= -noise) & ((a[left] > 0.0) | (on_n < 0.0))
            if not keep.any():
                break
            left, u, w, on_n, across = left[keep], u[keep], w[keep], on_n[keep], across[keep]
            remaining = np.abs(on_n) + np.abs(across)
            g = np.stack([0.5 * on_n, a[left] * across], axis=1)
            H = _positive(
                _hessian(Answer(own.energy[left], stress[keep], stiffness[keep]), a[left], u, w, across, angle[left])
            )
            # Without wrinkles yet their direction has no meaning: width first.
            flat = a[left] == 0.0
            H[flat, 0, 1] = H[flat, 1, 0] = 0.0
            H[flat, 1, 1] = 1.0
            g[flat, 1] = 0.0
            step = -np.linalg.solve(H, g[:, :, None])[:, :, 0]
            # The whole step shortened: with its turn alone cut off it need not go downhill.
            step *= np.minimum(1.0, _LARGEST_TURN / np.maximum(np.abs(step[:, 1:]), 1e-300))
            length = np.ones(len(left))
            pending = np.arange(len(left))
            for _ in range(25):
                rows = left[pending]
                energy = own.energy[rows]
                a_try = np.maximum(a[rows] + length[pending] * step[pending, 0], 0.25 * a[rows])
                angle_try = angle[rows] + length[pending] * step[pending, 1]
                tried = self.law.answer(C[rows] + a_try[:, None] * _dyad(angle_try))
                # Near the minimum the energy is flat to rounding: there less stress on n is what counts.
                n, nm, _ = _axes(angle_try)
                pressed = np.abs(np.einsum("nj,nj->n", n, tried.stress))
                pressed += 0.5 * np.abs(np.einsum("nj,nj->n", nm, tried.stress))
                flat_there = np.abs(tried.energy - energy) <= 1e-9 * np.abs(energy) + noise[keep][pending]
                fine = (tried.energy < energy) | (flat_there & (pressed < remaining[pending]))
                taken = rows[fine]
                a[taken], angle[taken] = a_try[fine], angle_try[fine]
                _put(own, taken, tried, fine)
                pending = pending[~fine]
                length[pending] *= 0.4
                if not len(pending):
                    break
            # Where no step helps, rounding has the last word.
            closed[left[pending]] = remaining[pending] <= _NEARLY * size[keep][pending]
            left = np.delete(left, pending)
        return a, angle, closed


@dataclass
class _Found:
    """Relaxed energy, stress, stiffness (n, 3, 3), state, and the strain C + a n n the law was asked at."""

    energy: Array
    stress: Array
    stiffness: Array
    state: NDArray[np.int8]
    natural: Array


def _nominal(S: Array, C: Array) -> Array:
    """Return the larger principal value (n,) of P = F S: the square root of that of P'P = S C S."""
    s, c = (X[:, [[0, 2], [2, 1]]] for X in (S, C))
    square = s @ c @ s
    mean, radius = (
        0.5 * (square[:, 0, 0] + square[:, 1, 1]),
        np.hypot(0.5 * (square[:, 0, 0] - square[:, 1, 1]), square[:, 0, 1]),
    )
    return np.sqrt(np.maximum(mean + radius, 0.0))


def _falls(own: Answer) -> Flags:
    """Say where there is less energy than at rest: given width the law falls without end, and has no least."""
    return np.asarray(own.energy < -_ROUNDING * np.abs(own.stiffness[:, 0, 0]))


def _axes(angle: Array) -> tuple[Array, Array, Array]:
    """Return what takes S to S.nn, S.(nm + mn), S.mm for n at ``angle`` and m = dn/dangle."""
    c, s = np.cos(angle), np.sin(angle)
    return (
        np.stack([c * c, s * s, 2.0 * c * s], axis=1),
        np.stack([-2.0 * c * s, 2.0 * c * s, 2.0 * (c * c - s * s)], axis=1),
        np.stack([s * s, c * c, -2.0 * c * s], axis=1),
    )


def _put(answer: Answer, rows: Ints, other: Answer, chosen: Ints | Flags) -> None:
    """Put the ``chosen`` of another answer at ``rows`` of one."""
    answer.energy[rows] = other.energy[chosen]
    answer.stress[rows] = other.stress[chosen]
    answer.stiffness[rows] = other.stiffness[chosen]


def _dyad(angle: Array) -> Array:
    """Return n n (n, 3): components 11, 22, 12."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * c, s * s, c * s], axis=1)


def _hessian(own: Answer, a: Array, u: Array, w: Array, across: Array, angle: Array) -> Array:
    """Return the second derivatives (n, 2, 2) of W(C + a n n) by a and the angle of n."""
    _, _, mm = _axes(angle)
    Du, Dw = np.einsum("njk,nk->nj", own.stiffness, u), np.einsum("njk,nk->nj", own.stiffness, w)
    H = np.empty((len(a), 2, 2))
    H[:, 0, 0] = 0.25 * np.einsum("nj,nj->n", u, Du)
    H[:, 0, 1] = H[:, 1, 0] = across + 0.25 * a * np.einsum("nj,nj->n", w, Du)
    H[:, 1, 1] = a * np.einsum("nj,nj->n", mm - u, own.stress) + 0.25 * a**2 * np.einsum("nj,nj->n", w, Dw)
    return H


def _positive(H: Array) -> Array:
    """Return 2 x 2 Hessians made positive definite, each unknown measured by its own stiffness.

    The angle of shallow wrinkles has little stiffness, and it is none the less a good one.
    """
    own = np.maximum(np.abs(np.stack([H[:, 0, 0], H[:, 1, 1]], axis=1)), 1e-300)
    bad = (H[:, 0, 0] <= 0.0) | (H[:, 1, 1] <= 0.0) | (H[:, 0, 1] ** 2 > (1.0 - 1e-6) * own[:, 0] * own[:, 1])
    found = H.copy()
    found[bad] = own[bad, :, None] * np.eye(2)
    return found


def _regular(H: Array) -> Array:
    """Return Hessians that can be solved: where the angle has no stiffness it has no part either."""
    det = H[:, 0, 0] * H[:, 1, 1] - H[:, 0, 1] ** 2
    flat = ~(np.abs(det) > 1e-14 * H[:, 0, 0] ** 2)
    return np.where(flat[:, None, None], H + np.array([[0.0, 0.0], [0.0, 1.0]]) * H[:, :1, :1], H)
