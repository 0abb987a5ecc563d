"""``hf fit --model orthotropic``: one energy for the sheet, from all its tests together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hyperfab.chapters.fit.identify import NOISY, ROOM, Setting, tested
from hyperfab.chapters.fit.reading import Reading
from hyperfab.documents.material import (
    AtTemperature,
    Direction,
    FitFigures,
    Parameters,
    StableRange,
    TestFigures,
    Undetermined,
    Unpredicted,
)
from hyperfab.errors import InputError
from hyperfab.io.csv_write import csv_bytes
from hyperfab.materials.identification.quality import Figures, figures
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.identify import Found, SheetTest, identify
from hyperfab.materials.orthotropic.specimen import stable_range, stress
from hyperfab.report.figures_fit import Line, fit_figure

Array = NDArray[np.float64]

NAME = "orthotropic"
#: Below this share of its test's largest stress a reading counts by its absolute error: the slack start of a knit is
#: as uncertain as the rest, and a ratio to next to nothing says little.
_FLOOR = 0.1
_MODES = ("uniaxial", "shear", "biaxial")
_NAMED = {"warp": 0.0, "weft": 90.0}


@dataclass(frozen=True)
class SheetFit:
    """The law at each of ``temperatures`` (one, None, where the tests tell none), at ``reference`` in full."""

    found: Found
    laws: tuple[Orthotropic, ...]
    temperatures: tuple[float | None, ...]
    reference: int
    curves: Sequence[Reading]
    setting: Setting

    @property
    def law(self) -> Orthotropic:
        """The law at the reference temperature."""
        return self.laws[self.reference]

    def law_at(self, temperature: float | None) -> Orthotropic:
        """Return the law of the nearest temperature that was fitted."""
        known = [
            (abs(temperature - t), k)
            for k, t in enumerate(self.temperatures)
            if t is not None and temperature is not None
        ]
        return self.laws[min(known)[1]] if known else self.law

    @property
    def undetermined(self) -> list[Undetermined]:
        """The constants that no test here speaks of."""
        return [Undetermined(constant=one.name, value=one.value, test=one.test) for one in self.found.unknown]

    @property
    def directions(self) -> list[str]:
        """The directions the specimens were cut in, by name."""
        return list(dict.fromkeys(curve.direction for curve in self.curves if curve.direction is not None))

    @property
    def accepted(self) -> bool:
        """Whether each direction's rms error, each reading weighted as in the fit, is within the limit."""
        ways: list[str | None] = [*self.directions] or [None]
        used = [[c for c in self._used if way is None or c.direction in (way, None)] for way in ways]
        return all(self._weighted(curves) <= self.setting.accept for curves in used if curves)

    @property
    def stable(self) -> bool:
        """Whether the law is Drucker-stable over the stretches of the tests, in every direction that was tested."""
        return all(
            stable_range(self.law_at(c.temperature), c.mode, _angle(c) or 0.0, float(c.stretch.max()))[1]
            >= float(c.stretch.max()) - 1e-9
            for c in self.curves
            if c.mode in _MODES
        )

    @property
    def figures(self) -> FitFigures:
        """The figures over all rows fitted, and of every test."""
        return self._figures(self.curves)

    def direction(self, name: str) -> Direction:
        """Return the law as seen along a direction (the weft's is turned by a quarter), with its tests' figures."""
        own = [curve for curve in self.curves if curve.direction in (name, None)]
        return Direction(
            parameters=self._seen(self.law, name),
            fit=self._figures(own),
            stability=self._stability(name, own),
            tested=tested(own, self.setting),
            temperatures=self._temperatures(lambda law: self._seen(law, name)),
        )

    @property
    def stability(self) -> dict[str, StableRange]:
        """The stretches of each mode, along the warp, over which the law is stable."""
        return self._stability(None, self.curves)

    @property
    def at_temperatures(self) -> list[AtTemperature] | None:
        """The constants at each temperature of the tests, where there are several."""
        return self._temperatures(lambda law: dict(law.parameters))

    def _seen(self, law: Orthotropic, name: str) -> Parameters:
        return dict((law.turned() if name == "weft" else law).parameters)

    def _temperatures(self, seen: Callable[[Orthotropic], Parameters]) -> list[AtTemperature] | None:
        rows = [
            AtTemperature(temperature_degC=t, parameters=seen(law))
            for t, law in zip(self.temperatures, self.laws, strict=True)
            if t is not None
        ]
        return rows if len(rows) > 1 else None

    @property
    def _used(self) -> list[Reading]:
        return [curve for curve in self.curves if curve.mode in self.setting.fit_on]

    def predict(self, curve: Reading) -> tuple[Array, Array | None, Array | None]:
        """Return nominal stresses [MPa] along and across, and the lateral stretch of a uniaxial test."""
        return _predict(self.law_at(curve.temperature), curve)

    def _figures(self, curves: Sequence[Reading]) -> FitFigures:
        tests: dict[str, TestFigures | Unpredicted] = {}
        for mode in dict.fromkeys(curve.mode for curve in curves):
            own = [curve for curve in curves if curve.mode == mode]
            predicted = None if mode in self.setting.fit_on else True
            found = self._error(own)
            points = sum(len(curve.stretch) for curve in own)
            if found is None:
                status = "no equilibrium of the specimen at these stretches"
                tests[mode] = Unpredicted(points=points, predicted=predicted, status=status)
                continue
            reach = [np.append(curve.stretch, 1.0) for curve in own]
            tests[mode] = TestFigures(
                **vars(found),
                stretch_min=float(np.concatenate(reach).min()),
                stretch_max=float(np.concatenate(reach).max()),
                predicted=predicted,
            )
        total = self._error([curve for curve in curves if curve.mode in self.setting.fit_on])
        if total is None:
            raise InputError("the law has no finite stress on these rows", file=curves[0].source)
        return FitFigures(**vars(total), tests=tests)

    def _error(self, curves: Sequence[Reading]) -> Figures | None:
        measured, model = [], []
        for curve in curves:
            one, two, _ = self.predict(curve)
            measured.append(curve.stress)
            model.append(one)
            if two is not None and curve.stress2 is not None:
                measured.append(curve.stress2)
                model.append(two)
        return figures(np.concatenate(measured), np.concatenate(model)) if measured else None

    def _weighted(self, curves: Sequence[Reading]) -> float:
        if not self.setting.relative:
            found = self._error(curves)
            return np.inf if found is None else found.nrmse
        errors = [
            (self.predict(curve)[0] - curve.stress) * _weight(curve, curve.stress, self.setting, curves)
            for curve in curves
        ]
        return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))

    def _stability(self, name: str | None, curves: Sequence[Reading]) -> dict[str, StableRange]:
        angle = 0.0 if name is None else _NAMED[name] if name in _NAMED else float(name.split()[0])
        reach = {
            mode: max((float(c.stretch.max()) for c in curves if c.mode == mode), default=None)
            for mode in _MODES
        }
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

    def curves_csv(self) -> bytes:
        """Return every reading with what the law says beside it."""
        rows = []
        for curve in self.curves:
            one, two, width = self.predict(curve)
            start = [curve.mode, curve.direction, curve.temperature, curve.specimen]
            predicted = curve.mode not in self.setting.fit_on
            second = curve.stretch2 if curve.stretch2 is not None else [None] * len(curve.stretch)
            for k, stretch in enumerate(curve.stretch):
                lateral = None if width is None else width[k]
                rows.append([*start, stretch, second[k], lateral, curve.stress[k], one[k], predicted])
                if two is not None and curve.stress2 is not None:
                    rows.append([*start, second[k], stretch, None, curve.stress2[k], two[k], predicted])
        header = ("test", "direction", "temperature_degC", "specimen", "stretch", "stretch_2", "stretch_2_model",
                  "stress_MPa", "stress_model_MPa", "predicted")  # fmt: skip
        return csv_bytes(header, rows)

    def picture(self) -> bytes:
        """Return the PNG of the fit: a panel a direction, readings as marks, the law as lines."""
        panels = []
        ways: list[str | None] = [*self.directions] or [None]
        for name in ways:
            own = [curve for curve in self.curves if name is None or curve.direction in (name, None)]
            lines = []
            for mode in _MODES:
                for temperature in self.temperatures:
                    curves = [c for c in own if c.mode == mode and c.temperature in (temperature, None)]
                    if not curves:
                        continue
                    stretches = np.concatenate([c.stretch for c in curves])
                    grid = np.linspace(min(1.0, stretches.min()), max(1.0, stretches.max()), 101)
                    model = replace(curves[0], stretch=grid, stress=grid, stretch2=None, stress2=None)
                    lines.append(
                        Line(
                            label=mode if temperature is None else f"{mode} {temperature:g} °C",
                            mode=mode,
                            stretch=stretches,
                            stress=np.concatenate([c.stress for c in curves]),
                            grid=grid,
                            model=_predict(self.law_at(temperature), model)[0],
                            predicted=mode not in self.setting.fit_on,
                            unstable_from=None,
                        )
                    )
            panels.append((f"{NAME}{', ' + name if name else ''}", lines))
        return fit_figure(panels)


