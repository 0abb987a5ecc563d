"""Long runs that switch often, followed on a reduced mold between checks against the full one.

A stretch lies between two jumps: a thermostat that switches, a corner of a schedule. One of a few steps, between
thermostats that switch one shortly after the other, belongs to the next. After some stretches in full a basis is made
of the states on the way and of what the mold answers to each heater within the lengths of their steps (rational Krylov
vectors), and the run goes on in its coordinates, with the same steps and the same events. Some stretches are gone
through once more in full, from the same state with the same steps. What such a stretch is off by at its end counts for
all that end with the same heaters on: heat conduction lets no difference grow beyond its greatest (maximum principle),
so that the sum over the stretches bounds what has gathered. A switching that is off in time shifts all that comes after
it where nothing goes by the clock: the check goes on shifted, the shifts are summed too, and make what watched places
change in that time. With a clock they make what any place changes. Where the stretches to come would use up what is
left of ``MOST``, what the check found is added to the basis. Where the sum is more than what is due by then, the run
goes back to the end of the last checked stretch and on from there in full, until a new basis is made; after ``TRIES``
that were of no use it stays full.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.condition import Contact, Convection, Heater, Radiation, Thermostat
from hyperfab.thermal.history import History, Reduced, Target
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.projected import ProjectedModel, why_not
from hyperfab.thermal.run_basis import DROP, duration, lift_of, orthonormal
from hyperfab.thermal.step import Model, State, initial_state, stages, take_step
from hyperfab.thermal.trail import Lift

#: What the reduced mold may be off by, gathered over the run [K].
MOST = 0.05
#: Bases tried in vain, held for less long than they were waited for, before the run stays full.
TRIES = 5
#: Stretches in full before the first of them: the warm-up and a cycle, of a long run a cycle and a half.
FIRST, FIRST_OF_LONG = 3, 4
#: Share of it that may be used up at the beginning; the rest comes with the time.
HEAD_START = 0.25
#: What is left is followed in full where it has fewer stretches than this; on molds smaller than that, where steps are
#: cheap and a basis is as dear as some hundred of them, than ``MANY``.
SMALLEST, FEWEST, MANY = 2000, 8, 300
#: A stretch of fewer steps belongs to the next, and so many at most.
SETTLED, TOGETHER = 4, 8
#: Share of what is left of ``MOST``, and of that one kind's part, that stretches to come may take without what a check
#: found in the basis.
ENOUGH = 0.5
#: Stretches are steady that are off by no more than so many times what those like them were the time before.
STEADY = 1.1
#: Vectors that are kept; and directions of what a check found are left out that are less than this share of the most.
VECTORS, NOVEL = 160, 1e-3
#: What no check sees: the full mold's stages are solved to 1e-6 of what a step changes, some 10 K.
SOLVED = 1e-5
#: A thermostat switches at the end of a stretch where its probe is as near as this [K].
SWITCHES = 1e-6


@dataclass(frozen=True)
class View:
    """A mold as the run sees it, with what watches it: by nodes, or by the coordinates of ``lift``."""

    model: Model
    thermostats: Sequence[Thermostat]
    target: Target | None
    lift: Lift | None = None


@dataclass(frozen=True)
class _Stretch:
    """Where a stretch began: states and switchings so far, state, length of its first step, heaters that are on."""

    count: int
    switches: int
    state: State
    length: float
    on: tuple[bool, ...]


@dataclass(frozen=True)
class _Off:
    """What stretches are off by: in temperature at their ends [K], in the time of what comes after them [s]."""

    end: float = 0.0
    later: float = 0.0

    def __add__(self, other: _Off) -> _Off:
        return _Off(self.end + other.end, self.later + other.later)

    def times(self, count: int) -> _Off:
        return _Off(count * self.end, count * self.later)

    def at_most(self, other: _Off) -> _Off:
        return _Off(max(self.end, other.end), max(self.later, other.later))


@dataclass
class _Alike:
    """Stretches on a basis that end with the same heaters on: how many, and which of them is checked next.

    ``found`` is what the last check found, ``since`` how many came after it, ``before`` how many of these before the
    last check of any; ``widened`` is what was found when it came into the basis [K], until less than half or more than
    half as much again is.
    """

    count: int = 0
    next: int = 1
    found: _Off = field(default_factory=_Off)
    since: int = 0
    before: int = 0
    widened: float = np.inf


class Shortcut:
    """Decides on which mold to go on; ``sensors`` and ``nodes`` are where the result is looked at.

    ``full`` is the mold by nodes, ``until`` [s] the end; ``always`` begins with small molds and short runs too.
    """

    def __init__(self, full: View, until: float, sensors: Sequence[Array], nodes: Ints, *, always: bool) -> None:
        assert isinstance(full.model, HeatModel)
        self.model: HeatModel = full.model
        self.full, self.until, self.sensors, self.nodes = full, until, sensors, nodes
        self.always = always
        self._tries = self._stretches = self._checks = self._in_full = self._vectors = self._taken_back = 0
        self._waited = self._before = 0
        self._within = self._fastest = self._begun = 0.0
        # How fast the reading of a thermostat passed where it switched, at least [K/s].
        self._slowest = np.inf
        self._spent = _Off()
        self._alike: dict[tuple[bool, ...], _Alike] = {}
        self._now: list[_Stretch] = []  # the stretch gone through, with short ones before it
        self._ended = True
        self._found: list[Array] = []  # what the last check found on the way, where the basis is to have it
        self._checked: _Stretch | None = None  # where the last stretch that was checked ended
        self._since = 0
        self._clocked = _follows_a_clock(full)

    def turn(self, history: History, view: View, state: State, length: float) -> tuple[View, State]:
        """Return how to see the mold after a jump, and the state so seen; a stretch begins."""
        if view.lift is None and self._ended:
            self._in_full += 1
            if self._due(history, state.time):
                view = self._reduce(history, state)
                state = initial_state(view.model, state.time, np.zeros(self._vectors))
        elif view.lift is not None and self._found:
            view = self._widened(view, state)
            state = initial_state(view.model, state.time, np.zeros(self._vectors))
        on = tuple(heater.on for heater in self.model.heaters)
        begins = _Stretch(len(history.states), len(history.switches), state, length, on)
        self._now = [begins] if self._ended else [*self._now, begins]
        if self._ended and self._since == 0:
            self._checked = begins
        return view, state

    def holds(self, history: History, view: View) -> bool:
        """Whether the stretch that has ended may stay as it is; a full one may, a reduced one is checked at times."""
        now = history.states[-1].time
        self._slowest = min([self._slowest, *_passing(history, view)])
        steps = len(history.states) - (self._now[-1].count if self._now else 0)
        self._ended = steps >= SETTLED or len(self._now) >= TOGETHER or now >= self.until
        if view.lift is None or not self._ended:
            return True
        alike = self._alike.setdefault(self._now[-1].on, _Alike())
        alike.count += 1
        alike.since += 1
        self._stretches += len(self._now)
        self._since += len(self._now)
        if alike.count < alike.next and now < self.until:
            return True
        within, found = self._check(history, view.lift)
        self._checks += 1
        within = max(self._within, within)
        spent = self._spent + found.at_most(alike.found).times(alike.since - 1) + found
        others = [one for one in self._alike.values() if one is not alike]
        error = within + self._kelvin(sum((one.found.times(one.since) for one in others), spent))
        share = HEAD_START + (1.0 - HEAD_START) * (now - self._begun) / (self.until - self._begun)
        left = share * MOST - error
        if left < 0.0:
            return False
        self._spent, self._within = spent, within
        steady = self._kelvin(found) <= STEADY * self._kelvin(alike.found)
        alike.found, alike.since, self._since = found, 0, 0
        for one in self._alike.values():
            one.before = one.since
        self._tell(history, error)
        self._plan(history, alike, steady, left, MOST - error)
        return True

    def _plan(self, history: History, alike: _Alike, steady: bool, due: float, left: float) -> None:
        """Say which stretch like the one just checked is the next, and whether the basis shall have what was found.

        ``due`` [K] is left by now, ``left`` to the end; ``steady`` where no more was found than the time before.
        """
        kinds = self._alike.values()
        now = history.states[-1].time
        took = duration(history, now)
        # Each may be off by twice what was found; where that is steady, what comes to be due meanwhile pays for it too.
        each = 2.0 * sum(self._kelvin(one.found) for one in kinds)
        if steady:
            each -= (1.0 - HEAD_START) * MOST * len(kinds) * took / (self.until - self._begun)
        affordable = due / each if each > 0.0 else np.inf
        # Odd and even stretches take turns: levels of a schedule that come and go.
        alike.next = alike.count + int(max(1, alike.count // 8, min(8 * alike.count - 1, affordable)))
        ahead = (self.until - now) / took
        coming = ahead * alike.count / sum(one.count for one in kinds)
        here = self._kelvin(alike.found)
        much = coming * here > ENOUGH * left / len(kinds)
        if not 0.5 * alike.widened <= here <= 1.5 * alike.widened:  # it was of use, or there is more to find
            alike.widened = np.inf
        if much and np.isinf(alike.widened) and self._vectors < VECTORS:
            alike.widened, alike.next = here, alike.count + 1
        else:
            self._found = []

    def _kelvin(self, off: _Off) -> float:
        """Return by how much all that makes watched places differ [K]."""
        return off.end + off.later * self._fastest

    def back(self, history: History, view: View) -> tuple[View, State, float]:
        """Return to the end of the last checked stretch, in full: view, state and the length of the first step."""
        begun = self._checked
        assert begun is not None
        assert view.lift is not None
        history.cut(begun.count, begun.switches)
        for heater, on in zip(self.model.heaters, begun.on, strict=True):
            heater.on = on
        self._stretches -= self._since
        if self._stretches - self._before >= self._waited:  # it has paid: the next is waited for no longer
            self._tries -= 1
        self._since, self._in_full, self._now, self._found = 0, 0, [begun], []
        self._taken_back += 1
        self._spent = sum((one.found.times(one.before) for one in self._alike.values()), self._spent)
        self._alike = {}
        self._tell(history, self._within + self._kelvin(self._spent))
        temperature = view.lift.nodal(begun.state.temperature)
        return self.full, initial_state(self.model, begun.state.time, temperature), begun.length

    def _tell(self, history: History, error: float) -> None:
        history.reduced = Reduced(
            self._vectors, self._begun, self._stretches, self._checks, error + SOLVED, self._taken_back
        )

    def _due(self, history: History, now: float) -> bool:
        # The first stretch is the warm-up; a mold that is still far from its cycle gets longer from try to try.
        first = FIRST if self.always else FIRST_OF_LONG
        if self._in_full < max(first, 2**self._tries) or self._tries >= TRIES:
            return False
        if self.always:
            return True
        return self.until - now >= _fewest(self.model) * duration(history, now)

    def _reduce(self, history: History, state: State) -> View:
        """Return the mold in the coordinates of a basis about ``state``."""
        lift = lift_of(self.model, self.full.thermostats, history, state, self.until, VECTORS)
        self._tries += 1
        self._waited, self._before = self._in_full, self._stretches
        if not self._checks:
            self._begun = state.time
        return self._seen(lift, state.time)

    def _widened(self, view: View, state: State) -> View:
        """Return the mold about ``state`` on a basis that has what the last check found too."""
        lift, narrow = view.lift, view.model
        assert lift is not None
        assert isinstance(narrow, ProjectedModel)
        found, basis = np.stack(self._found, axis=1), lift.basis
        capacity = self.model.pattern.matrix(self.model.medium.capacity(lift.origin))
        self._found = []
        room, most = VECTORS - basis.shape[1], float(np.abs(found).max())

        def beyond(vectors: Array) -> Array:
            return np.asarray(vectors - basis @ (basis.T @ (capacity @ vectors)))

        found = beyond(found)
        found = orthonormal(found, capacity, max(NOVEL * float(np.abs(found).max()), DROP * most), room)
        found = orthonormal(beyond(found), capacity, 0.0, room)  # once more, against rounding
        return self._seen(lift.wider(lift.nodal(state.temperature), found), state.time, narrow)

    def _seen(self, lift: Lift, time: float, narrow: ProjectedModel | None = None) -> View:
        """Return the mold in the coordinates of a basis; ``narrow`` is it in the first of them."""
        self._vectors = lift.basis.shape[1]
        thermostats = []
        for one in self.full.thermostats:
            row, at_origin = lift.sensor(one.sensor)
            thermostats.append(Thermostat(one.heater, row, one.set_point - at_origin, one.band))
        target = self.full.target
        if target is not None:
            row, at_origin = lift.sensor(target.sensor)
            target = Target(row, target.value - at_origin)
        return View(ProjectedModel(self.model, lift, time, narrow), thermostats, target, lift)

    def _check(self, history: History, lift: Lift) -> tuple[float, _Off]:
        """Go through the stretch in full: by how much watched places are off on the way [K], and all at its end."""
        begun = self._now[0].state
        before = begun.temperature
        reduced = lift.nodal(before)
        state = initial_state(self.model, begun.time, reduced)
        within = shifts = 0.0
        self._found = []
        ends = [one.count for one in self._now[1:]] + [len(history.states)]
        for stretch, end in zip(self._now, ends, strict=True):
            for heater, on in zip(self.model.heaters, stretch.on, strict=True):
                heater.on = on
            for past in history.states[stretch.count : end]:
                length, now = past.time - state.time, past.coordinates
                assert past.coordinates_slope is not None
                foretold = stages(now - before, past.coordinates_slope, length)
                first, whole = (lift.basis @ np.stack(foretold, axis=1)).T
                reduced = reduced + whole
                step = take_step(self.model, state, length, estimate=False, guesses=(first, whole))
                state = replace(step.state, time=past.time)
                assert state.slope is not None
                before = now
                off = reduced - state.temperature
                self._found.append(off)
                within = max(within, float(np.abs(off[self.nodes]).max(initial=0.0)))
                changing = state.slope if self._clocked else state.slope[self.nodes]
                self._fastest = max(self._fastest, float(np.abs(changing).max(initial=0.0)))
                for sensor in self.sensors:
                    within = max(within, abs(past.reading(sensor)[0] - dot(sensor, state.temperature)))
                    self._fastest = max(self._fastest, abs(dot(sensor, state.slope)))
            assert state.slope is not None
            felt = self._switches(reduced)
            rate = 0.0 if felt is None else dot(felt, state.slope)
            later = dot(felt, off) / rate if felt is not None and rate != 0.0 else 0.0
            shifts += abs(later)
            if rate != 0.0 and stretch is not self._now[-1]:
                moved = state.temperature if self._clocked else state.temperature + later * state.slope
                state = initial_state(self.model, state.time, moved)
        # Where nothing goes by the clock, what is off along the way that the state goes is off in time alone.
        assert state.slope is not None
        along = later * state.slope
        most = float((np.abs(off) + np.abs(along) if self._clocked else np.abs(off - along)).max())
        # What is off elsewhere comes to a probe too, and is felt there in switchings to come: all of it counts.
        return within, _Off(most, shifts + most / self._slowest)

    def _switches(self, temperature: Array) -> Array | None:
        """Return the sensor of a thermostat that switches at these temperatures, if any does."""
        for one in self.full.thermostats:
            if abs(one.excess(temperature)) <= SWITCHES:
                return one.sensor
        return None


def _passing(history: History, view: View) -> list[float]:
    """Return how fast the readings pass of the thermostats that switch now [K/s]."""
    _, now, slope = history.states.entry(len(history.states) - 1)
    if slope is None:
        return []
    switching = [one for one in view.thermostats if abs(one.excess(now)) <= SWITCHES]
    return [rate for one in switching if (rate := abs(dot(one.sensor, slope))) > 0.0]


def _follows_a_clock(full: View) -> bool:
    """Whether anything changes by the time of day: then a shift in time is more than a shift."""
    model = full.model
    tables = [c.power for c in model.conditions if isinstance(c, Heater)]
    tables += [c.closed for c in model.conditions if isinstance(c, Contact)]
    tables += [c.ambient for c in model.conditions if isinstance(c, Convection | Radiation)]
    return not all(table.is_constant for table in tables)


def is_long(model: HeatModel, history: History) -> bool:
    """Whether a run in full had so many stretches and unknowns that a shortcut would have paid."""
    return len(history.jumps) >= _fewest(model) + 3


def _fewest(model: HeatModel) -> int:
    return FEWEST if int(model.free.sum()) >= SMALLEST else MANY


def shortcut_for(
    full: View, until: float | None, sensors: Sequence[Array], nodes: Ints, wanted: bool | None
) -> tuple[Shortcut | None, str | None]:
    """Return a shortcut where one may be taken, or why it may not, in words.

    ``wanted`` None leaves it to size and length, True takes it from the first, False never.
    """
    assert isinstance(full.model, HeatModel)
    if wanted is False:
        return None, "not wanted"
    if until is None:
        return None, "the run has no end in time"
    why = why_not(full.model)
    if why is not None:
        return None, why
    return Shortcut(full, until, sensors, nodes, always=wanted is True), None
