"""What ``hf fit`` writes beside its document: the curves as a table and as a picture."""

from __future__ import annotations

import numpy as np

from hyperfab.chapters.fit.identify import Identified, Setting, predict
from hyperfab.chapters.fit.judge import Judged, Sets
from hyperfab.io.csv_write import csv_bytes
from hyperfab.materials.modes import MODES, nominal_stress
from hyperfab.report.figures_fit import Line, fit_figure

_COLUMNS = (
    "test",
    "direction",
    "temperature_degC",
    "specimen",
    "stretch",
    "stretch_2",
    "stress_MPa",
    "stress_model_MPa",
    "predicted",
)


def curves_csv(best: Judged, sets: Sets, setting: Setting) -> bytes:
    """Return every reading with the stress of the constants beside it."""
    lines = []
    for name, part in _parts(best):
        for curve in sets[name]:
            one, two = predict(part, curve)
            predicted = curve.mode not in setting.fit_on
            start = [curve.mode, name or curve.direction, curve.temperature, curve.specimen]
            for axis, (measured, model) in enumerate(((curve.stress, one), (curve.stress2, two))):
                if measured is None or model is None:
                    continue
                second = curve.stretch2
                for k, stretch in enumerate(curve.stretch):
                    own, other = stretch, None if second is None else second[k]
                    if axis == 1:
                        own, other = other, own
                    lines.append([*start, own, other, measured[k], model[k], predicted])
    return csv_bytes(_COLUMNS, lines)


def picture(best: Judged, sets: Sets, setting: Setting) -> bytes:
    """Return the PNG of the fit: a panel a direction, readings as marks, constants as lines."""
    panels = []
    for name, part in _parts(best):
        lines = []
        for mode in dict.fromkeys(curve.mode for curve in sets[name]):
            for temperature in part.temperatures:
                curves = [c for c in sets[name] if c.mode == mode and c.temperature in (temperature, None)]
                if not curves or mode not in MODES:
                    continue
                low = min(1.0, *(float(c.stretch.min()) for c in curves))
                high = max(1.0, *(float(c.stretch.max()) for c in curves))
                grid = np.linspace(low, high, 201)
                lines.append(
                    Line(
                        label=mode if temperature is None else f"{mode} {temperature:g} °C",
                        mode=mode,
                        stretch=np.concatenate([c.stretch for c in curves]),
                        stress=np.concatenate([c.stress for c in curves]),
                        grid=grid,
                        model=nominal_stress(part.material_at(temperature), mode, grid),
                        predicted=mode not in setting.fit_on,
                        unstable_from=part.ranges[mode].first_unstable,
                    )
                )
        title = f"{best.law.name}{', ' + name if name else ''}: relative rms {part.total.relative_rms:.3f}"
        panels.append((title, lines))
    return fit_figure(panels)


def _parts(best: Judged) -> list[tuple[str | None, Identified]]:
    named = [(name, part) for name, part in best.results.items() if isinstance(part, Identified)]
    return [(name, part) for name, part in named if name is not None or len(named) == 1]
