"""Specimens cut at any angle from a sheet of one energy: a ground, threads along warp and weft, and their angle.

A strip contracts and shears as it likes: what it answers at 45 degrees is that of the softest way to lengthen, not a
share of the stiffness along warp and weft. A sheet stretched alike in all directions does not shear: it carries the
mean of warp and weft whichever way it is mounted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from hyperfab.arrays import Ints
from hyperfab.materials.effects.path import UNIAXIAL, Path, second_stretch
from hyperfab.materials.law import Array, Law, Sheet
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.energy import ABSENT
from hyperfab.materials.orthotropic.specimen import Strip, held, strip
from hyperfab.materials.registry import law as law_called

#: Constants of an isotropic law that the energy's ground has by the same name.
GROUND = frozenset({"C10_MPa", "C20_MPa", "C30_MPa", "C2_MPa"})
#: The law that has them all, and at how many stretches of a test another law is brought to it.
_FULL_GROUND, _MET = "yeoh-3-lni2", 32
#: Stretches at which a strip's equilibrium is sought, from 1 on and below; between them its stress goes with its slope.
_KNOTS, _BELOW = 32, 2
#: An equilibrium at stretches as near as this is one to begin from.
_NEAR = 0.02
#: A ground without stiffness would leave threads to turn as they like: it has this share of theirs.
_LEAST = 1e-4


@dataclass(frozen=True)
class _Places:
    """Where rows of strips lie among the knots of their cut: at the stretches (n,) of all rows.

    rows       (m,) those of strips
    piece      (m,) the knot that the piece begins with in which a row lies
    angle_deg  of the strip of each knot, from the warp
    knots      stretches of these strips
    ends       (4, m) what the values at the ends of the piece count for there, and the slopes at its ends
    along      (m,) how far along the piece a row lies, by the logarithm of the stretch
    """

    stretch: Array
    rows: Ints
    piece: Ints
    angle_deg: Array
    knots: Array
    ends: Array
    along: Array

    @classmethod
    def of(cls, stretch: Array, angle_deg: Array, cuts: list[Ints]) -> _Places:
        """Return the places of the rows of each of the ``cuts``; ``angle_deg`` (n,) and ``stretch`` (n,) of all."""
        rows, cut = np.concatenate(cuts), np.repeat(np.arange(len(cuts)), list(map(len, cuts)))
        x = stretch[rows]
        each = _knots(x, cut)
        knots, per_cut = each.ravel(), each.shape[1]
        piece = cut * per_cut + _piece(each[cut], x)
        begin, end = knots[piece], knots[piece + 1]
        step = end - begin
        t = (x - begin) / step
        rise, bend = t * t * (3.0 - 2.0 * t), t * (1.0 - t) * step
        ends = np.stack([1.0 - rise, rise, bend * (1.0 - t), -bend * t])
        along = np.log(x / begin) / np.log(end / begin)
        return cls(stretch, rows, piece, np.repeat([angle_deg[of[0]] for of in cuts], per_cut), knots, ends, along)

    def between(self, value: Array, slope: Array) -> Array:
        """Return values at the rows by cubics through values and slopes at the knots."""
        first, second, rise, fall = self.ends
        i, j = self.piece, self.piece + 1
        return np.asarray(first * value[i] + second * value[j] + rise * slope[i] + fall * slope[j])

    def straight(self, value: Array) -> Array:
        """Return values at the rows, straight between those at the knots in the logarithm of the stretch."""
        return np.asarray(value[self.piece] + self.along * (value[self.piece + 1] - value[self.piece]))


@dataclass
class Threads:
    """Predicts the rows of ``path``; each equilibrium begins where the last one ended."""

    path: Path
    _last: Strip | None = None
    _met: _Places | None = None

    def answer(self, constants: Mapping[str, float], stretch: Array, side: Array) -> tuple[Array, Array, Array]:
        """Return nominal stress [MPa], energy [MPa] and the stretch across of every row at its ``stretch``.

        ``constants`` are those of the orthotropic energy, absent where not named; what is below zero counts as nothing.
        ``side`` is the stretch along the second axis of general biaxial tests.
        Rows without a direction are pulled along the warp. No number where a strip has no equilibrium.
        """
        law, path = _law(constants), self.path
        angle, cuts = self._cuts
        stress, energy = np.full_like(stretch, np.nan), np.full_like(stretch, np.nan)
        across = second_stretch(path.mode, stretch, side, side)
        square = path.mode != UNIAXIAL
        if np.any(square):
            one, other, energy[square] = held(law, angle[square], stretch[square], across[square])
            stress[square] = np.where(path.of_both_axes[square], 0.5 * (one + other), one)
        if len(cuts) == 0:
            return stress, energy, across
        if self._met is None or not np.array_equal(self._met.stretch, stretch):
            self._met = _Places.of(stretch, angle, cuts)
        met = self._met
        pulled = self._pulled(law, met)
        if pulled is not None:
            stress[met.rows] = met.between(pulled.stress, pulled.slope)
            energy[met.rows] = met.between(pulled.answer.energy, pulled.stress)
            across[met.rows] = np.exp(met.straight(np.log(pulled.width)))
        return stress, energy, across

    @cached_property
    def _cuts(self) -> tuple[Array, list[Ints]]:
        """The angle of every row from the warp, and the rows of the strips cut at each."""
        angle = np.where(np.isfinite(self.path.angle_deg), self.path.angle_deg, 0.0)
        strips = self.path.mode == UNIAXIAL
        return angle, [np.flatnonzero(strips & (angle == cut)) for cut in np.unique(angle[strips])]

    def _pulled(self, law: Orthotropic, met: _Places) -> Strip | None:
        last = self._last
        if last is not None and np.max(np.abs(last.stretch / met.knots - 1.0)) > _NEAR:
            last = None
        with np.errstate(all="ignore"):
            found = strip(law, met.angle_deg, met.knots, near=last)
            if last is not None and not found.closed.all():
                found = strip(law, met.angle_deg, met.knots)
        if not found.closed.all():
            return None
        self._last = found
        return found


def nearest_ground(law: Law, constants: Mapping[str, float], reach: float) -> dict[str, float]:
    """Return the ground that comes nearest to an isotropic ``law``, in the stress of a strip pulled to the strain
    ``reach``. No number where the law has no stress there.

    >>> from hyperfab.materials.registry import law
    >>> found = nearest_ground(law("mooney-rivlin-2"), {"C10_MPa": 0.2, "C01_MPa": 0.0}, 1.0)
    >>> {name: round(value, 9) for name, value in found.items()}
    {'C10_MPa': 0.2, 'C20_MPa': 0.0, 'C30_MPa': 0.0, 'C2_MPa': 0.0}
    """
    names = law_called(_FULL_GROUND).names
    met, columns = _columns(reach)
    c, theta = law.split(constants)
    stress = sum(own * term.stress(met) for own, term in zip(c, law.terms(met, theta), strict=True))
    if not np.all(np.isfinite(stress)):
        return dict.fromkeys(names, np.nan)
    from scipy.optimize import nnls  # 0.06 s to load: only laws with threads need it

    return dict(zip(names, map(float, nnls(columns, stress)[0]), strict=True))


@cache
def _columns(reach: float) -> tuple[Sheet, Array]:
    """Return the stretches at which a law is brought to the ground, and the stress of each of the ground's terms."""
    stretch = 1.0 + reach * np.linspace(0.0, 1.0, _MET + 1)[1:]
    met = Sheet.of(stretch, stretch**-0.5)
    return met, np.stack([term.stress(met) for term in law_called(_FULL_GROUND).terms(met, ())], axis=1)


