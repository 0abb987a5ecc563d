"""Readings in a press as a problem of the loop: pressure, contact, thickness at places, and force over stroke."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.loop.catalogue.press import DataContext, FoamContext, PressEffect, entries
from hyperfab.loop.known import FilesProblem
from hyperfab.loop.press_reading import THERE, UNITS, Changes, Kind, Reading, Setting, Warmth, variation
from hyperfab.loop.press_set import SetPress, Summed
from hyperfab.loop.press_table import Moved, PressTable, loads
from hyperfab.loop.problem import Constant, Curve, Extra
from hyperfab.loop.scatter import patches
from hyperfab.pressing.series import together

#: Readings over the stroke that are left out together, about.
_SEGMENT = 15
#: What is known of the press beside the foam's stiffness: gap [mm], force and foam thickness (shares), zero of a
#: stroke [mm].
GAP_SD, FORCE_SD, THICKNESS_SD, STROKE_SD = 0.02, 0.02, 0.01, 0.02


@dataclass(kw_only=True)
class PressProblem(FilesProblem[Reading]):
    """A press and what was read in it."""

    summed: PressTable
    correction: Array
    places: PressTable
    setting: Setting
    foam: FoamContext

    def shown(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> list[Array]:
        """Return the readings that the press would give."""
        value = self.as_stated(own)
        changes = self.changes(terms)
        guided: dict[tuple[float | None, float], Moved] = {}
        presses: dict[tuple[object, ...], SetPress] = {}

        def shown(reading: Reading, thick: float) -> Array:
            """Return what a reading shows where foam has this share of its thickness."""
            at = (None if reading.warmth is None else reading.warmth.temperature, thick)
            if at not in guided:
                guided[at] = self._moved(value, changes, reading.warmth, thick)
            start = guided[at]

            def read(left: Array | float) -> Array:
                mean = float(np.mean(left))
                key = (*at, mean)
                if key not in presses:
                    presses[key] = self._set(start.relaxed(mean), value)
                # Foam alone bears in proportion: the share that is left may be another at each row.
                return presses[key].read(reading, left / mean if np.ndim(left) else 1.0, changes)

            left = changes.factor(reading)
            return _through(left, read) if start.table.fabric_law is not None else read(left)

        return [
            _through(changes.thickness(one), lambda thick, one=one: shown(one, thick))  # type: ignore[misc]
            for one in self.every
        ]

    def changes(self, terms: Mapping[str, tuple[str, Array]]) -> Changes:
        """Return what ``terms`` change of the press."""
        found = Changes.of(self.amounts(terms))
        for name, (form, values) in terms.items():
            effect = self.effect(name)
            if isinstance(effect, PressEffect):
                effect.move(found, effect.form(form).named(values))
        return found

    def _moved(
        self, value: Mapping[str, float], changes: Changes, warmth: Warmth | None = None, thick: float = 1.0
    ) -> Moved:
        tilt = np.zeros(2) if self.setting.floating else changes.tilt
        # What heat has made is less on colder molds; the clearance was set on those that the model has.
        strain = changes.strain if warmth is None else warmth.share * changes.strain + warmth.grown
        mechanical = replace(changes, tilt=tilt, strain=strain).settings
        across = together([(layer, changes.across) for layer in self.setting.fabric])
        foam = value["foam.thickness"] * thick
        tables = []
        for table in (self.summed, self.places):
            uneven = variation(table.plan, changes.uneven)
            if self.setting.thickness is not None:
                uneven = uneven * (self.setting.thickness / table.foam)
            factor = foam if np.ndim(uneven) == 0 else foam * np.maximum(1.0 + uneven, 0.05)
            law = table.law if warmth is None or warmth.law is None else warmth.law
            moved = replace(table.moved(mechanical), foam=table.foam * factor, law=law)
            tables.append(moved if across is None else replace(moved, fabric_law=across))
        shift = float(np.dot(self.setting.zero_rate, changes.strain))
        frame = replace(changes.frame, compliance=self.setting.compliance + changes.frame.compliance)
        return Moved(tables[0], tables[1], value["foam.compression"], frame, shift, np.zeros(2))

    def _set(self, now: Moved, value: Mapping[str, float]) -> SetPress:
        return SetPress(now, self.setting, value, self._sum, self._arm if self.setting.floating else None)

    @cached_property
    def _sum(self) -> Summed:
        """The thinned sum of the model as it is at its openings, made to rise as they fall."""
        forces = np.maximum.accumulate(self.summed.force(self.summed.openings)[::-1])
        return Summed(forces, self.correction[::-1])

    @cached_property
    def _arm(self) -> Array:
        """Where [mm] the thinned sum has the arm of the force at the model's own balance."""
        value = self.as_stated(self.given)
        now = self._moved(value, Changes())
        load = loads(now.table, SetPress(now, self.setting, value, self._sum).opening, np.zeros(2))
        return np.asarray(load[1:] / max(load[0], 1e-300))

    def force_at(self, own: Array, terms: Mapping[str, tuple[str, Array]], time_s: float) -> float:
        """Return the force [N] that the press closes with, with ``terms``, a time after the foam was first pressed."""
        value = self.as_stated(own)
        changes, late = self.changes(terms), Reading("", "force", np.zeros(1), time_s=np.array([time_s]))
        left, thick = (float(np.max(share(late))) for share in (changes.factor, changes.thickness))
        press = self._set(self._moved(value, changes, thick=thick).relaxed(left), value)
        return float(press.force_at(np.array([press.opening]))[0])

    def extras(self) -> Sequence[Extra]:
        """Return what could be read next."""
        now = self._moved(self.as_stated(self.given), Changes())
        force = float(self._sum.force(now, np.array([self.setting.opening]))[0])
        loudest = {"force": force, "pressure": float(np.mean(self.places.law.stress(0.5)))}
        for one in self.files:
            if one.kind in loudest:
                same = [np.max(np.abs(other.values)) for other in self.files if other.kind == one.kind]
                loudest[one.kind] = float(max(same))
        first = float(np.std(self.measured[self.channel == 0])) or 1.0
        # The engine takes new rows to be as loud as the old ones: they are scaled to be.
        return [
            Extra(reading.name, details, self.with_reading(reading, 0.03 * first / loud))
            for reading, details, loud in menu(self.setting, self.summed, self.places, loudest)
        ]


