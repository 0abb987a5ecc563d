"""Tests of a fabric as a problem of the loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hyperfab.loop.catalogue import catalogue
from hyperfab.loop.catalogue.fabric.scene import Scene
from hyperfab.loop.fabric_start import best_by_law
from hyperfab.loop.problem import HAS_IT, Array, Constant, Curve, Extra, Problem
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import MODE_NAMES, UNIAXIAL, Path
from hyperfab.materials.law import Law

_SMOOTH_DEGREE = 5


@dataclass(frozen=True)
class FabricTest:
    """One measured curve: what was done and what was read; nan where unknown.

    ``transverse`` is the measured second stretch: of a general biaxial test what the sheet was given, of a uniaxial
    one what it did.
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


@dataclass
class FabricProblem(Problem):
    """A law with constants, terms it already has, and the measured tests.

    Rows of channel 0 are stresses; those of channel 1 transverse stretches of uniaxial tests (``transverse_rows``).
    """

    fabric: Fabric = field(kw_only=True)
    tests: Sequence[FabricTest] = field(kw_only=True)
    law: Law = field(kw_only=True)
    both: bool = field(default=False, kw_only=True)
    held: Mapping[str, tuple[str, tuple[float, ...]]] = field(default_factory=dict, kw_only=True)
    transverse_rows: Array = field(default_factory=lambda: np.empty(0, dtype=np.int64), kw_only=True)
    remake: object = field(default=None, kw_only=True)

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return stresses [MPa], then transverse stretches."""
        count = len(self.law.names)
        warp = own[:count]
        weft = own[count : 2 * count] if self.both else None
        at = count * (2 if self.both else 1)
        given: dict[str, tuple[str, Array]] = {}
        for name, (form, null) in self.held.items():
            given[name] = (form, own[at : at + len(null)])
            at += len(null)
        given.update(terms)
        stress = self.fabric.stress(warp, weft, given)
        if len(self.transverse_rows) == 0:
            return stress
        return np.concatenate([stress, self.fabric.across(given)[self.transverse_rows]])

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
        part, span = np.abs(np.diff(path.stretch[rows])), np.diff(time[rows])
        speed[rows] = float(np.sum(part)) / max(float(np.sum(span[part > 1e-9])), 1e-12)
    return path, speed


def _clock(test: FabricTest) -> Array:
    """Return the time of each row; from the rate where that alone is known."""
    if test.time_s is not None and np.all(np.isfinite(test.time_s)):
        return np.asarray(test.time_s - test.time_s[0], dtype=np.float64)
    if test.rate_1_s is None or not np.all(np.asarray(test.rate_1_s) > 0.0):
        return np.full(len(test.stretch), np.nan)
    step = np.abs(np.diff(test.stretch)) / np.asarray(test.rate_1_s)[1:]
    return np.concatenate([[0.0], np.cumsum(step)])


def _curves(path: Path, tests: Sequence[FabricTest], stress: Array) -> tuple[tuple[Curve, ...], Array, Array]:
    curves, rows, extra = [], [], []
    at = len(stress)
    for test, place in zip(tests, path.curves, strict=True):
        up = path.up[place]
        cuts = tuple(int(i) for i in place.start + 1 + np.flatnonzero(np.diff(up) != 0))
        time = path.time_s[place]
        rising = bool(np.all(np.isfinite(time)) and np.all(np.diff(time) > 0.0))
        abscissa = time if rising else path.stretch[place]
        setup = _setup(test, up)
        specimen = test.specimen or test.name
        lam = path.stretch[place]
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


def _setup(test: FabricTest, up: NDArray[np.int64]) -> str:
    """Return what replicates share: mode, direction, temperature, rate, turns and reach, rounded."""
    temperature = "-" if test.temperature_degC is None else f"{float(np.mean(test.temperature_degC)):.0f}"
    speed = "-" if test.rate_1_s is None else f"{float(np.median(test.rate_1_s)):.2g}"
    if speed == "-" and test.time_s is not None:
        moved = float(np.sum(np.abs(np.diff(test.stretch))))
        span = float(test.time_s[-1] - test.time_s[0])
        # Hand-driven machines: within a factor of about two the pace counts as one.
        speed = f"2^{round(np.log2(max(moved / span, 1e-12)) / 2.0):.0f}" if span > 0.0 else "-"
    turns = int(np.count_nonzero(np.diff(up)))
    most = round(float(np.log(np.max(test.stretch))) / 0.1)
    return f"{MODE_NAMES[test.mode]} {test.angle_deg:.0f} {temperature} {speed} {turns} {most}"


def _states(path: Path, tests: Sequence[FabricTest], speed: Array) -> dict[str, Array]:
    cycle = np.ones(len(path.stretch))
    for rows, test in zip(path.curves, tests, strict=True):
        if test.cycle is not None:
            cycle[rows] = test.cycle
        else:
            up = path.up[rows]
            cycle[rows] = 1.0 + np.concatenate([[0], np.cumsum((up[1:] > 0) & (up[:-1] < 0))])
    return {
        "stretch": path.stretch,
        "branch": path.up.astype(np.float64),
        "cycle": cycle,
        "time_s": path.time_s,
        "log rate": np.log(np.maximum(speed, 1e-12)),
        "temperature_degC": path.temperature_degC,
        "direction_deg": path.angle_deg,
        "mode": path.mode.astype(np.float64),
    }


def _nuisance(path: Path, rows: int) -> Array:
    """Return polynomials of the strain, a set for each mode in the data: what a poor elastic law leaves."""
    columns = []
    for mode in np.unique(path.mode):
        there = path.mode == mode
        reach = max(float(np.max(path.stretch[there])) - 1.0, 1e-9)
        strain = np.where(there, (path.stretch - 1.0) / reach, 0.0)
        columns += [strain**power for power in range(1, _SMOOTH_DEGREE + 1)]
    found = np.zeros((rows, len(columns)))
    found[: len(path.stretch)] = np.stack(columns, axis=1)
    return found
