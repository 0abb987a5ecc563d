"""What ``hf fit`` writes beside its document: the curves as a table and as a picture."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from itertools import compress

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fit.identify import Identified, Setting, predict
from hyperfab.chapters.fit.judge import Judged, Sets
from hyperfab.chapters.fit.prepare import branch_of
from hyperfab.chapters.fit.replicates import next_specimens
from hyperfab.chapters.fit.whole import Answer
from hyperfab.curve import TestCurve, angle_named
from hyperfab.io.csv_write import csv_bytes
from hyperfab.materials.modes import MODES, SIMPLE_SHEAR, nominal_stress, way
from hyperfab.report.figures_fit import Line, fit_figure

_COLUMNS = (
    "test",
    "direction",
    "temperature_degC",
    "specimen",
    "stretch",
    "stretch_2",
    "stretch_2_model",
    "stress_MPa",
    "stress_model_MPa",
    "predicted",
)


def curves_csv(told: Iterable[tuple[TestCurve, Answer]], fit_on: Sequence[str], without: Collection[str] = ()) -> bytes:
    """Return every reading with what the law says beside it, less the columns ``without``."""
    rows = []
    for curve, (one, two, width) in told:
        start = [curve.mode, curve.direction_name, curve.temperature, curve.specimen]
        nothing = [None] * len(curve.stretch)
        second = nothing if curve.stretch2 is None else curve.stretch2
        for measured, model, own, other, lateral in (
            (curve.stress, one, curve.stretch, second, width),
            (curve.stress2, two, second, curve.stretch, None),
        ):
            if measured is not None and model is not None:
                axis = zip(own, other, nothing if lateral is None else lateral, measured, model, strict=True)
                rows += [[*start, *row, curve.mode not in fit_on] for row in axis]
    kept = [name not in without for name in _COLUMNS]
    return csv_bytes(list(compress(_COLUMNS, kept)), [list(compress(row, kept)) for row in rows])


def law_csv(best: Judged, sets: Sets, setting: Setting) -> bytes:
    """Return ``curves_csv`` of a law identified by direction: a test without one stands with each."""
    told = (
        (replace(curve, direction=angle_named(name or curve.direction_name)), (*predict(part, curve), None))
        for name, part in best.parts
        for curve in sets[name]
    )
    return curves_csv(told, setting.fit_on, ("stretch_2_model",))


def law_picture(best: Judged, sets: Sets, setting: Setting) -> bytes:
    """Return the PNG of the fit: a panel a direction, readings as marks, constants as lines."""
    panels = []
    for name, part in best.parts:
        lines: dict[bool, list[Line]] = {}
        for mode in dict.fromkeys(curve.mode for curve in sets[name]):
            for number, temperature in enumerate(part.temperatures):
                curves = [c for c in sets[name] if c.mode == mode and c.is_at(temperature)]
                sheared = mode == SIMPLE_SHEAR
                if not curves:
                    continue
                if way(mode) not in MODES:
                    lines.setdefault(False, []).append(_general(curves, temperature, part, mode not in setting.fit_on))
                    continue
                grid = grid_of(curves, 201, 0.0 if sheared else 1.0)
                model = nominal_stress(part.materials[number], mode, grid)
                unstable = part.every_range[number][way(mode)].first_unstable
                if sheared and unstable is not None:
                    unstable -= 1.0 / unstable
                one = line(curves, temperature, (grid, model), setting.fit_on, unstable)
                lines.setdefault(sheared, []).append(one)
        title = f"{best.law.name}{', ' + name if name else ''}: relative rms {part.total.relative_rms:.3f}"
        panels += [(title, own) for own in lines.values()]
    return fit_figure(panels)


def _general(curves: Sequence[TestCurve], temperature: float | None, part: Identified, predicted: bool) -> Line:
    """Return tests whose second stretch goes its own way as a line: each axis, the law at the readings."""
    axes = [
        (stretch, stress, model, branch_of(curve) < 0)
        for curve in curves
        for stretch, stress, model in zip(
            (curve.stretch, curve.stretch2), (curve.stress, curve.stress2), predict(part, curve), strict=True
        )
        if stretch is not None and stress is not None and model is not None
    ]
    pause = np.array([np.nan])  # no line leads from the end of one axis to the start of the next
    return Line(
        label=curves[0].mode if temperature is None else f"{curves[0].mode} {temperature:g} °C",
        mode=curves[0].mode,
        stretch=np.concatenate([one[0] for one in axes]),
        stress=np.concatenate([one[1] for one in axes]),
        grid=np.concatenate([part for one in axes for part in (one[0], pause)]),
        model=np.concatenate([part for one in axes for part in (one[2], pause)]),
        predicted=predicted,
        unstable_from=None,
        back=np.concatenate([one[3] for one in axes]),
    )


def line(
    curves: Sequence[TestCurve],
    temperature: float | None,
    model: tuple[Array, Array],
    fit_on: Sequence[str],
    unstable_from: float | None = None,
) -> Line:
    """Return the readings of one test at one temperature, and the law's stress over stretches, as one line."""
    mode = curves[0].mode
    kinds = next_specimens(curves)
    expected = None
    if len(kinds) == 1:
        (one,) = kinds
        expected = np.array(one.stretch), np.array(one.low_MPa), np.array(one.high_MPa)
    return Line(
        label=mode if temperature is None else f"{mode} {temperature:g} °C",
        mode=mode,
        stretch=np.concatenate([c.stretch for c in curves]),
        stress=np.concatenate([c.stress for c in curves]),
        grid=model[0],
        model=model[1],
        predicted=mode not in fit_on,
        unstable_from=unstable_from,
        expected=expected,
        back=np.concatenate([branch_of(c) < 0 for c in curves]),
    )


def grid_of(curves: Sequence[TestCurve], count: int, *through: float) -> Array:
    """Return ``count`` stretches over the range of the curves, which holds those ``through``."""
    reach = np.concatenate([through, *(c.stretch for c in curves)])
    return np.linspace(reach.min(), reach.max(), count)
