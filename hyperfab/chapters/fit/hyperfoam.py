"""``hf fit --model hyperfoam-N``: the law of a compressible foam from all its tests together; and of a plateau that is
flatter than any stable law's the loading as a table for the press."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hyperfab.chapters.fit.identify import Setting, kind_of, reference_of, temperatures_of, with_deviation
from hyperfab.chapters.fit.readings import Readings
from hyperfab.chapters.fit.siblings import curves_csv, grid_of, line
from hyperfab.chapters.fit.whole import Answer, WholeFit
from hyperfab.curve import TestCurve, largest_stress
from hyperfab.documents.material import FitFigures, MaterialDocument, StableRange, TestFigures, Undetermined
from hyperfab.errors import InputError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.materials.hyperfoam import Hyperfoam, Rows
from hyperfab.materials.identification.hyperfoam import identify, optimum
from hyperfab.materials.identification.plateau import Plateau, plateau, table_of
from hyperfab.materials.identification.quality import Certainty
from hyperfab.materials.rest import beyond_isotropy
from hyperfab.report.figures_fit import fit_figure

#: A Poisson's ratio this near to what bounds it was not found by the tests.
_EDGE = 0.005
#: Steps of the scan of stable stretches, and how far beyond the tests it goes.
_SCAN, _BEYOND = 200, 1.5
#: A foam is pressed or pulled.
_SIDES = ("compression", "tension")
#: A side of rest that a test goes to by less than this share of its strain on the other is no test of its own: the
#: gauge length is read to some thousandths.
_SLIGHT = 0.05


@dataclass(frozen=True)
class FoamFit(WholeFit[Hyperfoam]):
    """The energy of a foam; pulling and pressing are told apart. ``flat`` is a plateau that no stable law has."""

    flat: Plateau | None

    def predict(self, curve: TestCurve) -> Answer:
        """Return the stress [MPa] at each row, and the lateral stretch of a uniaxial test."""
        law = self.law_at(curve.temperature)
        across = law.lateral(curve.mode, curve.stretch) if curve.mode == "uniaxial" else None
        return law.stress(curve.mode, curve.stretch, curve.stretch2), None, across

    @cached_property
    def figures(self) -> FitFigures:
        parts = {curve.mode: [c for c in self.curves if c.mode == curve.mode] for curve in self.curves}
        both = {side: _side(parts.get("uniaxial", []), side) for side in _SIDES}
        groups = parts | both if all(both.values()) else parts
        return self.figures_of(self.curves, groups, self.certainty(self.reference), self.setting.used(self.curves))

    def alike(self, curves: Sequence[TestCurve]) -> Sequence[TestCurve]:
        return _by_side(curves)

    def certainty(self, number: int) -> Certainty:
        told = [with_deviation(curve, self.setting.noise) for curve in self.fitted_at(number)]
        tests = _tests(told, self.temperatures[number])
        names, weighed = optimum(self.laws[number], tests, kept=number != self.reference)
        return self.sure_of(weighed, names, tests)

    @cached_property
    def accepted(self) -> bool:
        """Whether the rms error of each test that was fitted, over its largest stress, is within the limit."""
        tests = self.figures.tests.values()
        errors = [one.nrmse for one in tests if isinstance(one, TestFigures) and not one.predicted]
        return max(errors) <= self.setting.accept

    @property
    def stability(self) -> dict[str, StableRange]:
        found = {}
        for mode in dict.fromkeys(curve.mode for curve in self.curves):
            if mode in ("biaxial-general", "volumetric", "simple-shear"):
                continue
            own = np.concatenate([c.stretch for c in self.curves if c.mode == mode])
            ends = [self._stable_end(mode, end) for end in (min(float(own.min()), 1.0), max(float(own.max()), 1.0))]
            (low, low_ok), (high, high_ok) = ends
            found[mode] = StableRange(
                stretch_min=low,
                stretch_max=high,
                ended_by="scan" if low_ok and high_ok else "instability",
                first_unstable_stretch=None if high_ok else high,
                stable_over_data=low <= own.min() + 1e-9 and high >= own.max() - 1e-9,
            )
        return found

    @cached_property
    def stable(self) -> bool:
        """Whether the law is stable at every state of the tests."""
        with np.errstate(all="ignore"):
            return all(
                bool(law.stable(Rows.of(curve.mode, curve.stretch, curve.stretch2).strain(law)).all())
                for curve in self.curves
                for law in (self.law_at(curve.temperature),)
            )

    def _stable_end(self, mode: str, end: float) -> tuple[float, bool]:
        """Return how far towards ``end`` and beyond the law is stable, and whether to the end of the scan."""
        far = np.log(end) * _BEYOND if end != 1.0 else 0.0
        stretch = np.exp(np.linspace(0.0, far, _SCAN))
        with np.errstate(all="ignore"):
            good = self.law.stable(Rows.of(mode, stretch).strain(self.law))
        return (float(stretch[-1]), True) if good.all() else (float(stretch[max(int(np.argmin(good)) - 1, 0)]), False)

    def ranges(self, document: MaterialDocument) -> Iterator[tuple[TestCurve, tuple[float, float] | None]]:
        """Return the curves fitted, each with the range of its own kind of test; a shear strain is no stretch."""
        for curve in self.setting.used(self.curves):
            if curve.mode not in ("simple-shear", "volumetric"):
                yield curve, document.tested_stretch(test=curve.mode)

    def curves_csv(self) -> bytes:
        told = ((curve, self.predict(curve)) for curve in self.curves)
        return curves_csv(told, self.setting.fit_on, ("direction", "stretch_2"))

    def table(self) -> tuple[bytes, float] | None:
        """Return the loading of the tests whose plateau no stable law has as ``compression`` of foam.toml reads it, at
        the law's temperature, and by which share of its peak it was levelled; None where a law has it."""
        if self.flat is None:
            return None
        own = [c for c in self.setting.used(self.curves) if c.is_at(self.temperatures[self.reference])]
        mode = self.flat.mode if any(c.mode == self.flat.mode for c in own) else own[0].mode
        strain, stress, levelled = table_of(own, mode)
        rows = [(0.0, 0.0), *zip(strain.tolist(), stress.tolist(), strict=True)]
        return csv_bytes(["strain [-]", "stress [MPa]"], rows), levelled

    def picture(self) -> bytes:
        """Return the PNG of the fit, a panel a test; in simple shear the stretch is the shear strain."""
        panels = []
        for mode in dict.fromkeys(curve.mode for curve in self.curves):
            lines = []
            for temperature in dict.fromkeys(c.temperature for c in self.curves if c.mode == mode):
                own = [c for c in self.curves if c.mode == mode and c.temperature == temperature]
                if mode == "biaxial-general":  # the stretch across is its own in each row
                    there = [(c.stretch, self.predict(c)[0]) for c in own]
                    model = np.concatenate([a for a, _ in there]), np.concatenate([b for _, b in there])
                else:
                    grid = grid_of(own, 121)
                    model = grid, self.predict(replace(own[0], stretch=grid))[0]
                lines.append(line(own, temperature, model, self.setting.fit_on))
            panels.append((f"{self.law.name}, {mode}", lines))
        return fit_figure(panels)


