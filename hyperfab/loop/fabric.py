"""Tests of a fabric as a problem of the loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from hyperfab.loop.catalogue import catalogue
from hyperfab.loop.catalogue.fabric.scene import Scene
from hyperfab.loop.fabric_start import best_by_law
from hyperfab.loop.problem import HAS_IT, Array, Constant, Curve, Extra, Problem
from hyperfab.loop.thresholds import MACHINE, SAME_WAY
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import GENERAL, MODE_NAMES, UNIAXIAL, Path, held, moving, uniaxial_pull
from hyperfab.materials.law import Law

_SMOOTH_DEGREE = 5
#: Effects that have a say in the stiffness at rest, the strain it is told at, and the least of it, as a share of the
#: stiffness that the tests end with: no sheet lengthens without a force.
_ELASTIC, _STEP, _LEAST = ("anisotropy", "elastic-law"), 1e-4, 1e-3


@dataclass(frozen=True)
class FabricTest:
    """One measured curve: what was done and what was read; nan where unknown.

    ``transverse`` is the measured second stretch: of a general biaxial test what the sheet was given, of a uniaxial
    one what it did. ``others`` are numbers known of the test that no law has a use for, by name.
    """

    name: str
    mode: int
    stretch: Array
    stress: Array
    transverse: Array | None = None
    time_s: Array | None = None
    rate_1_s: Array | None = None
    temperature_degC: Array | None = None
    angle_deg: float = np.nan
    branch: Array | None = None
    cycle: Array | None = None
    specimen: str = ""
    stress_sd: Array | None = None
    others: Mapping[str, float] = field(default_factory=dict)


@dataclass
class FabricProblem(Problem):
    """A law with constants, terms it already has, and the measured tests.

    Rows of channel 0 are stresses; those of channel 1 transverse stretches of uniaxial tests (``transverse_rows``).
    """

    least_noise: ClassVar[float] = MACHINE
    fabric: Fabric = field(kw_only=True)
    tests: Sequence[FabricTest] = field(kw_only=True)
    law: Law = field(kw_only=True)
    both: bool = field(default=False, kw_only=True)
    held: Mapping[str, tuple[str, tuple[float, ...]]] = field(default_factory=dict, kw_only=True)
    transverse_rows: Array = field(default_factory=lambda: np.empty(0, dtype=np.int64), kw_only=True)
    remake: object = field(default=None, kw_only=True)

    def of_own(self, own: Array) -> tuple[Array, Array | None, dict[str, tuple[str, Array]]]:
        """Return the law's constants along warp and weft (None: alike), and the terms the model already has."""
        count = len(self.law.names)
        at = count * (2 if self.both else 1)
        had: dict[str, tuple[str, Array]] = {}
        for name, (form, null) in self.held.items():
            had[name] = (form, own[at : at + len(null)])
            at += len(null)
        return own[:count], own[count : 2 * count] if self.both else None, had

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return stresses [MPa], then transverse stretches."""
        warp, weft, had = self.of_own(own)
        given = {**had, **terms}
        stress = self.fabric.stress(warp, weft, given)
        if len(self.transverse_rows) == 0:
            return stress
        return np.concatenate([stress, self.fabric.across(given, warp)[self.transverse_rows]])

    @property
    def look_alikes(self) -> Sequence[frozenset[str]]:
        """Effects that only second pulls, or several rates and holds, tell apart: all of them make one loop."""
        scene = Scene(self.law, (), self.fabric.path, self.measured)
        if not scene.unloads or scene.pulls_again:
            return ()
        same = {"hysteresis", "mullins", "permanent-set"}
        return (frozenset(same if scene.several_rates else {*same, "rate"}),)

    def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much the modulus at rest along each direction tested falls short of what a sheet has.

        In units of the stiffness these tests show at their ends.
        """
        warp, weft, had = self.of_own(own)
        elastic = {name: term for name, term in {**had, **terms}.items() if name in _ELASTIC}
        if elastic.get("anisotropy", ("",))[0] == "threads":
            # The ground of a sheet of threads is stable where none of its constants is below zero.
            ground = dict(zip(self.law.names, map(float, warp), strict=True))
            asked = {name: max(-value / self._secant, 0.0) for name, value in ground.items()}
            soft = 6.0 * (ground.get("C10_MPa", 0.0) + ground.get("C2_MPa", 0.0) / 3.0) / self._secant
            return asked | {"Young's modulus at rest of the ground": max(_LEAST - soft, 0.0)}
        stress = self._at_rest.stress(warp, weft, elastic)
        modulus = stress / _STEP / self._secant
        return {
            f"Young's modulus at rest{_along(angle)}": max(_LEAST - float(value), 0.0)
            for angle, value in zip(self._at_rest.path.angle_deg, modulus, strict=True)
        }

    @cached_property
    def _at_rest(self) -> Fabric:
        known = np.unique(self.fabric.path.angle_deg[np.isfinite(self.fabric.path.angle_deg)])
        angles = known if len(known) else np.array([np.nan])
        pull = uniaxial_pull(np.full(len(angles), 1.0 + _STEP))
        return Fabric(self.law, replace(pull, angle_deg=angles), self.fabric.reference_degC)

    @cached_property
    def _secant(self) -> float:
        path = self.fabric.path
        far = np.abs(path.stretch - 1.0)
        first = self.measured[: len(far)]
        return float(np.max(np.abs(first)) / max(float(np.max(far)), 1e-9)) or 1.0

    def extras(self) -> Sequence[Extra]:
        """Return tests that could be done next, each with the problem it would make."""
        from hyperfab.loop.fabric_extras import menu

        found = []
        for text, details, test in menu(self.tests):
            problem = self.remake([*self.tests, test])  # type: ignore[operator]
            if np.all(np.isfinite(self.fabric.path.time_s)) == np.all(
                np.isfinite(problem.fabric.path.time_s)
            ):
                found.append(Extra(text, details, problem))
        return found


