"""``hf fit --model hyperfoam-N``: the law of a compressible foam from all its tests together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hyperfab.chapters.fit.identify import ROOM, Setting
from hyperfab.chapters.fit.reading import Reading
from hyperfab.chapters.fit.readings import Readings
from hyperfab.chapters.tested import tested_by
from hyperfab.documents.material import (
    AtTemperature,
    FitFigures,
    MaterialDocument,
    StableRange,
    TestFigures,
    Undetermined,
)
from hyperfab.errors import InputError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.materials.hyperfoam import FoamTest, Hyperfoam, Rows, identify
from hyperfab.materials.identification.quality import Figures, figures
from hyperfab.report.figures_fit import Line, fit_figure

Array = NDArray[np.float64]

#: A Poisson's ratio this near to what bounds it was not found by the tests.
_EDGE = 0.005
#: Steps of the scan of stable stretches, and how far beyond the tests it goes.
_SCAN, _BEYOND = 200, 1.5


@dataclass(frozen=True)
class FoamFit:
    """The law at each of ``temperatures`` (one, None, where the tests tell none), at ``reference`` in full."""

    laws: tuple[Hyperfoam, ...]
    temperatures: tuple[float | None, ...]
    reference: int
    curves: Sequence[Reading]
    setting: Setting

    @property
    def law(self) -> Hyperfoam:
        """The law at the reference temperature."""
        return self.laws[self.reference]

    def law_at(self, temperature: float | None) -> Hyperfoam:
        """Return the law of a temperature that was fitted."""
        known = dict(zip(self.temperatures, self.laws, strict=True))
        return known.get(temperature, self.law)

    def predict(self, curve: Reading) -> Array:
        """Return the stress [MPa] at each row."""
        return self.law_at(curve.temperature).stress(curve.mode, curve.stretch, curve.stretch2)

    @cached_property
    def figures(self) -> FitFigures:
        """The figures over all rows fitted, and of every test; pulling and pressing are told apart."""
        parts = {curve.mode: [c for c in self.curves if c.mode == curve.mode] for curve in self.curves}
        both = {side: _side(parts.get("uniaxial", []), side) for side in ("compression", "tension")}
        if all(both.values()):
            parts |= both
        tests = {}
        for name, own in parts.items():
            predicted = None if own[0].mode in self.setting.fit_on else True
            stretch = np.concatenate([curve.stretch for curve in own])
            tests[name] = TestFigures(
                **vars(self._error(own)),
                stretch_min=float(stretch.min()),
                stretch_max=float(stretch.max()),
                predicted=predicted,
            )
        total = self._error([curve for curve in self.curves if curve.mode in self.setting.fit_on])
        return FitFigures(**vars(total), tests=tests)

    @cached_property
    def accepted(self) -> bool:
        """Whether the rms error of each test that was fitted, over its largest stress, is within the limit."""
        tests = self.figures.tests.values()
        errors = [one.nrmse for one in tests if isinstance(one, TestFigures) and not one.predicted]
        return max(errors) <= self.setting.accept

    @property
    def stability(self) -> dict[str, StableRange]:
        """The stretches of each test from rest over which the law is stable."""
        found = {}
        for mode in dict.fromkeys(curve.mode for curve in self.curves):
            if mode in ("biaxial-general", "volumetric", "simple-shear"):
                continue
            own = np.concatenate([c.stretch for c in self.curves if c.mode == mode])
            ends = [
                self._stable_end(mode, end)
                for end in (min(float(own.min()), 1.0), max(float(own.max()), 1.0))
            ]
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
        return (
            (float(stretch[-1]), True)
            if good.all()
            else (float(stretch[max(int(np.argmin(good)) - 1, 0)]), False)
        )

    @property
    def undetermined(self) -> list[Undetermined]:
        """Poisson's ratios that stand at the end of their range: the tests say little of the sides."""
        return [
            Undetermined(constant=f"nu{i + 1}", value=nu, test="uniaxial with measured lateral stretch")
            for i, nu in enumerate(self.law.nu)
            if nu > 0.5 - _EDGE or (nu < _EDGE and min(self.law.mu) >= 0.0)
        ]

    def _error(self, curves: Sequence[Reading]) -> Figures:
        found = figures(
            np.concatenate([curve.stress for curve in curves]),
            np.concatenate([self.predict(curve) for curve in curves]),
        )
        if found is None:
            raise InputError(
                "the law has no state of rest of the specimen on these rows", file=curves[0].source
            )
        return found

    def document(self, readings: Readings) -> MaterialDocument:
        """Return the material document."""
        rows = [
            AtTemperature(temperature_degC=t, parameters=law.parameters)
            for t, law in zip(self.temperatures, self.laws, strict=True)
            if t is not None
        ]
        ranges = (
            (c.mode, np.exp(np.arcsinh(0.5 * c.stretch)) if c.mode == "simple-shear" else c.stretch, c.warmth)
            for c in self.curves
            if c.mode in self.setting.fit_on
        )
        return MaterialDocument(
            model=self.law.name,
            parameters=self.law.parameters,
            thickness_mm=readings.thickness,
            thickness_nominal=readings.nominal or None,
            temperature_degC=self.temperatures[self.reference],
            temperatures=rows if len(rows) > 1 else None,
            fit=self.figures,
            stability=self.stability,
            stable=self.stable,
            accepted=self.accepted,
            objective="absolute",
            fit_on=list(self.setting.fit_on),
            left_out=dict(sorted(readings.left_out.items())) or None,
            preparation=readings.preparation or None,
            bulk_modulus_MPa=readings.bulk_modulus,
            undetermined=self.undetermined or None,
            tested=tested_by(ranges),
            warnings=readings.warnings or None,
            effects=[],
        )

    def curves_csv(self) -> bytes:
        """Return every reading with what the law says beside it."""
        rows = []
        for curve in self.curves:
            model, across = self.predict(curve), [None] * len(curve.stretch)
            if curve.mode == "uniaxial":
                across = self.law_at(curve.temperature).lateral(curve.mode, curve.stretch).tolist()
            start = [curve.mode, curve.temperature, curve.specimen]
            for k, stretch in enumerate(curve.stretch):
                rows.append(
                    [
                        *start,
                        stretch,
                        across[k],
                        curve.stress[k],
                        model[k],
                        curve.mode not in self.setting.fit_on,
                    ]
                )
        header = ("test", "temperature_degC", "specimen", "stretch", "stretch_2_model", "stress_MPa",
                  "stress_model_MPa", "predicted")  # fmt: skip
        return csv_bytes(header, rows)

    def picture(self) -> bytes:
        """Return the PNG of the fit, a panel a test; in simple shear the stretch is the shear strain."""
        panels = []
        for mode in dict.fromkeys(curve.mode for curve in self.curves):
            lines = []
            for temperature in dict.fromkeys(c.temperature for c in self.curves if c.mode == mode):
                own = [c for c in self.curves if c.mode == mode and c.temperature == temperature]
                stretch = np.concatenate([c.stretch for c in own])
                grid = np.linspace(stretch.min(), stretch.max(), 121)
                general = mode == "biaxial-general"
                model = replace(own[0], stretch=stretch if general else grid)
                lines.append(
                    Line(
                        label=mode if temperature is None else f"{mode} {temperature:g} °C",
                        mode=mode,
                        stretch=stretch,
                        stress=np.concatenate([c.stress for c in own]),
                        grid=model.stretch,
                        model=np.concatenate([self.predict(c) for c in own])
                        if general
                        else self.predict(model),
                        predicted=mode not in self.setting.fit_on,
                        unstable_from=None,
                    )
                )
            panels.append((f"{self.law.name}, {mode}", lines))
        return fit_figure(panels)