def _law(constants: Mapping[str, float]) -> Orthotropic:
    given = {**ABSENT, **{name: max(float(value), 0.0) for name, value in constants.items()}}
    if not given["C2_MPa"]:
        given["C10_MPa"] = max(given["C10_MPa"], _LEAST * (given["k1_warp_MPa"] + given["k1_weft_MPa"]), 1e-12)
    return Orthotropic(given)


def _knots(x: Array, cut: Ints) -> Array:
    """Return the knots (k, m) of each cut, of all ``x`` (n,), at even parts from the least to 1 and on to the most."""
    starts = np.flatnonzero(np.diff(cut, prepend=-1))
    # Threads begin to bear at a stretch of 1: no piece of the curve goes over it.
    low = np.minimum(np.minimum.reduceat(x, starts), 1.0 - 1e-3)
    high = np.maximum(np.maximum.reduceat(x, starts), 1.0 + 1e-6)
    below, above = np.linspace(low, 1.0, _BELOW + 1, axis=1), np.linspace(1.0, high, _KNOTS, axis=1)
    return np.concatenate([below[:, :-1], above], axis=1)


def _piece(knots: Array, x: Array) -> Ints:
    """Return the piece of its ``knots`` (n, m) that each of ``x`` (n,) lies in, or ends."""
    below = _BELOW * (x - knots[:, 0]) / (1.0 - knots[:, 0])
    above = (_KNOTS - 1) * (x - 1.0) / (knots[:, -1] - 1.0)
    part = np.ceil(np.where(x > 1.0, _BELOW + above, below)) - 1.0
    return np.clip(part.astype(np.int64), 0, _BELOW + _KNOTS - 2)