def _along(angle: float) -> str:
    if not np.isfinite(angle):
        return ""
    return {0.0: " along the warp", 90.0: " along the weft"}.get(float(angle), f" at {angle:g} degrees")


def fabric_problem(
    law: Law,
    warp: Sequence[float],
    tests: Sequence[FabricTest],
    *,
    weft: Sequence[float] | None = None,
    held: Mapping[str, tuple[str, tuple[Constant, ...]]] | None = None,
    fixed: Sequence[str] = (),
    prior: float | None = None,
    reference_degC: float | None = None,
    units: tuple[str, ...] = ("MPa", ""),
) -> FabricProblem:
    """Return the problem of tests of a fabric whose model is ``law`` with constants ``warp`` (and ``weft``).

    ``held`` are the effects the model already has; their constants are refitted along with the law's. ``fixed`` names
    constants that stay. ``prior`` is one relative standard deviation of the law's constants, None: they are free.
    """
    path, speed = _path(tests)
    known = path.temperature_degC[np.isfinite(path.temperature_degC)]
    reference = (
        reference_degC if reference_degC is not None else (float(np.min(known)) if len(known) else 20.0)
    )
    fabric = Fabric(law, path, reference, speed)
    stress = np.concatenate([test.stress for test in tests])
    held = held or {}
    own = _own(law, warp, "" if weft is None else "warp ", float(np.max(np.abs(stress))), fixed, prior)
    if weft is not None:
        own += _own(law, weft, "weft ", float(np.max(np.abs(stress))), fixed, prior)
    for _, constants in held.values():
        own += constants
    curves, rows, measured = _curves(path, tests, stress)
    scene = Scene(law, tuple(warp), path, stress, weft is not None, len(rows) > 0)
    effects = tuple(
        replace(effect, not_sought=HAS_IT) if effect.id in held else effect
        for effect in catalogue("fabric", scene)
    )
    stated = None
    if all(test.stress_sd is not None for test in tests):
        stated = np.concatenate([test.stress_sd for test in tests] + [np.full(len(rows), np.nan)])

    def remake(others: Sequence[FabricTest]) -> FabricProblem:
        return fabric_problem(
            law, warp, others, weft=weft, held=held, fixed=fixed, prior=prior, reference_degC=reference, units=units
        )  # fmt: skip

    return FabricProblem(
        measured=measured,
        curves=curves,
        own=own,
        effects=effects,
        states=_states(path, tests, speed),
        stated_sd=stated,
        nuisance=_nuisance(path, len(measured)),
        units=units,
        starts=best_by_law(law, path, stress, own, 1 if weft is None else 2),
        fabric=fabric,
        tests=tuple(tests),
        law=law,
        both=weft is not None,
        held={name: (form, tuple(c.value for c in constants)) for name, (form, constants) in held.items()},
        transverse_rows=rows,
        remake=remake,
    )


