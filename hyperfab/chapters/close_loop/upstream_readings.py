"""Readings in a press that are traced to the documents behind it: at places while it is closed, and force over its
stroke."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from hyperfab.arrays import Array
from hyperfab.chapters.close_loop.press import plan_of
from hyperfab.chapters.close_loop.press_places import on_front
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.loop.noise import Noise
from hyperfab.loop.press import STROKE_SD, PressProblem
from hyperfab.loop.press_reading import Reading
from hyperfab.loop.press_table import PressTable, press_table
from hyperfab.loop.upstream import Readings
from hyperfab.pressing.nearby import Found
from hyperfab.pressing.sandwich import Sandwich

#: Readings that are traced: those taken at places while the press is closed, and while it closes.
KINDS = ("pressure", "thickness", "contact", "force")


@dataclass(frozen=True)
class Pushed:
    """A press over its openings: the ``table`` of all vertices of its front, what the exact sum of the pressure has
    over that of the vertices (k,), how far its frame yields [mm/N], where it stands closed [mm], the gap (n,) there.
    """

    table: PressTable
    exactness: Array
    compliance: float
    opening: float
    gap: Array

    @classmethod
    def of(cls, told: PressResult, travel: float) -> Pushed:
        """Return the press of a closed one, for strokes of up to ``travel`` [mm]."""
        closed = told.closed
        table, few, correction = press_table(closed, plan_of(told), travel, 0.0)
        exact, summed = few.force(table.openings) * correction, _sum(table)
        exactness = np.divide(exact, summed, out=np.ones(len(exact)), where=summed > 0.0)
        compliance = 0.0 if closed.case.frame is None else 1.0 / closed.case.frame
        return cls(table, exactness, compliance, closed.pose.opening, closed.contact.gap)

    def force(self, stroke: Array, found: Found | None, sandwich: Sandwich) -> Array:
        """Return the force (m,) [N] at strokes (m,) [mm] from the first touch on, as the machine reads them; of a press
        beside it as it was ``found`` closed, with its ``sandwich``.

        Where it stands closed is no matter of a force over stroke: gaps are compared at the same opening.
        """
        table = self.table
        if found is not None:
            opens = table.at(np.array([self.opening]), table.push / table.area)[0]
            gained = found.gap - self.gap - (found.place[0] - self.opening) * opens
            foam, fabric = (np.broadcast_to(part, gained.shape) for part in (sandwich.foam, sandwich.fabric))
            table = replace(
                table, gap=table.gap + gained, foam=foam, fabric=fabric, law=sandwich.law,
                fabric_law=sandwich.fabric_law,
            )  # fmt: skip
        force = self.exactness * _sum(table)
        machine = table.first_touch - table.openings + self.compliance * force
        order = np.argsort(machine)
        return np.asarray(PchipInterpolator(machine[order], force[order], extrapolate=True)(stroke))


def _sum(table: PressTable) -> Array:
    """Return the force (k,) [N] at the openings of the table."""
    pressure = np.stack([table.sandwich.pressure(gap) for gap in table.gap])
    return np.asarray(np.sum(pressure * table.push, axis=1))


def seen_in(told: PressResult, readings: Sequence[Reading]) -> Callable[..., Array]:
    """Return what shows the readings (n,) of a press: on the male's front, by a ``sandwich`` in gaps at its vertices
    (``gap``, the nearest, and ``touch`` along the normal); and the force over the stroke, of a press beside it as it
    was ``found`` closed."""
    there = [one if one.places is None else on_front(told, one) for one in readings]
    travel = [float(np.max(one.stroke)) for one in readings if one.stroke is not None]
    pushed = Pushed.of(told, max(travel)) if travel else None

    def seen(sandwich: Sandwich, gap: Array, touch: Array, found: Found | None = None) -> Array:
        return np.concatenate([
            pushed.force(one.stroke, found, sandwich)
            if pushed is not None and one.stroke is not None
            else one.shown(sandwich, touch if one.kind == "contact" else gap)
            for one in there
        ])  # fmt: skip

    return seen


def placed(problem: PressProblem, noise: Noise) -> tuple[list[Reading], Readings]:
    """Return the readings that are traced, and their rows, in the ``noise`` of all rows of the problem."""
    found = [
        (reading, np.arange(curve.start, curve.stop))
        for reading, curve in zip(problem.files, problem.curves, strict=False)
        if is_traced(problem, reading)
    ]
    rows = np.concatenate([rows for _, rows in found])
    readings = [reading for reading, _ in found]
    places = np.concatenate([_along(reading) for reading in readings])
    kind = np.concatenate([np.full(len(one.values), KINDS.index(one.kind)) for one in readings])
    # Where the machine counts its stroke from is known to its own standard deviation only.
    given = problem.as_stated(problem.given)
    off = given | ({"stroke.zero": STROKE_SD} if "stroke.zero" in given else {})
    shown = [problem.predict(np.array(list(own.values())), {}) for own in (given, off)]
    sd = np.hypot(noise.sd, shown[1] - shown[0])[rows]
    return readings, Readings(problem.measured[rows], sd, places, kind, noise.dof)


def is_traced(problem: PressProblem, reading: Reading) -> bool:
    """Whether a reading is traced: of a female that turns as she closes no force over stroke is."""
    turns = reading.kind == "force" and problem.setting.floating
    return reading.kind in KINDS and reading.warmth is None and not turns


def _along(reading: Reading) -> Array:
    """Return where a reading was taken (m, 3), over its span: on the male, or along the stroke."""
    at = reading.places
    if at is None:
        at = np.pad(np.asarray(reading.stroke)[:, None], ((0, 0), (0, 2)))
    return np.asarray((at - at.min(axis=0)) / max(float(np.ptp(at, axis=0).max()), 1e-300))
