"""A press as numbers the loop can move quickly: the gap at chosen places over the opening, how it shifts, and the tilt
at which a floating female has no moment about its joint.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import isqrt

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.press_reading import Frame
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.foam_law import FoamLaw
from hyperfab.pressing.gap import vertex_areas
from hyperfab.pressing.mold import guide_line
from hyperfab.pressing.sandwich import Sandwich

#: Openings between the deepest and the first touch, and places the force is summed over, at most.
_KNOTS, _PLACES = 25, 800
#: Bands of height the places are drawn from, as many as places around each.
_BANDS = isqrt(_PLACES)
#: Turns [rad], strains and offsets [mm] at which what the force is summed over is set to rights, and how small a part
#: of that is left as it is.
_A_LITTLE, _RANK = np.array([2e-3, 2e-3, 2e-3, 2e-3, 0.1, 0.1]), 1e-3
#: How much further [mm] the table reaches than what the model itself needs: what effects may shift it by.
MARGIN = 1.0
#: A tilt [rad] to take differences over.
_TURN = 2e-3


@dataclass(frozen=True)
class PressTable:
    """Gaps at n vertices of the male's front for each of ``openings`` (k,) [mm], evenly spaced and rising.

    ``gap`` (k, n) [mm], the nearest one, and ``along`` (k, n), the one along the normal over it; ``shift`` (6, k, n) is
    what the gap gains per radian of tilt about the two axes across, per thermal strain of male and female, and per mm
    that the female stands off along the two axes. ``area``
    (n,) [mm^2] is each vertex' share of the area, ``push`` (k, n) that times how squarely it meets the axis. ``foam``
    and ``fabric`` (n,) [mm] with their laws are the ``sandwich``, ``plan`` (n, 2) the coordinates of thickness
    variation, -1 to 1 over the male, ``stays`` (n,) the share of the foam's strain that stays. ``bend`` (n, 2, 2)
    [mm/rad^2] is how the gains by tilt change with tilt where a female floats: the pressure has other arms when it has
    turned.
    """

    openings: Array
    gap: Array
    along: Array
    shift: Array
    push: Array
    area: Array
    foam: Array
    fabric: Array
    plan: Array
    law: FoamLaw
    bend: Array
    fabric_law: FoamLaw | None
    stays: Array | float

    @cached_property
    def sandwich(self) -> Sandwich:
        """What is pressed at the vertices."""
        return Sandwich(self.foam, self.fabric, self.law, self.fabric_law)

    def of(self, chosen: Ints) -> PressTable:
        """Return the table of some of the vertices."""
        return replace(
            self,
            gap=self.gap[:, chosen],
            along=self.along[:, chosen],
            shift=self.shift[:, :, chosen],
            push=self.push[:, chosen],
            area=self.area[chosen],
            foam=self.foam[chosen],
            fabric=self.fabric[chosen],
            plan=self.plan[chosen],
            bend=self.bend[chosen],
            law=self.law.at(lambda values: values[chosen]),
            stays=self.stays if np.ndim(self.stays) == 0 else np.asarray(self.stays)[chosen],
        )

    def moved(self, settings: Array) -> PressTable:
        """Return the table with ``settings`` (6,) added: tilts [rad], strains and offsets [mm] of the molds."""
        if not np.any(settings):
            return self
        gap = self.gap
        for i in np.flatnonzero(settings):
            gap = gap + settings[i] * self.shift[i]
        if np.any(settings[:2]) and np.any(self.bend):
            gap = gap + 0.5 * (self.bend @ settings[:2]) @ settings[:2]
        return replace(self, gap=gap)

    @property
    def step(self) -> float:
        """Distance between openings [mm]."""
        return float(self.openings[1] - self.openings[0])

    def at(self, openings: Array, values: Array) -> Array:
        """Return ``values`` (k, n) at ``openings`` (m,), by cubics through the four nearest."""
        place = np.clip((openings - self.openings[0]) / self.step, 0.0, len(self.openings) - 1.0)
        first = np.clip(place.astype(np.int64) - 1, 0, len(self.openings) - 4)
        t = (place - first)[:, None]
        a, b, c, d = t, t - 1.0, t - 2.0, t - 3.0
        weights = (-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0)
        return np.asarray(sum(w * values[first + i] for i, w in enumerate(weights)))

    def force(self, openings: Array) -> Array:
        """Return the closing force (m,) [N] at ``openings``, of the law as it is."""
        pressure = self.sandwich.pressure(self.at(openings, self.gap))
        return np.asarray(np.sum(pressure * self.at(openings, self.push), axis=1))

    @cached_property
    def first_touch(self) -> float:
        """The opening [mm] at which the sandwich is first touched."""
        above = self.gap - self.sandwich.thickness
        over = above > 0.0
        index = np.clip(np.argmax(over, axis=0), 1, len(self.openings) - 1)
        n = np.arange(above.shape[1])
        low, high = above[index - 1, n], above[index, n]
        share = np.clip(-low / np.where(high > low, high - low, 1.0), -1.0, 2.0)
        return float(np.max(self.openings[index - 1] + share * self.step))


@dataclass(frozen=True)
class Moved:
    """The press with effects: the table of what bears, its correction, what scales the stress, how far [rad] a floating
    female has turned beyond the model's tilt, and the share of the foam's stress that is ``left`` in its law."""

    table: PressTable
    places: PressTable
    factor: float
    frame: Frame
    shift: float
    turn: Array
    left: float = 1.0

    def relaxed(self, left: float) -> Moved:
        """Return it with a share of the foam's stress: fabrics that give way keep theirs."""
        if left == 1.0:
            return self
        if self.table.fabric_law is None:
            return replace(self, factor=self.factor * left)
        law = self.table.law.scaled(left)
        return replace(self, table=replace(self.table, law=law), places=replace(self.places, law=law), left=left)