def fit_foam(readings: Readings, setting: Setting, terms: int) -> FoamFit:
    """Return the law of ``terms`` terms: all constants at the temperature nearest to room, at others its stresses.

    Raises InputError where there are fewer rows than constants, or it is not stable though that is asked for.
    """
    volumetric = [
        Reading("volumetric", t.source, t.stretch, np.sign(t.stretch - 1.0) * np.abs(t.stress))
        for t in readings.volumetric
    ]
    curves = [*readings.curves, *volumetric]
    chosen = (*setting.fit_on, "volumetric") if set(setting.fit_on) == set(readings.modes) else setting.fit_on
    setting = replace(setting, fit_on=tuple(one for one in chosen if any(c.mode == one for c in curves)))
    used = [curve for curve in curves if curve.mode in setting.fit_on]
    count = sum(len(curve.stretch) for curve in used)
    if count < 3 * terms:
        raise InputError(
            f"{count} rows do not tell {3 * terms} constants",
            file=used[0].source,
            remedy="give more rows or tests",
        )
    temperatures: tuple[float | None, ...] = tuple(
        sorted({curve.temperature for curve in used if curve.temperature is not None})
    ) or (None,)
    distance = [abs((t if t is not None else ROOM) - ROOM) for t in temperatures]
    reference = distance.index(min(distance))
    first = identify(_tests(used, temperatures[reference]), terms)
    laws = [
        first if k == reference else identify(_tests(used, t), terms, near=first)
        for k, t in enumerate(temperatures)
    ]
    fit = FoamFit(tuple(laws), temperatures, reference, curves, setting)
    if setting.stable and not fit.stable:
        raise InputError(
            f"no constants of {first.name} could be shown to be stable over the data",
            file=used[0].source,
            remedy="leave --stable out, or take fewer terms",
        )
    return fit


