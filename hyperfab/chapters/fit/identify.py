"""The constants of one law for a set of curves, and what they say about every test at hand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.look import tested_by
from hyperfab.curve import TestCurve
from hyperfab.documents.material import Tested
from hyperfab.materials import Material
from hyperfab.materials.identification import Fit, Problem, Rows, fit_law
from hyperfab.materials.identification.quality import Certainty, Figures, certainty, figures
from hyperfab.materials.law import Law
from hyperfab.materials.modes import MODES, SIMPLE_SHEAR, nominal_stress, way
from hyperfab.materials.stability import Range, stable_at, stable_over, stable_ranges

#: The temperature [degC] a material is described at, where tests were made at several.
ROOM = 23.0

#: Where the noise is known, a reading below this many of its standard deviations counts by its absolute error.
NOISY = 10.0


@dataclass(frozen=True)
class Setting:
    """How constants are sought: the tests that take part, what is minimised, the noise of a reading [MPa]."""

    fit_on: tuple[str, ...]
    relative: bool
    stable: bool
    accept: float
    noise: float | None = None

    def used(self, curves: Iterable[TestCurve]) -> list[TestCurve]:
        """Return the curves that take part in the fit."""
        return [curve for curve in curves if curve.mode in self.fit_on]


@dataclass(frozen=True)
class Identified:
    """One law on one set of curves.

    ``materials`` are the constants at each of ``temperatures`` (one, None, where the tests tell none); ``reference``
    is the number of the one the material is described at. ``every_range`` has the stable stretches of each mode at
    each temperature; ``stable`` says whether the constants of all of them are stable over the tests. ``tests`` has the
    figures of every test, None where it reaches beyond the law's limit. ``along`` is the direction that is the
    materials' first axis; None is the warp.
    """

    law: Law
    fit: Fit
    materials: tuple[Material, ...]
    temperatures: tuple[float | None, ...]
    reference: int
    total: Figures
    per_temperature: tuple[Figures | None, ...]
    tests: dict[str, tuple[Figures | None, int, bool]]
    certainties: tuple[Certainty, ...]
    every_range: tuple[dict[str, Range], ...]
    stable: bool
    along: str | None = None
    specimens: int = 0

    @property
    def certainty(self) -> Certainty:
        """How sure the constants at the reference temperature are."""
        return self.certainties[self.reference]

    @property
    def ranges(self) -> dict[str, Range]:
        """The stable stretches of each mode at the reference temperature."""
        return self.every_range[self.reference]

    @property
    def material(self) -> Material:
        """The constants at the reference temperature."""
        return self.materials[self.reference]


def identify(law: Law, curves: Sequence[TestCurve], setting: Setting) -> Identified | str:
    """Return the best constants of ``law`` for ``curves``, or why there are none."""
    used = setting.used(curves)
    temperatures = temperatures_of(used)
    reference = reference_of(temperatures)
    if not law.isotropic and (wrong := _misses_directions(used)):
        return wrong
    if any(curve.mode == SIMPLE_SHEAR for curve in curves) and not law.carries_simple_shear:
        return "it carries no test in simple shear"
    rows = _rows(used, temperatures, setting, law)
    problem = Problem(law, rows)
    wanted = len(problem.free) * rows.groups + len(problem.axes)
    if len(rows) < wanted:
        return f"{wanted} constants need as many rows, the tests fitted have {len(rows)}"
    fit = fit_law(problem, reach(curves) if setting.stable else None, pairs=pairs(law, curves))
    if fit is None:
        such = " that are stable over the data" if setting.stable else ""
        return f"the law cannot carry these stretches with constants in its box{such}"
    measured, model = rows.stress, _model_stress(fit, rows)
    floor = _floor(used, setting)
    total = figures(measured, model, floor)
    if total is None:
        return "the law has no finite stress on these rows"
    ranges = tuple(stable_ranges(material) for material in fit.materials)
    stable = _stable(fit.materials, ranges, pairs(law, curves), curves)
    if setting.stable and not stable:
        return "no constants in its box could be shown to be stable over the data"
    per_temperature = [
        figures(measured[own], model[own], floor[own]) for own in (rows.group == g for g in range(rows.groups))
    ]
    specimens, kinds = [specimen_of(one) for one in used], [kind_of(one) for one in used]
    deviation = _stated(used, setting)
    sure = [certainty(fit, g, specimens, kinds, deviation) for g in range(rows.groups)]
    found = Identified(
        law=law,
        fit=fit,
        materials=fit.materials,
        temperatures=temperatures,
        reference=reference,
        total=total,
        per_temperature=tuple(per_temperature),
        tests={},
        certainties=tuple(sure),
        every_range=ranges,
        stable=stable,
        specimens=len(set(specimens)),
    )
    found.tests.update({mode: _test(found, mode, curves, setting) for mode in _modes(curves)})
    return found


def along_direction(found: Identified, name: str, curves: Sequence[TestCurve], setting: Setting) -> Identified:
    """Return an anisotropic law as seen along one direction of the fabric, with the figures of its tests alone."""
    sure, materials = found.certainties, found.materials
    if name == "weft":
        materials = tuple(material.turned() for material in materials)
        order = [int(k) for k in found.law.turned(list(range(len(found.law.names))))]
        sure = tuple(one.reordered(order) for one in sure)
    ranges = tuple(stable_ranges(material) for material in materials)
    both = pairs(found.law, curves)
    part = replace(
        found,
        materials=materials,
        certainties=sure,
        every_range=ranges,
        stable=_stable(materials, ranges, both[:, ::-1] if name == "weft" else both, curves),
        along=name,
        tests={},
    )
    part.tests.update({mode: _test(part, mode, curves, setting) for mode in _modes(curves)})
    used = setting.used(curves)
    own = [predict(part, curve)[0] for curve in used]
    total = figures(
        np.concatenate([curve.stress for curve in used]),
        np.concatenate(own),
        np.concatenate([near_zero(curve, setting.noise) * setting.relative for curve in used]),
    )
    return part if total is None else replace(part, total=total)


def without_test(found: Identified, mode: str, curves: Sequence[TestCurve], setting: Setting) -> Figures | None:
    """Return how constants fitted without the test ``mode``, near those of all, predict it; None if they cannot."""
    rest = [curve for curve in setting.used(curves) if curve.mode != mode]
    temperatures = temperatures_of(rest)
    rows = _rows(rest, temperatures, setting, found.law)
    problem = Problem(found.law, rows)
    if len(rows) < len(problem.free) * rows.groups + len(problem.axes):
        return None
    fit = fit_law(
        problem,
        reach(curves) if setting.stable else None,
        near=found.material.theta,
        pairs=pairs(found.law, curves),
    )
    if fit is None:
        return None
    again = replace(found, materials=fit.materials, temperatures=temperatures, reference=reference_of(temperatures))
    return _test(again, mode, curves, setting)[0]


def _rows(used: Sequence[TestCurve], temperatures: Sequence[float | None], setting: Setting, law: Law) -> Rows:
    """Gather the rows to fit; linear constants are shared by the curves of one temperature."""
    reference = reference_of(temperatures)
    groups = [temperatures.index(curve.temperature) if curve.temperature is not None else reference for curve in used]
    return Rows.of([_weighted(curve, setting) for curve in used], groups, [_axis(law, curve) for curve in used])


def predict(found: Identified, curve: TestCurve) -> tuple[Array, Array | None]:
    """Return the stress [MPa] the constants give at the rows of a curve, along both directions where both are known."""
    material = found.materials[nearest(found.temperatures, curve.temperature, found.reference)]
    if _axis(found.law, curve) == 2 and found.along != "weft":
        material = material.turned()
    elif curve.mode == "biaxial-general" and curve.direction_name is None and found.along == "weft":
        material = material.turned()  # where none is stated the first axis is the warp
    if curve.stretch2 is not None and curve.mode == "biaxial-general":
        answer = material.membrane(curve.stretch, curve.stretch2)
        return answer.P1, answer.P2
    return nominal_stress(material, curve.mode, curve.stretch), None


def compared(answers: Iterable[tuple[TestCurve, Array, Array | None]]) -> tuple[Array, Array]:
    """Return the stresses of the readings of curves, and those a law answers along one axis or both, row by row."""
    measured, model = [], []
    for curve, one, two in answers:
        measured.append(curve.stress)
        model.append(one)
        if two is not None and curve.stress2 is not None:
            measured.append(curve.stress2)
            model.append(two)
    return np.concatenate(measured), np.concatenate(model)


def reach(curves: Sequence[TestCurve]) -> dict[str, tuple[float, float]]:
    """Return the smallest and largest stretch of each mode at hand, rest included."""
    found: dict[str, tuple[float, float]] = {}
    for curve in curves:
        mode, stretch = way(curve.mode), curve.principal
        if mode in MODES:
            low, high = found.get(mode, (1.0, 1.0))
            found[mode] = min(low, float(stretch.min())), max(high, float(stretch.max()))
    return found


def pairs(law: Law, curves: Sequence[TestCurve]) -> Array:
    """Return the stretches along the law's first axis and across it (n, 2) at the rows of general biaxial tests."""
    found = [
        np.stack([curve.stretch, curve.stretch2], axis=1)[:, :: -1 if _axis(law, curve) == 2 else 1]
        for curve in curves
        if curve.mode == "biaxial-general" and curve.stretch2 is not None
    ]
    return np.concatenate([np.ones((0, 2)), *found])