def _own(
    law: Law, values: Sequence[float], prefix: str, size: float, fixed: Sequence[str], prior: float | None
) -> tuple[Constant, ...]:
    found = []
    for name, value in zip(law.names, values, strict=True):
        low, high = -np.inf, np.inf
        scale = max(abs(value), 0.01 * size if name in law.stresses else 0.1)
        sd = np.inf if prior is None else max(prior * abs(value), 1e-9 * size)
        if name in law.held or name in fixed or f"{prefix}{name}" in fixed:
            low = high = value
        found.append(Constant(f"{prefix}{name}", value, low, high, scale, sd))
    return tuple(found)


def _path(tests: Sequence[FabricTest]) -> tuple[Path, Array]:
    def column(name: str) -> Array:
        parts = []
        for test in tests:
            value = getattr(test, name)
            parts.append(
                np.full(len(test.stretch), np.nan) if value is None else np.asarray(value, dtype=np.float64)
            )
        return np.concatenate(parts)

    count = [len(test.stretch) for test in tests]
    time = np.concatenate([_clock(test) for test in tests])
    path = Path(
        starts=tuple(int(v) for v in np.concatenate([[0], np.cumsum(count)])),
        mode=np.repeat([test.mode for test in tests], count),
        stretch=column("stretch"),
        across=column("transverse"),
        time_s=time,
        temperature_degC=column("temperature_degC"),
        angle_deg=np.repeat([float(test.angle_deg) for test in tests], count),
        branch=np.nan_to_num(column("branch")).astype(np.int64),
    )
    speed = column("rate_1_s")
    for rows in path.curves:
        if np.all(np.isfinite(speed[rows])) or not np.all(np.isfinite(time[rows])):
            continue
        part, span = np.abs(np.diff(path.moved(rows))), np.diff(time[rows])
        speed[rows] = float(np.sum(part)) / max(float(np.sum(span[part > 1e-9])), 1e-12)
    return path, speed


def _clock(test: FabricTest) -> Array:
    """Return the time of each row; from the rate where that alone is known."""
    if test.time_s is not None and np.all(np.isfinite(test.time_s)):
        return np.asarray(test.time_s - test.time_s[0], dtype=np.float64)
    if test.rate_1_s is None or not np.all(np.asarray(test.rate_1_s) > 0.0):
        return np.full(len(test.stretch), np.nan)
    stretch = test.stretch
    if test.mode == GENERAL and test.transverse is not None:
        stretch = moving(stretch, test.transverse)
    step = np.abs(np.diff(stretch)) / np.asarray(test.rate_1_s)[1:]
    return np.concatenate([[0.0], np.cumsum(step)])


def _curves(path: Path, tests: Sequence[FabricTest], stress: Array) -> tuple[tuple[Curve, ...], Array, Array]:
    curves, rows, extra = [], [], []
    at = len(stress)
    setups = _setups(path, tests)
    for test, place, setup in zip(tests, path.curves, setups, strict=True):
        up = path.up[place]
        corners = (np.diff(up) != 0) | (np.diff(held(path.moved(place)).astype(np.int64)) != 0)
        cuts = tuple(int(i) for i in place.start + 1 + np.flatnonzero(corners))
        time = path.time_s[place]
        rising = bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0))
        specimen = test.specimen or test.name
        lam = path.moved(place)
        abscissa = time if rising else lam
        curves.append(Curve(test.name, place.start, place.stop, abscissa, cuts, setup, specimen, place=lam))
        if test.mode == UNIAXIAL and test.transverse is not None and np.all(np.isfinite(test.transverse)):
            count = place.stop - place.start
            rows.append(np.arange(place.start, place.stop))
            extra.append(test.transverse)
            shifted = tuple(cut - place.start + at for cut in cuts)
            curves.append(
                Curve(f"{test.name} transverse", at, at + count, abscissa, shifted, setup, specimen, 1, lam)
            )
            at += count
    if not rows:
        return tuple(curves), np.empty(0, dtype=np.int64), stress
    order = sorted(curves, key=lambda curve: curve.start)
    return tuple(order), np.concatenate(rows), np.concatenate([stress, *extra])