def _side(curves: Sequence[Reading], side: str) -> list[Reading]:
    """Return the rows of uniaxial tests in ``compression`` or in ``tension``."""
    parts = [c.take(c.stretch < 1.0 if side == "compression" else c.stretch > 1.0) for c in curves]
    return [part for part in parts if len(part.stretch)]


def _tests(curves: Sequence[Reading], temperature: float | None) -> list[FoamTest]:
    """Return the tests at a temperature.

    Errors count by their share of the test's largest stress, compression and tension each by its own: a foam's first
    stiffness says little of its plateau, and a ratio to it less. Every test counts the same however many rows it has.
    """
    own = [curve for curve in curves if curve.temperature in (temperature, None)]
    split = [
        part
        for c in own
        for side in ("compression", "tension")
        for part in _side([c], side)
        if c.mode == "uniaxial"
    ]
    split += [c for c in own if c.mode != "uniaxial"]
    found = []
    for curve in split:
        alike = [other for other in split if _kind(other) == _kind(curve)]
        share = 1.0 / np.sqrt(sum(len(other.stretch) for other in alike))
        weight = np.full(len(curve.stretch), 1.0 / max(float(np.abs(other.stress).max()) for other in alike))
        lateral = curve.stretch2 if curve.mode == "uniaxial" else None
        widest = 0.0 if lateral is None else float(np.abs(lateral - 1.0).max())
        found.append(
            FoamTest(
                curve.mode,
                curve.stretch,
                curve.stress,
                weight * share,
                stretch2=curve.stretch2 if curve.mode == "biaxial-general" else None,
                lateral=lateral,
                lateral_weight=float(share) / max(widest, 1e-3),
            )
        )
        if curve.mode == "biaxial-general" and curve.stretch2 is not None and curve.stress2 is not None:
            turned = replace(curve, stretch=curve.stretch2, stretch2=curve.stretch, stress=curve.stress2)
            other = FoamTest(
                curve.mode, turned.stretch, turned.stress, weight * share, stretch2=turned.stretch2
            )
            found.append(other)
    return found


def _kind(curve: Reading) -> tuple[str, bool]:
    return curve.mode, bool(curve.stretch[0] < 1.0)