def press_table(
    closed: Closed, plan: Array, travel: float, stays: Array | float
) -> tuple[PressTable, PressTable, Array]:
    """Return tables of all vertices of the front, and of those the force is summed over with its correction (k,).

    ``plan`` (n, 2) are the front's coordinates of thickness variation; ``travel`` [mm] is the largest stroke from the
    first touch that was measured; ``stays`` (n,) is the share of the foam's strain that stays.
    """
    press, front = closed.press, closed.front
    low = min(closed.pose.opening, closed.first_touch - travel) - MARGIN
    high = max(closed.first_touch, closed.pose.opening) + MARGIN
    openings = np.linspace(low, high, _KNOTS)
    line = guide_line(closed.case.male)
    male_fixed = np.array([line[0], line[1], closed.case.male.mount])
    pivot = np.array(closed.pose.pivot)
    gaps, alongs, shifts, pushes, exact = [], [], [], [], []
    area = vertex_areas(front, np.ones(len(front.faces), dtype=bool))
    for opening in openings:
        pose = replace(closed.pose, opening=float(opening))
        found = press.at(pose)
        gaps.append(found.gap)
        touch = press.touch(pose, found.gap)[1]
        near = np.abs(found.gap) <= 1e-3  # the two are one where the molds meet
        alongs.append(np.where(near, 1.0, touch / np.where(near, 1.0, found.gap)))
        exact.append(found.closing_force)
        pushes.append(-area * found.direction[:, 2])
        up = np.array([0.0, 0.0, float(opening)])
        # The gap's gradient is taken at the male; the female moving by v shifts it by -v.
        lever = front.vertices - pivot - up
        projection = front.vertices - found.gap[:, None] * found.direction
        female_fixed = np.array([line[0], line[1], press.female.mount]) + up
        ways = (
            -np.cross([1.0, 0.0, 0.0], lever),
            -np.cross([0.0, 1.0, 0.0], lever),
            front.vertices - male_fixed,
            -(projection - female_fixed),
            np.array([-1.0, 0.0, 0.0]),
            np.array([0.0, -1.0, 0.0]),
        )
        shifts.append(np.stack([np.sum(found.direction * way, axis=1) for way in ways]))
    n = len(front.vertices)
    sandwich = press.sandwich
    table = PressTable(
        openings=openings,
        gap=np.stack(gaps),
        along=np.stack(alongs),
        shift=np.stack(shifts, axis=1),
        push=np.stack(pushes),
        area=area,
        foam=np.broadcast_to(np.asarray(sandwich.foam, dtype=np.float64), (n,)).copy(),
        fabric=np.broadcast_to(np.asarray(sandwich.fabric, dtype=np.float64), (n,)).copy(),
        law=sandwich.law,
        fabric_law=sandwich.fabric_law,
        plan=plan,
        stays=stays,
        bend=_bend(closed) if closed.case.floating else np.zeros((n, 2, 2)),
    )
    few = _summed(table)
    summed = few.force(openings)
    true = np.array(exact)
    sure = true > 0.02 * max(float(true.max()), 1e-300)
    ratio = np.where(sure, true / np.where(summed > 0.0, summed, 1.0), np.nan)
    known = np.flatnonzero(sure)
    ratio = np.interp(openings, openings[known], ratio[known]) if len(known) else np.ones(len(openings))
    return table, few, ratio


def _bend(closed: Closed) -> Array:
    """Return how the gap's gains (n, 2) by tilt change with tilt (n, 2, 2) at the answer, by central differences."""
    press, pose = closed.press, closed.pose
    lever = closed.front.vertices - np.array(pose.pivot) - np.array([0.0, 0.0, pose.opening])
    ways = [-np.cross(axis, lever) for axis in np.eye(3)[:2]]
    found = []
    for turn in np.eye(2) * _TURN:
        gains = []
        for sign in (1.0, -1.0):
            tilt = (pose.tilt[0] + sign * float(turn[0]), pose.tilt[1] + sign * float(turn[1]))
            direction = press.at(replace(pose, tilt=tilt)).direction
            gains.append(np.stack([np.sum(direction * way, axis=1) for way in ways], axis=1))
        found.append((gains[0] - gains[1]) / (2.0 * _TURN))
    return np.stack(found, axis=2)


