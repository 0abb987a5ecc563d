"""``hf fit --model orthotropic``: one energy for the sheet, from all its tests together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fit.identify import (
    Setting,
    deviation,
    near_zero,
    reference_of,
    temperatures_of,
    tested,
    with_deviation,
)
from hyperfab.chapters.fit.readings import Readings
from hyperfab.chapters.fit.siblings import curves_csv, grid_of, line
from hyperfab.chapters.fit.whole import WholeFit
from hyperfab.chapters.look import named
from hyperfab.curve import TestCurve, angle_named, largest_stress
from hyperfab.documents.material import (
    Direction,
    FitFigures,
    MaterialDocument,
    Parameters,
    StableRange,
    Undetermined,
)
from hyperfab.materials.identification.quality import Certainty
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.grips import SHORT, at_readings
from hyperfab.materials.orthotropic.identify import Found, identify
from hyperfab.materials.orthotropic.specimen import stable_range, stress
from hyperfab.report.figures_fit import fit_figure

#: Below this share of its test's largest stress a reading counts by its absolute error: the slack start of a knit is
#: as uncertain as the rest, and a ratio to next to nothing says little.
_FLOOR = 0.1
_MODES = ("uniaxial", "shear", "biaxial")
#: The constants that change places in a sheet turned by a quarter.
_TURNED = {
    "k1_warp_MPa": "k1_weft_MPa",
    "k1_weft_MPa": "k1_warp_MPa",
    "k2_warp": "k2_weft",
    "k2_weft": "k2_warp",
}


@dataclass(frozen=True)
class SheetFit(WholeFit[Orthotropic]):
    """The energy of a sheet; a direction is a view of it. ``optima`` are the fits at each temperature."""

    optima: tuple[Found, ...]

    @property
    def directions(self) -> list[str]:
        """The directions the specimens were cut in, by name."""
        return list(dict.fromkeys(curve.direction_name for curve in self.curves if curve.direction_name is not None))

    @property
    def accepted(self) -> bool:
        """Whether each direction's rms error, each reading weighted as in the fit, is within the limit."""
        ways: list[str | None] = [*self.directions] or [None]
        rows = self.setting.used(self.curves)
        used = [[c for c in rows if way is None or c.direction_name in (way, None)] for way in ways]
        return all(self._weighted(curves) <= self.setting.accept for curves in used if curves)

    @property
    def stable(self) -> bool:
        """Whether the law is Drucker-stable over the stretches of the tests, in every direction that was tested."""
        return all(
            stable_range(self.law_at(c.temperature), c.mode, c.direction or 0.0, float(c.stretch.max()))[1]
            >= float(c.stretch.max()) - 1e-9
            for c in self.curves
            if c.mode in _MODES
        )

    @property
    def gripped(self) -> list[str]:
        """Say which strips were taken as held in their grips."""
        kinds = {(c.direction, c.aspect) for c in self.curves if c.aspect is not None and c.aspect < SHORT}
        return [
            f"strips at {angle:g} deg, {aspect:.2g} times as long as wide, are held in their grips, which stiffens "
            "them: that is found by the law, and no shear of the sheet"
            for angle, aspect in sorted(kinds, key=str)
            if angle is not None and angle % 90.0
        ]

    def direction(self, name: str) -> Direction:
        """Return the law as seen along a direction (the weft's is turned by a quarter), with its tests' figures."""
        own = [curve for curve in self.curves if curve.direction_name in (name, None)]
        return Direction(
            parameters=self._seen(self.law, name),
            fit=self._figures(own, turned=name == "weft"),
            stability=self._stability(name, own),
            tested=tested(own, self.setting),
            temperatures=self.constants(
                lambda law: self._seen(law, name), lambda number: self.certainty(number, turned=name == "weft")
            ),
        )

    def _seen(self, law: Orthotropic, name: str) -> Parameters:
        return dict((law.turned() if name == "weft" else law).parameters)

    def predict(self, curve: TestCurve) -> tuple[Array, Array | None, Array | None]:
        """Return nominal stresses [MPa] along and across, and the lateral stretch of a uniaxial test."""
        law, angle = self.law_at(curve.temperature), curve.direction
        along, across, width = stress(law, curve.mode, angle or 0.0, curve.stretch, curve.stretch2)
        if curve.mode == "uniaxial":
            along = along * at_readings(law, angle, curve.aspect, curve.stretch)
        return along, across, width

    def _figures(self, curves: Sequence[TestCurve], turned: bool = False) -> FitFigures:
        groups = {mode: [c for c in curves if c.mode == mode] for mode in dict.fromkeys(c.mode for c in curves)}
        return self.figures_of(curves, groups, self.certainty(self.reference, turned), curves, (1.0,))

    @property
    def figures(self) -> FitFigures:
        return self._figures(self.curves)

    def certainty(self, number: int, turned: bool = False) -> Certainty:
        """Return how sure the constants at one of the temperatures are, of the sheet ``turned`` by a quarter.

        Those the tests hold at the end of their range, as threads of no stress, are left out.
        """
        found = self.optima[number]
        moving = np.flatnonzero(np.abs(found.optimum.jacobian).max(axis=0) > 0.0)
        names = [found.sought[k] for k in moving]
        signs = [-1.0 if turned and name == "bias_deg" else 1.0 for name in names]
        optimum = replace(found.optimum, jacobian=found.optimum.jacobian[:, moving] * signs)
        seen = [_TURNED.get(name, name) if turned else name for name in names]
        return self.sure_of(optimum, seen, self.fitted_at(number))

    def _weighted(self, curves: Sequence[TestCurve]) -> float:
        if not self.setting.relative:
            found = self.error(curves)
            return np.inf if found is None else found.nrmse
        errors = [
            (self.predict(curve)[0] - curve.stress) * _weight(curve, curve.stress, self.setting, curves)
            for curve in curves
        ]
        return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))

    def _stability(self, name: str | None, curves: Sequence[TestCurve]) -> dict[str, StableRange]:
        angle = angle_named(name) or 0.0
        reach = {mode: max((float(c.stretch.max()) for c in curves if c.mode == mode), default=None) for mode in _MODES}
        found = {}
        for mode, largest in reach.items():
            low, high, ended_by = stable_range(self.law, mode, angle, 3.0 * (largest or 1.0))
            found[mode] = StableRange(
                stretch_min=low,
                stretch_max=high,
                ended_by=ended_by,
                first_unstable_stretch=high if ended_by == "instability" else None,
                stable_over_data=None if largest is None else high >= largest - 1e-9,
            )
        return found

    @property
    def stability(self) -> dict[str, StableRange]:
        return self._stability(None, self.curves)

    def along(self) -> dict[str, Direction]:
        return {name: self.direction(name) for name in self.directions}

    def ranges(self, document: MaterialDocument) -> Iterator[tuple[TestCurve, tuple[float, float] | None]]:
        """Return every curve, and the range of all tests: one energy carries them."""
        known = document.tested_stretch()
        yield from ((curve, known) for curve in self.curves)

    def curves_csv(self) -> bytes:
        return curves_csv(((curve, self.predict(curve)) for curve in self.curves), self.setting.fit_on)

    def picture(self) -> bytes:
        """Return the PNG of the fit: a panel a direction, readings as marks, the law as lines."""
        panels = []
        ways: list[str | None] = [*self.directions] or [None]
        for name in ways:
            own = [curve for curve in self.curves if name is None or curve.direction_name in (name, None)]
            lines = []
            for mode in _MODES:
                for temperature in self.temperatures:
                    curves = [c for c in own if c.mode == mode and c.is_at(temperature)]
                    if not curves:
                        continue
                    grid = grid_of(curves, 101, 1.0)
                    there = replace(
                        curves[0], temperature=temperature, stretch=grid, stress=grid, stretch2=None, stress2=None
                    )
                    lines.append(line(curves, temperature, (grid, self.predict(there)[0]), self.setting.fit_on))
            panels.append((f"{Orthotropic.name}{', ' + name if name else ''}", lines))
        return fit_figure(panels)