def _through(left: Array | float, read: Callable[[float], Array]) -> Array:
    """Return what is read where each row has its own share ``left`` (m,) of the foam's stress, or of its thickness.

    A sandwich whose fabrics give way does not bear in proportion, nor does thinner foam: a parabola of the fourth
    degree through five shares.
    """
    if np.ndim(left) == 0:
        return read(float(left))
    low, high = float(np.min(left)), float(np.max(left))
    if high - low < 1e-9:
        return read(low)
    nodes = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(np.pi * np.arange(5) / 4)
    rows = np.stack([read(float(node)) for node in nodes])
    weights = [np.prod([(left - other) / (node - other) for other in nodes if other != node], axis=0) for node in nodes]
    return np.asarray(np.sum(np.stack(weights) * rows, axis=0))


def press_problem(
    tables: tuple[PressTable, PressTable, Array],
    setting: Setting,
    readings: Sequence[Reading],
    *,
    foam: FoamContext,
    prior: float,
    fixed: Sequence[str],
) -> PressProblem:
    """Return the problem of ``readings``; each cloud is cut into patches, which are left out in turn.

    ``tables`` are those of ``press_table``, ``foam`` says what the model has of the sandwich.
    """
    whole, summed, correction = tables
    kinds = list(dict.fromkeys(reading.kind for reading in readings))
    parts: list[Reading] = []
    for one in readings:
        index = np.arange(len(one.values))
        if one.kind in ("fabric", "mounting"):
            cut = [index]
        elif one.places is None:
            # Along the stroke, and at a hold along the time.
            cut = np.array_split(index, max(1, min(4, len(index) // _SEGMENT)))
        else:
            cut = patches(one.places)
        parts += [replace(one, index=index).rows(rows) for rows in cut]
    constants = [Constant("foam.compression", 1.0, 0.05, 20.0, 0.1, prior)]
    if any(reading.kind in THERE for reading in readings):
        gap, force = ("gap", 0.0, -1.0, 1.0, 0.02, GAP_SD), ("force", 1.0, 0.1, 10.0, 0.02, FORCE_SD)
        constants.append(Constant(*(gap if setting.force is None else force)))
    if "force" in kinds:
        constants.append(Constant("stroke.zero", 0.0, -1.0, 1.0, 0.02, STROKE_SD))
    constants.append(Constant("foam.thickness", 1.0, 0.5, 2.0, 0.02, THICKNESS_SD))
    curves, row = [], 0
    for number, part in enumerate(parts):
        size = len(part.values)
        abscissa = np.arange(size, dtype=np.float64) if part.along is None else part.along
        name = f"{part.name}, part {number + 1}"
        curves.append(Curve(name, row, row + size, abscissa, channel=kinds.index(part.kind)))
        row += size
    context = DataContext(
        setting=setting,
        foam=foam,
        force_N=max(float(summed.force(np.array([summed.openings[1]]))[0]), 1e-6),
        travel_mm=max(float(summed.first_touch - setting.opening), 0.2),
        time_s=max((float(np.max(p.time_s)) for p in parts if p.time_s is not None), default=None),
        pressure_MPa=float(np.mean(whole.law.stress(0.5))),
        temperatures=tuple(sorted({setting.temperature if p.temperature is None else p.temperature for p in parts})),
        strokes="force" in kinds,
        formed="formed" in kinds,
    )
    first = [part for part in parts if part.kind == kinds[0]]
    return PressProblem.posed(
        parts,
        curves,
        constants,
        fixed,
        effects=entries(context),
        states=_states(first),
        units=tuple(UNITS[kind] for kind in kinds),
        summed=summed,
        correction=correction,
        places=whole,
        setting=setting,
        foam=foam,
    )


def _states(parts: Sequence[Reading]) -> dict[str, Array]:
    def column(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    if parts[0].places is not None:
        found = {f"{axis}_mm": place for axis, place in zip("xyz", column("places").T, strict=True)}
    else:
        found = {"load_MPa": column("load")} if parts[0].stroke is None else {"stroke_mm": column("stroke")}
    return found | ({"time_s": column("time_s")} if all(part.time_s is not None for part in parts) else {})


#: Readings at places: of which kind, and how they are taken.
_THERE: tuple[tuple[Kind, str], ...] = (
    ("pressure", "a pressure film over the whole male, 80 places"),
    ("thickness", "the thickness of the pressed sandwich at 80 places (clay or lead between the molds)"),
    ("contact", "spotting paste over the whole male, 80 places"),
)
#: What a reading is off by: a share of the largest pressure and force; thickness, fabrics and mounting face [mm], an
#: edge of contact [-].
_SHARE = {"pressure": 0.03, "force": 0.01}
_SIZE = {"thickness": 0.02, "contact": 0.3, "fabric": 0.01, "mounting": 0.01}


def menu(
    setting: Setting, summed: PressTable, places: PressTable, loudest: Mapping[str, float]
) -> Iterator[tuple[Reading, Mapping[str, Any], float]]:
    """Yield each reading, called by what to do, its details, and what it would be off by.

    ``loudest`` are the largest pressure [MPa] and force [N].
    """
    some = np.linspace(0, len(places.foam) - 1, 80).astype(np.int64)
    corners, weights = np.repeat(some[:, None], 3, axis=1), np.full((80, 3), 1.0 / 3.0)
    found = [Reading(text, kind, np.zeros(80), corners, weights) for kind, text in _THERE]
    travel = max(summed.first_touch - summed.openings[0] - 0.3, 0.1)
    text = "force over stroke, 40 readings from the first touch to the deepest"
    force = Reading(text, "force", np.zeros(40), stroke=np.linspace(0.02, travel, 40))
    found.append(force)
    if not setting.floating:
        text = "dial gauges at four sides of the female's mounting face"
        sides = setting.half_mm * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
        found.append(Reading(text, "mounting", np.zeros(4), places=sides))
    if sum(setting.fabric) > 0.0:
        text = "the thickness of the fabrics alone under rising pressure (ISO 5084)"
        found.append(Reading(text, "fabric", np.zeros(10), load=loudest["pressure"] * np.linspace(0.1, 1.0, 10)))
    if setting.cold is not None:
        text = f"force over stroke with the molds at {setting.cold.temperature:g} degC"
        found.append(replace(force, name=text, temperature=setting.cold.temperature, warmth=setting.cold))
    for one in found:
        details = {"reading": one.kind} | ({} if one.temperature is None else {"temperature_degC": one.temperature})
        yield one, details, _SIZE.get(one.kind) or _SHARE[one.kind] * max(loudest[one.kind], 1e-9)