def _stable(
    materials: Sequence[Material],
    ranges: Sequence[dict[str, Range]],
    states: Array,
    curves: Sequence[TestCurve],
) -> bool:
    """Whether the constants at every temperature are stable over the stretches of the tests, and at ``states``."""
    return all(
        stable_over(one, reach(curves)) and stable_at(material, states)
        for material, one in zip(materials, ranges, strict=True)
    )


def tested(curves: Sequence[TestCurve], setting: Setting) -> dict[str, Tested] | None:
    """Return the range of the tests that take part in the fit."""
    return tested_by(setting.used(curves))


def temperatures_of(curves: Sequence[TestCurve]) -> tuple[float | None, ...]:
    """Return the temperatures [degC] of the curves, rising; one, None, where they tell none."""
    return tuple(sorted({curve.temperature for curve in curves if curve.temperature is not None})) or (None,)


def reference_of(temperatures: Sequence[float | None]) -> int:
    """Return the number of the temperature a material is described at: the one nearest to that of a room."""
    return nearest(temperatures, ROOM, 0)


def nearest(temperatures: Sequence[float | None], wanted: float | None, otherwise: int) -> int:
    """Return the number of the temperature nearest to the one wanted; ``otherwise`` where either is unknown."""
    known = [(abs(wanted - t), k) for k, t in enumerate(temperatures) if wanted is not None and t is not None]
    return min(known)[1] if known else otherwise