def fit_sheet(curves: Sequence[TestCurve], setting: Setting) -> SheetFit:
    """Return the law of the sheet for ``curves``.

    All constants are sought at the temperature nearest to room; at the others its stresses alone, so that constants
    between tested temperatures mean something. Raises InputError where rows lack, or no stable law is found though
    one is asked for.
    """
    curves = _as_held(curves)
    used = setting.used(curves)
    temperatures = temperatures_of(used)
    reference = reference_of(temperatures)
    first = identify(_tests(used, temperatures[reference], setting))
    optima = [
        first if k == reference else identify(_tests(used, t, setting), near=first.law)
        for k, t in enumerate(temperatures)
    ]
    laws = tuple(one.law for one in optima)
    unknown = [Undetermined(constant=one.name, value=one.value, test=one.test) for one in first.unknown]
    fit = SheetFit(laws, temperatures, reference, curves, setting, unknown, tuple(optima))
    fit.refuse_unstable("fit a smaller range of stretch")
    return fit


def along_axes(readings: Readings) -> list[TestCurve]:
    """Return the curves, the first axis of general biaxial tests that state no direction taken as the warp.

    Their axes are those of the sheet whether or not the file says which is the warp; that it is taken so is said.
    """
    curves = [
        replace(curve, direction=0.0) if curve.mode == "biaxial-general" and curve.direction is None else curve
        for curve in readings.curves
    ]
    taken = [new.source for new, old in zip(curves, readings.curves, strict=True) if new is not old]
    if taken:
        readings.preparation.append(f"{named(taken)}: no direction is stated, the first axis is taken as the warp")
    return curves