def fit_sheet(curves: Sequence[Reading], setting: Setting) -> SheetFit:
    """Return the law of the sheet for ``curves``.

    All constants are sought at the temperature nearest to room; at the others its stresses alone, so that constants
    between tested temperatures mean something. Raises InputError where rows lack, or no stable law is found though
    one is asked for.
    """
    used = [curve for curve in curves if curve.mode in setting.fit_on]
    temperatures: tuple[float | None, ...] = tuple(
        sorted({curve.temperature for curve in used if curve.temperature is not None})
    ) or (None,)
    distance = [abs((t if t is not None else ROOM) - ROOM) for t in temperatures]
    reference = distance.index(min(distance))
    first = identify(_tests(used, temperatures[reference], setting))
    laws = [
        first.law if k == reference else identify(_tests(used, t, setting), near=first.law).law
        for k, t in enumerate(temperatures)
    ]
    fit = SheetFit(first, tuple(laws), temperatures, reference, curves, setting)
    if setting.stable and not fit.stable:
        raise InputError(
            "no constants of orthotropic could be shown to be stable over the data",
            file=curves[0].source,
            remedy="leave --stable out, or fit a smaller range of stretch",
        )
    return fit


def _tests(curves: Sequence[Reading], temperature: float | None, setting: Setting) -> list[SheetTest]:
    own = [curve for curve in curves if curve.temperature in (temperature, None)]
    found = []
    for curve in own:
        alike = [other for other in own if (other.mode, other.direction) == (curve.mode, curve.direction)]
        second = curve.stress2 if curve.mode.startswith("biaxial") else None
        weight2 = None if second is None else _weight(curve, second, setting, alike)
        if curve.mode == "uniaxial" and curve.stretch2 is not None:
            # The width's error counts against the largest contraction of its direction.
            widths = [other.stretch2 for other in alike if other.stretch2 is not None]
            largest = max(float(np.abs(width - 1.0).max()) for width in widths)
            weight2 = np.full(len(curve.stretch), 1.0 / max(largest, 1e-6))
        found.append(
            SheetTest(
                mode=curve.mode,
                angle_deg=_angle(curve),
                stretch=curve.stretch,
                stress=curve.stress,
                weight=_weight(curve, curve.stress, setting, alike),
                stretch2=curve.stretch2,
                stress2=second,
                weight2=weight2,
            )
        )
    return found


def _weight(curve: Reading, stress: Array, setting: Setting, alike: Sequence[Reading]) -> Array:
    """Return one over the error that counts as one [1/MPa]."""
    peak = max(float(np.abs(other.stress).max()) for other in alike)
    sd = curve.sd if curve.sd is not None else setting.noise
    if not setting.relative:
        return np.full(len(stress), 1.0 / peak) if sd is None else np.ones_like(stress) / sd
    floor = np.maximum(_FLOOR * peak, 0.0 if sd is None else NOISY * np.asarray(sd))
    return np.asarray(1.0 / np.maximum(np.abs(stress), floor))


def _predict(law: Orthotropic, curve: Reading) -> tuple[Array, Array | None, Array | None]:
    return stress(law, curve.mode, _angle(curve) or 0.0, curve.stretch, curve.stretch2)


def _angle(curve: Reading) -> float | None:
    """Return the angle [deg] of a specimen from the warp, None where it is not known."""
    name = curve.direction
    if name is None:
        return None
    return _NAMED[name] if name in _NAMED else float(name.split()[0])
