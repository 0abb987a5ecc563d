"""The constants of the orthotropic law from whatever tests of a sheet there are.

Weighted least squares on nominal stresses and measured lateral stretches. The energy is linear in its stresses: for
given other constants, and the lateral stretches as measured (or those of the ground), the equations of the tests and
of the free edges are a non-negative linear problem. Its best solutions over a grid of the other constants are the
starts of a bounded Gauss-Newton iteration on the equations as they are, with the strip's own equilibrium in it.

A slanted strip too short to be uniform is one held in its grips (grips.py): how much stiffer that makes it is found for
the constants at hand and taken out of its readings, until both agree.

What the tests cannot tell is not made up: a constant no test speaks of is left absent, and named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.optimize import nnls

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve, largest_stress, of_deviations
from hyperfab.errors import InputError
from hyperfab.materials.identification.linear import least_in_box
from hyperfab.materials.identification.scatter import Weighed
from hyperfab.materials.orthotropic.determined import Unknown, sought_by
from hyperfab.materials.orthotropic.energy import LINEAR, NAMES, Orthotropic
from hyperfab.materials.orthotropic.grips import at_readings
from hyperfab.materials.orthotropic.rows import SLIGHT, Gathered, LinearRows, Rows, linear_rows, strained
from hyperfab.materials.orthotropic.specimen import Frame, held, solved, strip

_GRID = {"nu": (0.02, 0.2, 0.35, 0.5), "bias_deg": (20.0, 35.0, 45.0, 55.0, 70.0)}
#: Upturn of a thread over the data, as k2 times the square of its largest strain I - 1.
_UPTURN = (0.03, 0.6, 3.0, 8.0)
_MOST_UPTURN = 40.0
_STARTS = 6
_ROWS_TO_START = 160
#: Readings that move by less, over their largest, from one turn to the next are settled; and turns to get there.
_AGREED, _TURNS = 1e-5, 20
#: No reading is surer than this share of itself: what a constant gains below is rounding of the file.
_SUREST = 1e-7
#: A coordinate closer than this to an end of its box lies there.
_HELD = 1e-7


@dataclass(frozen=True)
class Found:
    """The law, the square sum of weighted errors, the constants that were sought and those left open.

    ``optimum``: the weighted equations there, by the constants sought; each row's curve is the number of its test.
    """

    law: Orthotropic
    sse: float
    sought: tuple[str, ...]
    unknown: tuple[Unknown, ...]
    optimum: Weighed = field(repr=False)


def identify(tests: Sequence[TestCurve], near: Orthotropic | None = None) -> Found:
    """Return the best constants for the tests.

    With ``near``, only its stresses are sought, the other constants stay: the same fabric at another temperature.

    >>> lam = np.linspace(1.05, 1.5, 10); own = Orthotropic.of({"C10_MPa": 0.2, "C30_MPa": 0.05})
    >>> pull = TestCurve("uniaxial", lam, strip(own, 0.0, lam).stress, np.ones(10))
    >>> found = identify([pull]).law.parameters
    >>> round(found["C10_MPa"], 9), round(found["C30_MPa"], 9)
    (0.2, 0.05)
    """
    names, unknown = sought_by(tests)
    if near is not None:
        names = tuple(name for name in names if name in LINEAR)
        unknown = ()
    seen, z = list(tests), np.zeros(0)
    for turn in range(_TURNS):
        if turn < 2:
            free = _Free(seen, names, near or Orthotropic.of({"C10_MPa": 1.0}))
            few = _thinned(seen, _ROWS_TO_START)
            ends = [free.polished(few, start, 40) for start in free.starts(few)]
            z = min(ends, key=lambda end: end[1])[0]
        z, free = free.settled(seen, z)
        law, before = free.law(z), seen
        seen = [_ungripped(test, law) for test in tests]
        moved = [
            np.abs(one.stress - two.stress).max() / np.abs(two.stress).max()
            for one, two in zip(seen, before, strict=True)
        ]
        if max(moved) <= _AGREED:
            break
    else:
        raise InputError(
            "how the grips stiffen the slanted strips does not settle",
            remedy="give longer strips, or their stretch as measured away from the grips",
        )
    rows = Gathered.of(before)
    residual, jacobian = free.equations(rows, z)
    full = free.full(jacobian, z, names)
    stated = of_deviations(tests)
    deviation = None if stated is None else Gathered.of(stated).stresses
    optimum = Weighed(full, residual, np.nan_to_num(residual + rows.stresses), rows.curve, deviation)
    return Found(law, float(residual @ residual), names, unknown, optimum)


def _ungripped(test: TestCurve, law: Orthotropic) -> TestCurve:
    """Return a test of a strip as if it were uniform: without what its grips add."""
    if test.mode != "uniaxial" or test.aspect is None:
        return test
    factor = at_readings(law, test.direction, test.aspect, test.stretch)
    return replace(test, stress=test.stress / factor, weight=test.weights * factor)


@dataclass(frozen=True)
class _Free:
    """The constants that are sought, as a vector z: stresses over their scale, logarithms of upturns, nu, angle/45."""

    tests: Sequence[TestCurve]
    names: tuple[str, ...]
    base: Orthotropic

    @property
    def stress_scale(self) -> float:
        return largest_stress(self.tests)

    @cached_property
    def reach(self) -> dict[str, float]:
        """The largest strain I - 1 of the threads that each upturn is of; inclined ones may lie nearly along either."""
        warp, weft = self.reach_along(0.0), self.reach_along(90.0)
        return {"k2_warp": warp, "k2_weft": weft, "k2_bias": max(min(warp, weft), 0.05 * max(warp, weft))}

    def reach_along(self, angle: float) -> float:
        """Return the largest strain I - 1 of threads at an angle [deg]; of those that nothing pulls, what is slight."""
        most = max(strained(self.tests, way) for way in (0.0, 45.0, 90.0))
        return max(strained(self.tests, angle), SLIGHT * most)

    @property
    def bounds(self) -> tuple[Array, Array]:
        sides = {"nu": (0.0, 0.5), "bias_deg": (2.0 / 45.0, 88.0 / 45.0)}
        upturn = (np.log(1e-3), np.log(_MOST_UPTURN))
        pairs = [sides.get(name, upturn if name.startswith("k2") else (0.0, np.inf)) for name in self.names]
        low, high = np.array(pairs).reshape(-1, 2).T
        return low, high

    def value(self, name: str, z: float) -> float:
        """Return a constant of its coordinate."""
        if name in LINEAR:
            return float(z * self.stress_scale)
        if name.startswith("k2"):
            return float(np.exp(z)) / self.reach[name] ** 2
        if name == "nu" and z > 0.5 - _HELD:
            return 0.5
        return float(45.0 * z if name == "bias_deg" else z)

    def slope(self, name: str, z: float) -> float:
        """Return the derivative of a constant by its coordinate."""
        if name.startswith("k2"):
            return self.value(name, z)
        return self.stress_scale if name in LINEAR else 45.0 if name == "bias_deg" else 1.0

    def law(self, z: Array) -> Orthotropic:
        own = {name: self.value(name, value) for name, value in zip(self.names, z, strict=True)}
        return Orthotropic({**self.base.parameters, **dict.fromkeys(LINEAR, 0.0), **own})

    def without(self, gone: set[str]) -> _Free:
        """Return the same without some threads' or the ground's stress, and what belongs to it alone."""
        belongs = {f"k1_{one}_MPa": {f"k2_{one}"} for one in ("warp", "weft")}
        belongs["k1_bias_MPa"] = {"k2_bias", "bias_deg"}
        every = gone.union(*(belongs.get(name, set()) for name in gone))
        return replace(self, names=tuple(name for name in self.names if name not in every))

    def equations(self, rows: Gathered, z: Array) -> tuple[Array, Array]:
        """Return weighted errors and their derivatives by z."""
        law = self.law(z)
        parts = []
        if len(rows.strips.stretch):
            parts.append(_strip_errors(rows.strips, law, self, z))
        if len(rows.held.stretch):
            parts.append(_held_errors(rows.held, law, self, z))
        residual, jacobian = zip(*parts, strict=True)
        return np.concatenate(residual), np.concatenate(jacobian)

    def polished(self, tests: Sequence[TestCurve], z: Array, steps: int) -> tuple[Array, float]:
        """Return the nearest optimum in the box, and half its square sum."""
        low, high = self.bounds
        inside = np.clip(z, low + 1e-9, np.where(np.isfinite(high), high - 1e-9, high))
        rows = Gathered.of(tests)
        return least_in_box(lambda z: self.equations(rows, z), inside, (low, high), steps, "jac", 1e-14)

    def settled(self, tests: Sequence[TestCurve], z: Array) -> tuple[Array, _Free]:
        """Return the optimum on all rows, without the stresses that vanish there."""
        z, cost = self.polished(tests, z, 200)
        free, rounding = self, 0.5 * _SUREST**2 * sum(len(test.stretch) for test in tests)
        while True:
            small = {
                name
                for name, value in zip(free.names, z, strict=True)
                if name in LINEAR and value < 1e-5 and name != "C10_MPa"
            }
            if not small:
                return z, free
            fewer = free.without(small)
            start = np.array([z[free.names.index(name)] for name in fewer.names])
            better, less = fewer.polished(tests, start, 200)
            if less > cost * (1.0 + 1e-6) + rounding:
                return z, free
            z, cost, free = better, less, fewer

    def full(self, jacobian: Array, z: Array, names: Sequence[str]) -> Array:
        """Return the derivatives by the constants ``names`` themselves, zero for those that vanished or lie at an end
        of their box: there the tests hold them, and no reading moves them."""
        found = np.zeros((len(jacobian), len(names)))
        low, high = self.bounds
        for column, (name, value) in enumerate(zip(self.names, z, strict=True)):
            if low[column] + _HELD < value < high[column] - _HELD:
                found[:, names.index(name)] = jacobian[:, column] / self.slope(name, value)
        return found

    def starts(self, tests: Sequence[TestCurve]) -> list[Array]:
        """Return the best non-negative linear solutions over a grid of the other constants."""
        p = self.base.parameters
        grid = _GRID | {name: tuple(value / reach**2 for value in _UPTURN) for name, reach in self.reach.items()}
        options = {name: values if name in self.names else (p[name],) for name, values in grid.items()}
        inclined = {angle: self.reach["k2_bias"] / self.reach_along(angle) for angle in options["bias_deg"]}
        linear = [name for name in self.names if name in LINEAR]
        ranked: list[tuple[float, Array]] = []
        for nu in options["nu"]:
            rows = [linear_rows(test, nu) for test in tests]

            def columns(rows: list[LinearRows] = rows, **other: float) -> dict[str, Array]:
                law = Orthotropic({**p, **other})
                terms = np.concatenate([one.of(law) for one in rows])
                return dict(zip(LINEAR, terms.T, strict=True))

            ground = columns(nu=nu)
            warp = {k: columns(nu=nu, k2_warp=k)["k1_warp_MPa"] for k in options["k2_warp"]}
            weft = {k: columns(nu=nu, k2_weft=k)["k1_weft_MPa"] for k in options["k2_weft"]}
            pairs = [(k * inclined[angle] ** 2, angle) for k, angle in product(options["k2_bias"], inclined)]
            bias = {(k, angle): columns(nu=nu, k2_bias=k, bias_deg=angle)["k1_bias_MPa"] for k, angle in pairs}
            b = np.concatenate([one.right for one in rows])
            for kw, kf, kb in product(warp, weft, bias):
                every = {
                    **ground, "k1_warp_MPa": warp[kw], "k1_weft_MPa": weft[kf], "k1_bias_MPa": bias[kb]
                }  # fmt: skip
                A = np.column_stack([every[name] for name in linear]) * self.stress_scale
                if not np.isfinite(A).all():
                    continue
                c, rest = nnls(A, b)
                values = dict(zip(linear, c, strict=True))
                values |= {"nu": nu, "bias_deg": kb[1] / 45.0}
                values |= {
                    name: np.log(max(k * self.reach[name] ** 2, 1e-3))
                    for name, k in (("k2_warp", kw), ("k2_weft", kf), ("k2_bias", kb[0]))
                }
                ranked.append((rest, np.array([values[name] for name in self.names])))
        ranked.sort(key=lambda one: one[0])
        return [z for _, z in ranked[: 4 * _STARTS : 4]] + self._of_threads(ranked[0][1])

    def _of_threads(self, z: Array) -> list[Array]:
        """Return a start where the stiffness of slanted strips is that of inclined threads, hardly of the ground.

        The linear problem has none: such a strip shears until its threads lie along the pull.
        """
        slanted = [t for t in self.tests if t.mode == "uniaxial" and t.direction is not None and t.direction % 90.0]
        if not slanted or "k1_bias_MPa" not in self.names:
            return []
        stiff = min(float(test.stress[-1] / max(test.stretch[-1] - 1.0, 1e-9)) for test in slanted)
        own = {"C10_MPa": 0.02 * stiff, "C20_MPa": 0.0, "C30_MPa": 0.0, "C2_MPa": 0.0, "G_MPa": 0.02 * stiff}
        own["k1_bias_MPa"] = 0.25 * stiff
        start = [
            own[name] / self.stress_scale if name in own else value for name, value in zip(self.names, z, strict=True)
        ]
        return [np.array(start)]


def _strip_errors(rows: Rows, law: Orthotropic, free: _Free, z: Array) -> tuple[Array, Array]:
    """Return the weighted errors of strips, of stress and then of width where measured, and their derivatives by z."""
    frame = Frame.at(rows.angle)
    pulled = strip(law, rows.angle, rows.stretch)
    change = _stress_slopes(law, pulled.strain, free, z)
    edges = np.stack([frame.nn, frame.tn], axis=1)
    D = pulled.answer.stiffness
    H = np.einsum("nij,njk,nlk->nil", edges, D, edges)
    B = np.einsum("nij,njk,nk->ni", edges, D, frame.tt)
    load = np.einsum("nij,nkj->nik", edges, change)
    # A sheet so soft across that the free edges have no stiffness has no derivative there: it is left still.
    with np.errstate(all="ignore"):
        moved = np.nan_to_num(np.stack([solved(H, one) for one in np.moveaxis(load, 2, 0)], axis=2))
    slopes = np.einsum("nj,nkj->nk", frame.tt, change) - np.einsum("ni,nik->nk", B, moved)
    closed = np.where(pulled.closed, 1.0, np.nan)
    told = rows.second
    width = -moved[told, 0] / pulled.width[told, None]
    return (
        np.concatenate(
            [
                (pulled.stress * closed - rows.stress) * rows.weight,
                ((pulled.width * closed)[told] - rows.stretch2[told]) * rows.weight2[told],
            ]
        ),
        np.concatenate([(rows.stretch * rows.weight)[:, None] * slopes, width * rows.weight2[told, None]]),
    )


def _held_errors(rows: Rows, law: Orthotropic, free: _Free, z: Array) -> tuple[Array, Array]:
    """Return the weighted errors of tests with held edges, along and then across where measured, and derivatives."""
    frame = Frame.at(rows.angle)
    C = frame.strain(rows.stretch**2, rows.stretch2**2, np.zeros_like(rows.stretch))
    change = _stress_slopes(law, C, free, z)
    one, two, _ = held(law, rows.angle, rows.stretch, rows.stretch2)
    along = (rows.stretch * rows.weight)[:, None] * np.einsum("nj,nkj->nk", frame.tt, change)
    across = (rows.stretch2 * rows.weight2)[:, None] * np.einsum("nj,nkj->nk", frame.nn, change)
    told = rows.second
    return (
        np.concatenate([(one - rows.stress) * rows.weight, ((two - rows.stress2) * rows.weight2)[told]]),
        np.concatenate([along, across[told]]),
    )


def _stress_slopes(law: Orthotropic, C: Array, free: _Free, z: Array) -> Array:
    """Return dS/dz (n, sought, 3) at fixed strain."""
    terms = law.stress_terms(C)
    theta, c = law.vector[len(LINEAR) :], law.vector[: len(LINEAR)]
    found = np.empty((len(C), len(free.names), 3))
    for k, (name, value) in enumerate(zip(free.names, z, strict=True)):
        if name in LINEAR:
            one = terms[:, LINEAR.index(name)]
        else:
            # Central differences: their error moves the iteration, not where it ends.
            step = np.zeros_like(theta)
            step[NAMES.index(name) - len(LINEAR)] = size = 1e-5 * max(abs(free.value(name, value)), 1e-3)
            one = np.einsum("k,nkj->nj", c, law.stress_terms(C, theta + step) - law.stress_terms(C, theta - step))
            one /= 2.0 * size
        found[:, k] = one * free.slope(name, value)
    return found


def _thinned(tests: Sequence[TestCurve], rows: int) -> list[TestCurve]:
    """Return tests of about ``rows`` rows in all, evenly taken."""
    total = sum(len(test.stretch) for test in tests)
    if total <= rows:
        return list(tests)
    share = rows / total
    return [test.thinned(max(int(len(test.stretch) * share), 8)) for test in tests]
