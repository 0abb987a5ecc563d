"""The neighbours of a draped sheet, for how sure its figures are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.drape.fabric import read_fabric
from hyperfab.chapters.drape.model import Model, State, sheet_of
from hyperfab.chapters.job import Job
from hyperfab.chapters.uncertainty.carry import Answer, Changes, Figures, Nearby, Slopes
from hyperfab.chapters.uncertainty.sources import Origins
from hyperfab.cloth import Sheet
from hyperfab.cloth.answers import Answers
from hyperfab.cloth.sensitivity import Neighbourhood

#: Options that change the sheet's law alone.
_OF_THE_LAW = {"thickness_mm", "shear_modulus_MPa", "temperature_degC", "mass_g_m2"}
#: Steps of differences, over a standard deviation.
_STEP = 0.05


class Beside(Nearby):
    """What the figures become beside an equilibrium without friction: nodes move along the tangent there, and as much
    further as the forces that this leaves ask for."""

    samples = 100

    def __init__(self, job: Job, model: Model, state: State, origins: Origins) -> None:
        self._job, self._model, self._origins = job, model, origins
        self._near = Neighbourhood(model.sheet, state.mold, state.found, state.fields.cut)
        self._moves: list[Array] = []

    def gradient(self) -> Slopes:
        slopes: list[Answer] = []
        self._moves = []
        for sd, index, unit in self._origins.each():
            step = _STEP * sd
            sheets = [self._sheet({index: way * step * unit}) for way in (1.0, -1.0)]
            move, *ends = self._near.slopes(sheets[0], sheets[1], step)
            self._moves.append(move)
            up, down = (
                _answer(sheet, end, way * step * move)
                for sheet, end, way in zip(sheets, ends, (1.0, -1.0), strict=True)
            )
            slopes.append(
                Answer(
                    {name: (value - down.figures[name]) / (2.0 * step) for name, value in up.figures.items()},
                    {name: (values - down.fields[name]) / (2.0 * step) for name, values in up.fields.items()},
                )
            )
        return Slopes.of(slopes)

    def at(self, changes: Changes) -> Answer:
        if not self._moves:
            self.gradient()
        amounts = self._origins.amounts(changes)
        moved = np.tensordot(amounts, np.array(self._moves), axes=1)
        sheet = self._sheet(changes)
        return _answer(sheet, *self._near.answers(sheet, moved))

    def _sheet(self, changes: Changes) -> Sheet:
        moved = self._origins.changed(self._model.case, self._job.inputs, changes)
        return sheet_of(moved.case, replace(self._model.files, fabric=read_fabric(moved.job, moved.case)))


def beside(job: Job, model: Model, state: State, origins: Origins) -> Beside | None:
    """Return the neighbours of the last state; None where they hang on the way there, or on the mold's place."""
    if model.case.has_friction or not origins.settings <= _OF_THE_LAW:
        return None
    return Beside(job, model, state, origins)


def _answer(sheet: Sheet, fields: Answers, moved: Array) -> Answer:
    found: Figures = {
        "force_N": fields.press_force,
        "stress_warp_max_MPa": float(fields.stress_warp.max()),
        "stress_weft_max_MPa": float(fields.stress_weft.max()),
        "stretch_max": fields.stretch_max,
        "thickness_min_mm": float(fields.cell_thickness.min()),
        "energy_J": 1e-3 * fields.spring_energy,
    }
    by_name = {
        "thickness_mm": fields.cell_thickness.ravel(),
        "stretch_warp": fields.cell_stretch_warp.ravel(),
        "stretch_weft": fields.cell_stretch_weft.ravel(),
        "stress_warp_MPa": fields.stress_warp.ravel(),
        "stress_weft_MPa": fields.stress_weft.ravel(),
        "thickness_ratio": fields.cell_thickness.ravel() / sheet.thickness,
        "place_mm": moved.ravel(),
    }
    if fields.cells is not None:
        found["stress_max_MPa"] = float(fields.cells.cauchy.max())
        by_name["stress_larger_MPa"] = fields.cells.cauchy.ravel()
    return Answer(found, by_name)