def _summed(table: PressTable) -> PressTable:
    """Return the vertices that ever bear, thinned to what the sum needs; their areas stand for those left out."""
    bears = np.flatnonzero(np.min(table.gap, axis=0) < 1.3 * table.sandwich.thickness)
    if len(bears) <= _PLACES:
        return table.of(bears)
    # Band by band of height and around each band, so that every height and every side keep their share: a tilt that
    # opens one side as far as it closes the other must not change the force.
    by_height = bears[np.argsort(table.gap[len(table.openings) // 2, bears], kind="stable")]
    band = np.arange(len(bears)) * _BANDS // len(bears)
    side = table.shift[:2, 0, by_height]
    order = by_height[np.lexsort((np.arctan2(side[1], side[0]), band))]
    chosen = np.linspace(0, len(order) - 1, _PLACES).astype(np.int64)
    few, band_of = table.of(order[chosen]), band[chosen]
    whole = np.bincount(band, table.push[0, order])
    share = (whole / np.bincount(band_of, few.push[0]))[band_of]
    share = share * _worth(table, replace(few, push=few.push * share))
    return replace(few, push=few.push * share, area=few.area * share)


def _worth(table: PressTable, few: PressTable) -> Array:
    """Return factors (n,), as near to 1 as can be, with which the ``few`` places sum to the force of the whole table at
    each opening, and to what it is where a mold is turned, grown or moved a little."""
    sums, parts = [], []
    for settings in (np.zeros(len(_A_LITTLE)), *np.diag(_A_LITTLE)):
        sums.append(table.moved(settings).force(table.openings))
        there = few.moved(settings)
        parts.append(there.sandwich.pressure(there.gap) * few.push)
    force, part = np.concatenate(sums), np.concatenate(parts)
    sure = force > 0.02 * float(np.max(force))
    off = 1.0 - part[sure].sum(axis=1) / force[sure]
    return 1.0 + np.linalg.lstsq(part[sure] / force[sure, None], off, rcond=_RANK)[0]


#: Steps of Newton's method, and the difference its slopes are taken over [mm, rad].
_STEPS = 12
_DIFFERENCE = np.array([1e-4, 1e-6, 1e-6])
#: A tilt [rad] beyond which the table no longer holds.
_MOST = 0.05


def loads(table: PressTable, opening: float, tilt: Array) -> Array:
    """Return the closing force [N] and the moments [N mm] about the joint at an opening and further ``tilt`` (2,)."""
    at = np.array([opening])
    turns = np.stack([table.at(at, table.shift[i])[0] for i in (0, 1)], axis=1)
    bent = turns + 0.5 * table.bend @ tilt
    pressure = table.sandwich.pressure(table.at(at, table.gap)[0] + bent @ tilt)
    force = float(pressure @ table.at(at, table.push)[0])
    # By virtual work: the pressure acts on how the gap changes with the turn.
    return np.array([force, *((pressure * table.area) @ (turns + table.bend @ tilt))])


def found_tilt(table: PressTable, off: Array, opening: float, unbalanced: Callable[[float, float], float]) -> Array:
    """Return the tilt (2,) [rad] a floating female adds to the one the table stands at.

    ``off`` (2,) [mm] is where the table's own sum has the force's arm though it balances: what a thinned sum misses.
    ``unbalanced`` tells of an opening and the table's force there what has to vanish; ``opening`` is where it does
    without the tilt.
    """
    here = np.array([opening, 0.0, 0.0])

    def residual(place: Array) -> Array:
        load = loads(table, float(place[0]), place[1:])
        return np.array([unbalanced(float(place[0]), float(load[0])), *(load[1:] - off * load[0])])

    left = residual(here)
    for _ in range(_STEPS):
        slope = np.stack([(residual(here + d) - left) / d.sum() for d in np.diag(_DIFFERENCE)], axis=1)
        if not np.all(np.isfinite(slope)) or np.linalg.matrix_rank(slope) < 3:
            break
        step = -np.linalg.solve(slope, left)
        trial = here + step * min(1.0, 0.2 / max(abs(step[0]), 1e-30), 0.01 / max(np.abs(step[1:]).max(), 1e-30))
        trial[1:] = np.clip(trial[1:], -_MOST, _MOST)
        done = bool(np.abs(trial - here)[1:].max() < 1e-10)
        here, left = trial, residual(trial)
        if done:
            break
    return here[1:]