def _as_held(curves: Sequence[TestCurve]) -> list[TestCurve]:
    """Return the curves, those of strips held in their grips only where all slanted ones are cut at one angle.

    What the grips add to it would be taken for the shear of the sheet. Strips at several angles tell the shear by
    how they differ, and are taken as uniform.
    """
    uniaxial = {curve.direction for curve in curves if curve.mode == "uniaxial"}
    slanted = {angle for angle in uniaxial if angle is not None and angle % 90.0}
    return list(curves) if len(slanted) == 1 else [replace(curve, aspect=None) for curve in curves]


def _tests(curves: Sequence[TestCurve], temperature: float | None, setting: Setting) -> list[TestCurve]:
    own = [with_deviation(curve, setting.noise) for curve in curves if curve.is_at(temperature)]
    found = []
    for curve in own:
        alike = [other for other in own if (other.mode, other.direction_name) == (curve.mode, curve.direction_name)]
        weight = _weight(curve, curve.stress, setting, alike)
        second = curve.stress2 if curve.mode.startswith("biaxial") else None
        weight2 = None if second is None else _weight(curve, second, setting, alike)
        if curve.mode == "uniaxial" and curve.stretch2 is not None:
            # The width's error counts against the largest contraction of its direction as, in an absolute fit, that of
            # the stress does against the largest stress.
            widths = [other.stretch2 for other in alike if other.stretch2 is not None]
            largest = max(float(np.abs(width - 1.0).max()) for width in widths)
            counts = 1.0 if setting.relative else largest_stress(alike) * float(weight.mean())
            weight2 = np.full(len(curve.stretch), counts / max(largest, 1e-6))
        found.append(replace(curve, weight=weight, stress2=second, weight2=weight2))
    return found


def _weight(curve: TestCurve, stress: Array, setting: Setting, alike: Sequence[TestCurve]) -> Array:
    """Return one over the error that counts as one [1/MPa]."""
    peak = largest_stress(alike)
    sd = deviation(curve, setting.noise)
    if not setting.relative:
        return np.full(len(stress), 1.0 / peak) if sd is None else np.ones_like(stress) / sd
    floor = np.maximum(_FLOOR * peak, near_zero(curve, setting.noise))
    return np.asarray(1.0 / np.maximum(np.abs(stress), floor))
