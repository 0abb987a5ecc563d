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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, nnls

from hyperfab.arrays import Array
from hyperfab.curve import TestCurve
from hyperfab.errors import InputError
from hyperfab.materials.identification.scatter import Weighed
from hyperfab.materials.orthotropic.energy import ABSENT, LINEAR, NAMES, Orthotropic
from hyperfab.materials.orthotropic.grips import at_readings
from hyperfab.materials.orthotropic.specimen import Frame, held, solved, strip

_GRID = {"nu": (0.02, 0.2, 0.35, 0.5), "bias_deg": (20.0, 35.0, 45.0, 55.0, 70.0)}
#: Upturn of a thread over the data, as k2 times the square of the largest strain I - 1.
_UPTURN = (0.03, 0.6, 3.0, 8.0)
_MOST_UPTURN = 40.0
_STARTS = 6
_ROWS_TO_START = 160
#: Readings that move by less, over their largest, from one turn to the next are settled; and turns to get there.
_AGREED, _TURNS = 1e-5, 20


def _across(test: TestCurve) -> Array:
    """Return the stretch of the second axis of a test whose edges are held."""
    if test.mode == "shear":
        return np.ones_like(test.stretch)
    return test.stretch if test.stretch2 is None or test.mode == "biaxial" else test.stretch2


@dataclass(frozen=True)
class Unknown:
    """A constant the tests leave open, the value it has for want of one, and the test that would tell it."""

    name: str
    value: float
    test: str


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


def sought_by(tests: Sequence[TestCurve]) -> tuple[tuple[str, ...], tuple[Unknown, ...]]:
    """Return the constants these tests can tell, and those they leave open, each with the test that would tell it.

    >>> lam = np.array([1.1, 1.2]); pull = TestCurve("uniaxial", lam, lam - 1, lam, direction=0.0)
    >>> sought_by([pull])[0]
    ('C10_MPa', 'C20_MPa', 'C30_MPa')
    """
    modes = {test.mode.removesuffix("-general") for test in tests}
    angles = {test.direction for test in tests}
    uniaxial = {test.direction for test in tests if test.mode == "uniaxial"}
    both = {0.0, 90.0} <= uniaxial or (None not in angles and any(_both_ways(test) for test in tests))
    slanted = {_slant(a) for a in uniaxial if a is not None and _slant(a) % 90.0 > 1e-6}
    contraction = any(test.contraction is not None for test in tests)
    second = contraction or len(modes) > 1
    found, open_ = ["C10_MPa", "C20_MPa", "C30_MPa"], []
    if len(modes) > 1:
        found.append("C2_MPa")
    else:
        open_.append(("C2_MPa", "a biaxial or planar test beside the uniaxial one"))
    if contraction or (both and len(modes) > 1):
        found.append("nu")
    else:
        open_.append(("nu", "the lateral stretch of the uniaxial test (column stretch 2)"))
    if both:
        found += ["k1_warp_MPa", "k2_warp", "k1_weft_MPa", "k2_weft"]
    else:
        open_ += [
            (name, "uniaxial tests along warp and weft")
            for name in ("k1_warp_MPa", "k2_warp", "k1_weft_MPa", "k2_weft")
        ]
    # Strips cut at one angle tell that angle's stiffness, not whether threads or the resistance of the angle give it; a
    # pair of threads that may lie anywhere would stand in for those of warp or weft.
    slants = "four slanted angles" if slanted else "a biaxial one"
    for name, told, test in (
        ("k1_bias_MPa", len(slanted) > 1, "uniaxial tests at two slanted angles, as 22 and 45 deg"),
        ("k2_bias", len(slanted) > 1, "uniaxial tests at two slanted angles, as 22 and 45 deg"),
        ("bias_deg", len(slanted) > 3, f"tests along warp and weft with lateral stretch, or {slants}"),
    ):
        if both and (second or told):
            found.append(name)
        else:
            open_.append((name, test))
    if slanted:
        found.append("G_MPa")
    else:
        open_.append(("G_MPa", "a uniaxial test at an angle, as 45 deg"))
    unknown = tuple(Unknown(name, ABSENT[name], test) for name, test in open_)
    return tuple(name for name in NAMES if name in found), unknown


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
    rows = _Gathered.of(before)
    residual, jacobian = free.equations(rows, z)
    full = free.full(jacobian, z, names)
    optimum = Weighed(full, residual, np.nan_to_num(residual + rows.stresses), rows.curve)
    return Found(law, float(residual @ residual), names, unknown, optimum)


def _ungripped(test: TestCurve, law: Orthotropic) -> TestCurve:
    """Return a test of a strip as if it were uniform: without what its grips add."""
    if test.mode != "uniaxial" or test.aspect is None:
        return test
    factor = at_readings(law, test.direction, test.aspect, test.stretch)
    return replace(test, stress=test.stress / factor, weight=test.weights * factor)


