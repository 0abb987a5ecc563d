"""A press as it is set, for reading after reading: where it stands is found once, and what each reading shows there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from hyperfab.arrays import Array
from hyperfab.loop.press_reading import Changes, Reading, Setting
from hyperfab.loop.press_table import Moved, found_tilt

#: Openings at which a yielding press is known, between which it is interpolated.
_GRID = 60
#: How far [mm] before the first touch these begin.
_BEFORE = 0.2
#: How near [mm] the opening of a yielding press is found.
_NEARLY = 1e-9


@dataclass(frozen=True)
class Summed:
    """What the exact sum of the pressure has over the thinned one: ``correction`` (k,) at the rising ``forces`` (k,)
    [N] of the latter. It hangs on how far the foam is pressed, not on the opening: of foam that is uneven the first
    touch says little."""

    forces: Array
    correction: Array

    def exactness(self, force: Array) -> Array:
        """Return the correction (m,) at forces (m,) of the thinned sum."""
        return np.interp(force, self.forces, self.correction)

    def force(self, now: Moved, openings: Array) -> Array:
        """Return the force (m,) [N] of the law as it is at ``openings`` (m,), corrected."""
        found = now.table.force(openings)
        return found * self.exactness(found / now.left)


@dataclass(frozen=True)
class SetPress:
    """A press as it is ``now``, set as ``setting`` says, with own constants of ``value`` by name.

    ``arm`` (2,) [mm] is where the thinned sum has the arm of the force where a floating female balances; None: she is
    guided.
    """

    now: Moved
    setting: Setting
    value: Mapping[str, float]
    summed: Summed
    arm: Array | None = None

    @cached_property
    def hangs(self) -> Moved:
        """The press, a floating female turned."""
        now, factor = self.now, self.now.factor
        if self.arm is None:
            return now

        def unbalanced(opening: float, force: float) -> float:
            exact = factor * force * float(self.summed.exactness(np.array(force / now.left)))
            if self._wanted is not None:
                return exact - self._wanted
            return opening - self._shut(now) - float(now.frame.opens(exact))

        turn = found_tilt(now.table, self.arm, self._opening(now), unbalanced)
        settings = Changes(tilt=turn).settings
        return replace(now, table=now.table.moved(settings), places=now.places.moved(settings), turn=turn)

    @cached_property
    def opening(self) -> float:
        """Where it stands [mm]."""
        return self._opening(self.hangs)

    def read(self, reading: Reading, left: Array | float, changes: Changes) -> Array:
        """Return the readings (m,); ``left`` scales the foam's stress row by row."""
        if reading.kind == "force":
            return self._force(left, reading)
        if reading.kind == "fabric":
            return self._of_fabric(reading)
        if reading.kind == "mounting":
            return self._of_mounting(changes, reading)
        return self._at_places(left, reading, changes.stays)

    @property
    def _wanted(self) -> float | None:
        force = self.setting.force
        return None if force is None else force * self.value.get("force", 1.0)

    def _shut(self, now: Moved) -> float:
        """The opening [mm] without a yielding frame."""
        return self.setting.opening + self.value.get("gap", 0.0) + now.shift

    def _opening(self, now: Moved) -> float:
        table, wanted, factor = now.table, self._wanted, now.factor
        if wanted is not None:
            forces = factor * self.summed.force(now, table.openings)
            falling = np.flatnonzero(np.diff(forces) < 0.0)
            if not len(falling) or wanted > forces[0]:
                return float(table.openings[0])
            order = slice(falling[0], falling[-1] + 2)
            guess = float(np.interp(-wanted, -forces[order], table.openings[order]))
            return _solved(lambda s: factor * self.summed.force(now, s) - wanted, guess)
        start = self._shut(now)
        if now.frame.rigid:
            return start

        def unopened(opening: float) -> float:
            return float(now.frame.opens(self.force_at(np.array([opening]), now)[0])) - (opening - start)

        # It opens by no more than the force on a rigid frame would open it, where that falls as it opens.
        end = start
        while (further := unopened(end)) > _NEARLY:
            end += further
        return float(brentq(unopened, start, end, xtol=_NEARLY)) if further < 0.0 else end

    def force_at(self, openings: Array, now: Moved | None = None) -> Array:
        """Return the force (m,) [N] at ``openings`` (m,), of the press that hangs or one that is to be turned."""
        now = self.hangs if now is None else now
        return np.asarray(now.factor * self.summed.force(now, openings))

    @cached_property
    def _yielding(self) -> PchipInterpolator:
        """The opening by the stroke that the machine reads from the first touch on, where the frame yields."""
        now, touch = self.hangs, self.hangs.table.first_touch
        grid = np.linspace(touch + _BEFORE, now.table.openings[0], _GRID)
        machine = touch - grid + now.frame.opens(self.force_at(grid))
        return PchipInterpolator(machine, grid, extrapolate=True)

    def _force(self, left: Array | float, reading: Reading) -> Array:
        assert reading.stroke is not None
        now, stroke = self.hangs, reading.stroke - self.value.get("stroke.zero", 0.0)
        touch = now.table.first_touch
        # What is not touched anywhere in the table bears nothing, and no frame yields.
        rigid = now.frame.rigid or touch + _BEFORE <= now.table.openings[0]
        opening = touch - stroke if rigid else self._yielding(stroke)
        return np.asarray(now.factor * left * self.summed.force(now, opening))

    def _of_fabric(self, reading: Reading) -> Array:
        """Return the thickness (m,) [mm] of the fabrics alone under the loads of a reading."""
        assert reading.load is not None
        law, whole = self.now.table.fabric_law, sum(self.setting.fabric)
        if law is None:
            return np.full(len(reading.load), whole)
        strain = np.append(law.knots, law.limit)
        return np.asarray(whole * (1.0 - np.interp(reading.load, self.now.factor * law.stress(strain), strain)))

    def _of_mounting(self, changes: Changes, reading: Reading) -> Array:
        """Return how much further (m,) [mm] the female's mounting face stands off at places, less their mean."""
        assert reading.places is not None
        x, y = reading.places[:, 0], reading.places[:, 1]
        about_x, about_y = self.setting.tilt + (changes.tilt if self.arm is None else self.hangs.turn)
        height = about_x * y - about_y * x
        return np.asarray(height - np.mean(height))

    @cached_property
    def _gap(self) -> Array:
        """The gap (n,) [mm] at the places of the table."""
        places = self.hangs.places
        return places.at(np.array([self.opening]), places.gap)[0]

    @cached_property
    def _touch(self) -> Array:
        """The gap (n,) [mm] along the normal."""
        places = self.hangs.places
        return np.asarray(self._gap * places.at(np.array([self.opening]), places.along)[0])

    def _at_places(self, left: Array | float, reading: Reading, stays: Array) -> Array:
        table, there = self.hangs.places, reading.there
        if reading.kind == "formed":
            sandwich = table.sandwich.at(there)
            strain = 1.0 - sandwich.pressed(there(self._gap))[0] / sandwich.foam
            had = table.stays if np.ndim(table.stays) == 0 else there(np.asarray(table.stays))
            share = np.clip(had + stays[0] + stays[1] * strain, 0.0, 1.0)
            return np.asarray(sandwich.thickness - share * strain * sandwich.foam)
        shown = reading.shown(table.sandwich, self._touch if reading.kind == "contact" else self._gap)
        if reading.kind != "pressure":
            return shown
        pressure = np.asarray(self.hangs.factor * left * shown)
        return pressure if reading.below is None else np.maximum(pressure - reading.below, 0.0)


def _solved(value: Callable[[Array], Array], guess: float) -> float:
    """Secant steps on a falling function of the opening."""
    a, b = guess, guess + 0.01
    fa, fb = (float(value(np.array([s]))[0]) for s in (a, b))
    for _ in range(6):
        if fb == fa:
            break
        c = b - fb * (b - a) / (fb - fa)
        a, fa, b = b, fb, float(np.clip(c, b - 0.5, b + 0.5))
        fb = float(value(np.array([b]))[0])
        if abs(b - a) < 1e-8:
            break
    return b