def specimen_of(curve: TestCurve) -> tuple[str, str | None]:
    return curve.source, curve.specimen


def kind_of(curve: TestCurve) -> tuple[str, bool, str | None, float | None]:
    """Specimens of one test, pulled or pressed, of one direction and temperature are replicates."""
    pressed = curve.mode != SIMPLE_SHEAR and bool(curve.stretch.mean() < 1.0)
    return curve.mode, pressed, curve.direction_name, curve.temperature


def _misses_directions(used: Sequence[TestCurve]) -> str | None:
    directions = {curve.direction_name for curve in used}
    other = sorted(name for name in directions if name not in ("warp", "weft", None))
    if other:
        return f"its fibres lie along warp and weft, a test at {other[0]} cannot take part"
    return None if {"warp", "weft"} <= directions else "its fibres need tests along warp and weft"


def _axis(law: Law, curve: TestCurve) -> int:
    return 2 if not law.isotropic and curve.direction_name == "weft" else 1


def deviation(reading: TestCurve, noise: float | None) -> Array | float | None:
    """Return the standard deviation [MPa] of the readings of a curve: what it states, else the ``noise``."""
    return reading.stress_sd if reading.stress_sd is not None else noise


def with_deviation(curve: TestCurve, noise: float | None) -> TestCurve:
    """Return the curve with the deviation of each reading where it is stated, by itself or by the ``noise``."""
    sd = deviation(curve, noise)
    return curve if sd is None else replace(curve, stress_sd=np.broadcast_to(sd, curve.stress.shape))


def near_zero(reading: TestCurve, noise: float | None) -> Array:
    """Return the stress [MPa] below which each reading of a curve counts by its absolute error; 0: always relative."""
    sd = deviation(reading, noise)
    return np.broadcast_to(NOISY * np.asarray(0.0 if sd is None else sd), reading.stress.shape)


def _floor(used: Sequence[TestCurve], setting: Setting) -> Array:
    """Return the same for each row of ``Rows.of``; 0 in an absolute fit, whose figures are relative all the same."""
    noise = setting.noise
    return np.concatenate(
        [
            np.tile(near_zero(curve, noise) * setting.relative, 2 if curve.mode == "biaxial-general" else 1)
            for curve in used
        ]
    )


def _stated(used: Sequence[TestCurve], setting: Setting) -> Array | None:
    """Return the standard deviation [MPa] of each row of ``Rows.of``, None where it is not stated of all."""
    found = []
    for curve in used:
        sd = deviation(curve, setting.noise)
        if sd is None:
            return None
        each = np.broadcast_to(sd, curve.stress.shape)
        found += [each, each] if curve.mode == "biaxial-general" else [each]
    return np.concatenate(found)


def _weighted(reading: TestCurve, setting: Setting) -> TestCurve:
    sd = deviation(reading, setting.noise)

    def weight(stress: Array) -> Array:
        if not setting.relative:
            return np.ones_like(stress) if sd is None else np.ones_like(stress) / sd
        return 1.0 / np.maximum(np.abs(stress), near_zero(reading, setting.noise))

    second = None if reading.stress2 is None else weight(reading.stress2)
    return replace(reading, weight=weight(reading.stress), weight2=second)


def _modes(curves: Sequence[TestCurve]) -> list[str]:
    return list(dict.fromkeys(curve.mode for curve in curves))


def _model_stress(fit: Fit, rows: Rows) -> Array:
    """Return the stress of each row, from the very constants that are written."""
    stress = np.full(len(rows), np.nan)
    for number, material in enumerate(fit.materials):
        own = rows.group == number
        sheet = rows.take(np.flatnonzero(own)).sheet(material.law.contraction(material.theta))
        answer = material.membrane(sheet.l1, sheet.l2)
        stress[own] = np.where(rows.along[own] == 1, answer.P2, answer.P1) * rows.share[own]
    return stress


def _test(
    found: Identified, mode: str, curves: Sequence[TestCurve], setting: Setting
) -> tuple[Figures | None, int, bool]:
    own = [curve for curve in curves if curve.mode == mode]
    rows, model = compared((curve, *predict(found, curve)) for curve in own)
    return figures(rows, model, _floor(own, setting)), len(rows), mode not in setting.fit_on