@dataclass(frozen=True)
class _Rows:
    """The rows of several tests of one kind; ``second`` says where a second measured value is."""

    curve: NDArray[np.int64]
    angle: Array
    stretch: Array
    stress: Array
    weight: Array
    stretch2: Array
    stress2: Array
    weight2: Array
    second: NDArray[np.bool_]

    @classmethod
    def of(cls, tests: Sequence[tuple[int, TestCurve]]) -> _Rows:
        def joined(pick: Callable[[TestCurve], Array | None]) -> Array:
            parts = [(pick(test), len(test.stretch)) for _, test in tests]
            return np.concatenate([np.zeros(0), *(np.zeros(n) if one is None else one for one, n in parts)])

        def told(test: TestCurve) -> bool:
            if test.mode == "uniaxial":
                return test.contraction is not None and test.weight2 is not None
            return test.stress2 is not None and test.mode.startswith("biaxial")

        counts = [len(test.stretch) for _, test in tests]
        return cls(
            curve=np.repeat([number for number, _ in tests], counts).astype(np.int64),
            angle=np.repeat([test.direction or 0.0 for _, test in tests], counts),
            stretch=joined(lambda test: test.stretch),
            stress=joined(lambda test: test.stress),
            weight=joined(lambda test: test.weights),
            stretch2=joined(lambda test: test.stretch2 if test.mode == "uniaxial" else _across(test)),
            stress2=joined(lambda test: test.stress2),
            weight2=joined(lambda test: test.weights if test.weight2 is None else test.weight2),
            second=np.repeat([told(test) for _, test in tests], counts).astype(bool),
        )


@dataclass(frozen=True)
class _Gathered:
    """All rows, those of strips and those of tests with held edges."""

    strips: _Rows
    held: _Rows

    @classmethod
    def of(cls, tests: Sequence[TestCurve]) -> _Gathered:
        numbered = list(enumerate(tests))
        return cls(
            _Rows.of([one for one in numbered if one[1].mode == "uniaxial"]),
            _Rows.of([one for one in numbered if one[1].mode != "uniaxial"]),
        )

    @property
    def curve(self) -> NDArray[np.int64]:
        """The number of each equation's test."""
        parts = [(rows.curve, rows.curve[rows.second]) for rows in (self.strips, self.held)]
        return np.concatenate([part for pair in parts for part in pair])

    @property
    def stresses(self) -> Array:
        """The weighted measured stress of each equation; no number where it is one of width."""
        s, h = self.strips, self.held
        across = (h.stress2 * h.weight2)[h.second]
        return np.concatenate(
            [s.stress * s.weight, np.full(int(s.second.sum()), np.nan), h.stress * h.weight, across]
        )


@dataclass(frozen=True)
class _Free:
    """The constants that are sought, as a vector z: stresses over their scale, logarithms of upturns, nu, angle/45."""

    tests: Sequence[TestCurve]
    names: tuple[str, ...]
    base: Orthotropic

    @property
    def stress_scale(self) -> float:
        return max(float(np.abs(test.stress).max()) for test in self.tests)

    @property
    def reach(self) -> float:
        """The largest strain I - 1 of the tests."""
        return (
            max(max(float(test.stretch.max()), float(_across(test).max())) for test in self.tests) ** 2 - 1.0
        )

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
            return float(np.exp(z)) / self.reach**2
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

    def equations(self, rows: _Gathered, z: Array) -> tuple[Array, Array]:
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
        rows = _Gathered.of(tests)
        last: dict[bytes, tuple[Array, Array]] = {}

        def both(z: Array) -> tuple[Array, Array]:
            if z.tobytes() not in last:
                last.clear()
                last[z.tobytes()] = self.equations(rows, z)
            return last[z.tobytes()]

        with np.errstate(all="ignore"):
            found = least_squares(
                lambda z: np.nan_to_num(both(z)[0], nan=1e6, posinf=1e6, neginf=-1e6),
                inside,
                jac=lambda z: np.nan_to_num(both(z)[1]),
                bounds=(low, high),
                x_scale="jac",
                xtol=1e-15,
                ftol=1e-14,
                gtol=1e-15,
                max_nfev=steps,
            )
        return found.x, float(found.cost)

    def settled(self, tests: Sequence[TestCurve], z: Array) -> tuple[Array, _Free]:
        """Return the optimum on all rows, without the stresses that vanish there."""
        z, cost = self.polished(tests, z, 200)
        free = self
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
            if less > cost * (1.0 + 1e-6) + 1e-24:
                return z, free
            z, cost, free = better, less, fewer

    def full(self, jacobian: Array, z: Array, names: Sequence[str]) -> Array:
        """Return the derivatives by the constants ``names`` themselves, zero for those that vanished."""
        found = np.zeros((len(jacobian), len(names)))
        for column, (name, value) in enumerate(zip(self.names, z, strict=True)):
            found[:, names.index(name)] = jacobian[:, column] / self.slope(name, value)
        return found

    def starts(self, tests: Sequence[TestCurve]) -> list[Array]:
        """Return the best non-negative linear solutions over a grid of the other constants."""
        p = self.base.parameters
        k2 = [value / self.reach**2 for value in _UPTURN]
        options = {
            name: (_GRID.get(name, k2) if name in self.names else (p[name],))
            for name in ("nu", "k2_warp", "k2_weft", "k2_bias", "bias_deg")
        }
        linear = [name for name in self.names if name in LINEAR]
        ranked: list[tuple[float, Array]] = []
        for nu in options["nu"]:
            rows = [_linear_rows(test, nu) for test in tests]

            def columns(rows: list[_LinearRows] = rows, **other: float) -> dict[str, Array]:
                law = Orthotropic({**p, **other})
                terms = np.concatenate([one.of(law) for one in rows])
                return dict(zip(LINEAR, terms.T, strict=True))

            ground = columns(nu=nu)
            warp = {k: columns(nu=nu, k2_warp=k)["k1_warp_MPa"] for k in options["k2_warp"]}
            weft = {k: columns(nu=nu, k2_weft=k)["k1_weft_MPa"] for k in options["k2_weft"]}
            bias = {
                pair: columns(nu=nu, k2_bias=pair[0], bias_deg=pair[1])["k1_bias_MPa"]
                for pair in product(options["k2_bias"], options["bias_deg"])
            }
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
                    name: np.log(max(k * self.reach**2, 1e-3))
                    for name, k in (("k2_warp", kw), ("k2_weft", kf), ("k2_bias", kb[0]))
                }
                ranked.append((rest, np.array([values[name] for name in self.names])))
        ranked.sort(key=lambda one: one[0])
        return [z for _, z in ranked[: 4 * _STARTS : 4]] + self._of_threads(ranked[0][1])

    def _of_threads(self, z: Array) -> list[Array]:
        """Return a start where the stiffness of slanted strips is that of inclined threads, hardly of the ground.

        The linear problem has none: such a strip shears until its threads lie along the pull.
        """
        slanted = [
            t for t in self.tests if t.mode == "uniaxial" and t.direction is not None and t.direction % 90.0
        ]
        if not slanted or "k1_bias_MPa" not in self.names:
            return []
        stiff = min(float(test.stress[-1] / max(test.stretch[-1] - 1.0, 1e-9)) for test in slanted)
        own = {"C10_MPa": 0.02 * stiff, "C20_MPa": 0.0, "C30_MPa": 0.0, "C2_MPa": 0.0, "G_MPa": 0.02 * stiff}
        own["k1_bias_MPa"] = 0.25 * stiff
        start = [
            own[name] / self.stress_scale if name in own else value
            for name, value in zip(self.names, z, strict=True)
        ]
        return [np.array(start)]


