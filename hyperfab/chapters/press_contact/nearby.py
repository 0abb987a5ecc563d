"""The neighbours of a closed press, for how sure its figures are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.heat import ThermalDisplacement
from hyperfab.chapters.press_contact.model import Model, joint_of, offset_of, reread, sandwich_of, tilt_of
from hyperfab.chapters.press_contact.warmth import MOST_ROUNDS, SETTLED, by_place, foam_temperature
from hyperfab.chapters.rerun import Listener
from hyperfab.chapters.uncertainty.carry import Answer, Changes, Nearby
from hyperfab.chapters.uncertainty.sources import Origins
from hyperfab.errors import NotConverged
from hyperfab.numerics.trend import Trend
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.mold import Expansion, even_growth, guide_line
from hyperfab.pressing.nearby import Displacement, Found, Neighbourhood
from hyperfab.pressing.sandwich import Sandwich

#: Neighbours drawn: of one law for all places, and of one a place, which take longer each.
_SAMPLES, _BY_PLACE = 1000, 64
#: Step from which the slopes of the places' temperature are told, over a standard deviation.
_STEP = 0.1


class Beside(Nearby):
    """What the figures become beside a press: gaps follow to the first order, pressures and areas from them.

    Where the foam's law is read at the temperature of each place, that temperature follows to the first order too.
    """

    def __init__(self, job: Job, model: Model, closed: Closed, origins: Origins) -> None:
        self._job, self._model, self._closed, self._origins = job, model, closed, origins
        male, female = model.grown
        modes = [[mode.growth for mode in grown.modes if mode.growth is not None] for grown in model.grown]
        self._near = Neighbourhood(closed, (male.growth, female.growth), (modes[0], modes[1]))
        # A female is looked for where those before lie.
        self._places = Trend()
        self._area = closed.front.molding_areas
        self._celsius = foam_temperature(job, model, closed) if by_place(model) else None
        self._warmer: Array | None = None
        self.samples = _SAMPLES if closed.press.sandwich.law.places is None else _BY_PLACE

    def close(self, changes: Changes) -> tuple[Found, Sandwich]:
        """Return the press with numbers changed, and its sandwich at the front's vertices; NotConverged where a female
        finds no balance."""
        before, places = self._celsius, None
        if before is not None:
            if self._warmer is None:
                self._warmer = self._slopes(before)
            places = before + self._origins.amounts(changes) @ self._warmer
        found, sandwich, _ = self._close(changes, places)
        self._places.add(self._origins.amounts(changes), found.place)
        return found, sandwich

    def _slopes(self, before: Array) -> Array:
        """Return what the temperature of the places changes by from ``before`` (n,) [degC] on with each number
        (numbers, n)."""
        rows = []
        for sd, index, unit in self._origins.each():
            by = _STEP * sd
            gained = self._settled({index: by * unit}, before) - before if sd > 0.0 else 0.0 * before
            rows.append(gained / max(by, np.finfo(float).tiny))
        return np.array(rows)

    def _settled(self, changes: Changes, before: Array) -> Array:
        """Return the temperature of the places [degC] with numbers changed, as pressing and warming agree on it."""
        for _ in range(MOST_ROUNDS):
            found, sandwich, model = self._close(changes, before)
            closed = replace(
                self._closed,
                press=replace(self._closed.press, sandwich=sandwich),
                contact=replace(self._closed.contact, gap=found.gap, pressure=found.pressure),
            )
            there = foam_temperature(Job(self._job.command, (), Listener(), self._job.inputs), model, closed)
            if np.abs(there - before).max() <= SETTLED:
                return there
            before = there
        raise NotConverged("the foam's temperature and its pressing do not settle on each other")

    def _close(self, changes: Changes, places: Array | None) -> tuple[Found, Sandwich, Model]:
        """Return the same with the foam's law read at the temperature of ``places`` (n,) [degC] where that is given,
        and the model it is of."""
        model = self._model
        moved = self._origins.changed(model.case, self._job.inputs, changes)
        case, quiet = moved.case, moved.job
        files = reread(quiet, case, model.case, model.files, moved.handed)
        # How much there is of each mode of a mold, where numbers of its heat document change.
        amounts = [
            np.array([moved.handed.get(heat.name, {}).get(k, 0.0) for k in range(len(grown.modes))])
            for grown, heat in zip(model.grown, files.heat, strict=True)
        ]
        celsius = [
            (heat.temperature if grown.even and not grown.modes else grown.temperature)
            + sum(by * mode.mean for by, mode in zip(along, grown.modes, strict=True))
            for heat, grown, along in zip(files.heat, model.grown, amounts, strict=True)
        ]
        male, female = (
            _growth(self._closed, grown, side, (old, new), hot)
            for side, (grown, old, new, hot) in enumerate(
                zip(model.grown, model.files.expansions, files.expansions, celsius, strict=True)
            )
        )
        warm = 0.5 * sum(celsius)
        sandwich, _ = sandwich_of(quiet, case, files, warm)
        joint = joint_of(case, files)
        at = guide_line(self._closed.case.male) if joint is None else joint
        sandwich = sandwich.of_vertices(self._closed.front.of_mold)
        if places is not None:
            sandwich = replace(sandwich, law=files.law.at(places))
        found = self._near.close(
            sandwich,
            growths=(male, female),
            modes=(_given(model.grown[0], amounts[0]), _given(model.grown[1], amounts[1])),
            gap=case.gap,
            force=case.force,
            frame=None if case.force else case.frame_stiffness or files.document.press.stiffness,
            tilt=tilt_of(case, files),
            offset=offset_of(files),
            at=(float(at[0]), float(at[1])),
            begun=self._places.at(self._origins.amounts(changes)),
        )
        hot = tuple(one.warmer(now, by) for one, now, by in zip(model.grown, celsius, amounts, strict=True))
        return found, sandwich, replace(model, case=case, files=files, grown=(hot[0], hot[1]))

    def at(self, changes: Changes) -> Answer:
        found, sandwich = self.close(changes)
        touched = found.totals.touched
        return Answer(
            {
                "contact_fraction": found.fraction,
                "contact_area_mm2": touched.area,
                "force_N": found.totals.closing_force,
                "gap_min_mm": float(found.gap.min()),
                "gap_mean_mm": float(np.average(found.gap, weights=self._area)),
                "gap_max_mm": float(found.gap[self._area > 0.0].max()),
                "pressure_max_MPa": float(found.pressure.max()),
                "pressure_mean_MPa": touched.load / touched.area if touched.area > 0.0 else 0.0,
                "stroke_mm": found.stroke,
                "energy_J": 1e-3 * found.totals.energy,
            },
            {
                "gap_mm": found.gap,
                "compression": sandwich.strain(found.gap),
                "pressure_MPa": found.pressure,
                ROOM: found.thickness - found.touch,
            },
        )


#: By how much the sandwich is thicker than the gap it stands in [mm]: it touches where that is above 0.
ROOM = "room_mm"


def beside(job: Job, model: Model, closed: Closed, origins: Origins) -> Beside | None:
    """Return the neighbours of a press; None where the clearance is set on the hot molds, or where a field of
    temperature deforms the molds and what it counts from is not known."""
    if model.case.zero == "hot":
        return None
    names = {number.name.partition(": ")[2] for number in origins.numbers}
    if not all(grown.even for grown in model.grown) and "expansion.reference" in names:
        return None
    return Beside(job, model, closed, origins)


def _given(grown: ThermalDisplacement, amounts: Array) -> Array | None:
    """Return the amounts of modes that deform a mold, None where none does."""
    return None if grown.even or not amounts.any() else amounts


def _growth(
    closed: Closed,
    grown: ThermalDisplacement,
    side: int,
    expansions: tuple[Expansion, Expansion],
    celsius: float,
) -> Displacement | float:
    """Return how a mold has grown otherwise: other displacements, or a factor on those there are."""
    old, new = expansions
    if not grown.even:
        # Of a field, displacements go with the one coefficient of expansion.
        return 1.0 if old == new else float(new.coefficient[0] / old.coefficient[0])
    strain = float(new.strain(celsius))
    if strain == grown.strain:
        return 1.0
    mold = (closed.case.male, closed.case.female)[side]
    return even_growth(mold, strain, guide_line(closed.case.male)).at