def _setups(path: Path, tests: Sequence[FabricTest]) -> list[str]:
    """Return what each test shares with its replicates: the whole way it was led, in both stretches."""
    found: list[tuple[str, Array, str]] = []
    for test, rows in zip(tests, path.curves, strict=True):
        how, way = _pace(test, path.moved(rows)), _way(path, rows)
        like = (name for same, other, name in found if same == how and _is_same_way(way, other))
        found.append((how, way, next(like, f"{how} {len(found)}")))
    return [name for _, _, name in found]


def _pace(test: FabricTest, stretch: Array) -> str:
    """Return mode, direction, temperature and rate of a test, rounded."""
    temperature = "-" if test.temperature_degC is None else f"{float(np.mean(test.temperature_degC)):.0f}"
    speed = "-" if test.rate_1_s is None else f"{float(np.median(test.rate_1_s)):.2g}"
    if speed == "-" and test.time_s is not None:
        moved = float(np.sum(np.abs(np.diff(stretch))))
        span = float(test.time_s[-1] - test.time_s[0])
        # Hand-driven machines: within a factor of about two the pace counts as one.
        speed = f"2^{round(np.log2(max(moved / span, 1e-12)) / 2.0):.0f}" if span > 0.0 else "-"
    return f"{MODE_NAMES[test.mode]} {test.angle_deg:.0f} {temperature} {speed}"


def _way(path: Path, rows: slice) -> Array:
    """Return the strains (turns, 2) at which a test turned and ended, along the pull and across where that is given."""
    up = path.up[rows]
    ends = rows.start + np.concatenate([np.flatnonzero(np.diff(up) != 0), [len(up) - 1]])
    across = np.where(path.mode[ends] == GENERAL, path.across[ends], 1.0)
    return np.log(np.stack([path.stretch[ends], across], axis=1))


def _is_same_way(one: Array, other: Array) -> bool:
    """Whether two tests turned at the same places, but for a share of how far they went."""
    if one.shape != other.shape:
        return False
    far = max(float(np.max(np.abs(one))), float(np.max(np.abs(other))))
    return float(np.max(np.abs(one - other))) <= SAME_WAY * far


def _states(path: Path, tests: Sequence[FabricTest], speed: Array) -> dict[str, Array]:
    cycle = np.ones(len(path.stretch))
    for rows, test in zip(path.curves, tests, strict=True):
        if test.cycle is not None:
            cycle[rows] = test.cycle
        else:
            up = path.up[rows]
            cycle[rows] = 1.0 + np.concatenate([[0], np.cumsum((up[1:] > 0) & (up[:-1] < 0))])
    others = dict.fromkeys(name for test in tests for name in test.others)
    count = [len(test.stretch) for test in tests]
    return {
        "stretch": path.stretch,
        "branch": path.up.astype(np.float64),
        "cycle": cycle,
        "time_s": path.time_s,
        "log rate": np.log(np.maximum(speed, 1e-12)),
        "temperature_degC": path.temperature_degC,
        "direction_deg": path.angle_deg,
        "mode": path.mode.astype(np.float64),
        **{name: np.repeat([test.others.get(name, np.nan) for test in tests], count) for name in others},
    }


def _nuisance(path: Path, rows: int) -> Array:
    """Return polynomials of the strain, a set for each mode in the data: what a poor elastic law leaves."""
    columns = []
    for mode in np.unique(path.mode):
        there = path.mode == mode
        reach = max(float(np.max(path.stretch[there])) - 1.0, 1e-9)
        strain = np.where(there, (path.stretch - 1.0) / reach, 0.0)
        columns += [strain**power for power in range(1, _SMOOTH_DEGREE + 1)]
        if mode == GENERAL:
            other = np.where(there, path.across - 1.0, 0.0) / max(float(np.ptp(path.across[there])), 1e-9)
            columns += [strain**m * other**n for m in range(3) for n in range(1, 3)]
    found = np.zeros((rows, len(columns)))
    found[: len(path.stretch)] = np.stack(columns, axis=1)
    return found