def _strip_errors(rows: _Rows, law: Orthotropic, free: _Free, z: Array) -> tuple[Array, Array]:
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


def _held_errors(rows: _Rows, law: Orthotropic, free: _Free, z: Array) -> tuple[Array, Array]:
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
            one = np.einsum(
                "k,nkj->nj", c, law.stress_terms(C, theta + step) - law.stress_terms(C, theta - step)
            )
            one /= 2.0 * size
        found[:, k] = one * free.slope(name, value)
    return found


@dataclass(frozen=True)
class _LinearRows:
    """A test at strains taken as known: weighted stress equations, and free edges where the width was measured."""

    C: Array
    along: Array
    across: Array | None
    right: Array

    def of(self, law: Orthotropic) -> Array:
        terms = law.stress_terms(self.C)
        rows = [np.einsum("nj,nkj->nk", self.along, terms)]
        if self.across is not None:
            rows.append(np.einsum("nj,nkj->nk", self.across, terms))
        return np.concatenate(rows)


def _linear_rows(test: TestCurve, nu: float) -> _LinearRows:
    frame = Frame.at(np.full(len(test.stretch), test.direction or 0.0))
    if test.mode == "uniaxial":
        second = test.stretch**-nu if test.stretch2 is None else test.stretch2
    else:
        second = _across(test)
    C = frame.strain(test.stretch**2, second**2, np.zeros_like(second))
    along = (test.weights * test.stretch)[:, None] * frame.tt
    right = test.weights * test.stress
    known = test.stress2 if test.mode.startswith("biaxial") else None
    if test.contraction is not None:
        known = np.zeros_like(test.stress)
    if known is None:
        return _LinearRows(C, along, None, right)
    weight = test.weights if test.weight2 is None or test.contraction is not None else test.weight2
    return _LinearRows(
        C, along, (weight * second)[:, None] * frame.nn, np.concatenate([right, weight * known])
    )


def _slant(angle: float) -> float:
    """Return the angle [deg] from the warp, 0 to 90, of a strip that cannot be told from its mirror image."""
    turned = angle % 180.0
    return min(turned, 180.0 - turned)


def _both_ways(test: TestCurve) -> bool:
    return test.mode.startswith("biaxial") and test.stress2 is not None


def _thinned(tests: Sequence[TestCurve], rows: int) -> list[TestCurve]:
    """Return tests of about ``rows`` rows in all, evenly taken."""
    total = sum(len(test.stretch) for test in tests)
    if total <= rows:
        return list(tests)
    share = rows / total
    return [test.thinned(max(int(len(test.stretch) * share), 8)) for test in tests]