def fit_foam(readings: Readings, setting: Setting, terms: int) -> FoamFit:
    """Return the law of ``terms`` terms: all constants at the temperature nearest to room, at others its stresses.

    Raises InputError where there are fewer rows than constants, or it is not stable though that is asked for.
    """
    volumetric = [
        TestCurve("volumetric", t.stretch, np.sign(t.stretch - 1.0) * np.abs(t.stress), source=t.source)
        for t in readings.volumetric
    ]
    curves = [*readings.curves, *volumetric]
    chosen = (*setting.fit_on, "volumetric") if set(setting.fit_on) == set(readings.modes) else setting.fit_on
    setting = replace(setting, fit_on=tuple(one for one in chosen if any(c.mode == one for c in curves)))
    used = setting.used(curves)
    count = sum(len(curve.stretch) for curve in used)
    if count < 3 * terms:
        raise InputError(
            f"{count} rows do not tell {3 * terms} constants",
            file=used[0].source,
            remedy="give more rows or tests",
        )
    flat = plateau(used)
    readings.warnings.extend([] if flat is None else [str(flat)])
    temperatures = temperatures_of(used)
    reference = reference_of(temperatures)
    apart = beyond_isotropy(one for one in used if one.is_at(temperatures[reference]))
    readings.warnings.extend([] if apart is None else [apart])
    first = identify(_tests(used, temperatures[reference]), terms)
    laws = [
        first if k == reference else identify(_tests(used, t), terms, near=first) for k, t in enumerate(temperatures)
    ]
    # Poisson's ratios at the end of their range or below zero, and no lateral stretch read: the tests say little of
    # the sides.
    law = laws[reference]
    sides_told = any(curve.contraction is not None for curve in used)
    unknown = [
        Undetermined(constant=f"nu{i + 1}", value=nu, test="uniaxial with measured lateral stretch")
        for i, nu in enumerate(law.nu)
        if not sides_told and (nu > 0.5 - _EDGE or nu < (_EDGE if min(law.mu) >= 0.0 else 0.0))
    ]
    fit = FoamFit(tuple(laws), temperatures, reference, curves, setting, unknown, flat)
    fit.refuse_unstable("take fewer terms")
    return fit


def _side(curves: Sequence[TestCurve], side: str) -> list[TestCurve]:
    """Return the rows of uniaxial tests in ``compression`` or in ``tension``, slight ones with the other side."""
    sign = 1.0 if side == "tension" else -1.0
    parts = []
    for curve in curves:
        strain = sign * np.log(curve.stretch)
        here, there = max(float(strain.max()), 0.0), max(-float(strain.min()), 0.0)
        own = strain > 0.0 if there > _SLIGHT * here else strain != 0.0
        parts += [curve.take(own)] if here > _SLIGHT * there and own.any() else []
    return parts


def _by_side(curves: Sequence[TestCurve]) -> list[TestCurve]:
    """Return uniaxial tests in parts, pressed and pulled, and the others as they are."""
    split = [part for c in curves if c.mode == "uniaxial" for side in _SIDES for part in _side([c], side)]
    return split + [c for c in curves if c.mode != "uniaxial"]


def _tests(curves: Sequence[TestCurve], temperature: float | None) -> list[TestCurve]:
    """Return the tests at a temperature.

    Errors count by their share of the test's largest stress, compression and tension each by its own: a foam's first
    stiffness says little of its plateau, and a ratio to it less. Every test counts the same however many rows it has.
    """
    split = _by_side([curve for curve in curves if curve.is_at(temperature)])
    found = []
    for curve in split:
        alike = [other for other in split if kind_of(other)[:2] == kind_of(curve)[:2]]
        share = 1.0 / np.sqrt(sum(len(other.stretch) for other in alike))
        weight = np.full(len(curve.stretch), 1.0 / largest_stress(alike))
        widest = 0.0 if curve.contraction is None else float(np.abs(curve.contraction - 1.0).max())
        weight2 = np.full(len(weight), float(share) / max(widest, 1e-3))
        weighed = replace(curve, weight=weight * share, weight2=weight2)
        found.append(weighed)
        if curve.mode == "biaxial-general" and curve.stretch2 is not None and curve.stress2 is not None:
            found.append(replace(weighed, stretch=curve.stretch2, stretch2=curve.stretch, stress=curve.stress2))
    return found
