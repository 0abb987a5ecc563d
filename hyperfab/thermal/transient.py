"""The warm-up: adaptive steps, events hit exactly, and the account of heat kept at every step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.errors import NotConverged
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.condition import Renewal, Thermostat
from hyperfab.thermal.history import History, Ledger, Target
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.shortcut import Shortcut, View
from hyperfab.thermal.step import Model, State, Step, along, initial_state, stages, take_step
from hyperfab.thermal.trail import Past, Trail

#: Step-size control: the error of a step falls with the third power of its length.
ORDER = 3
SAFETY = 0.85
LEAST_FACTOR, GREATEST_FACTOR = 0.2, 5.0

#: An event is hit when its quantity is this near [K], or the step is known to this share.
EVENT_TEMPERATURE = 1e-7
EVENT_TIME = 1e-12

#: Without an end time the run stops where the watched temperature would change less than this in all time left [K].
SETTLED = 1e-3
#: ... or its thermostats have switched so often, or so much time has gone by [s].
MOST_SWITCHES = 400
LONGEST = 60 * 86400.0
#: A run of more time steps has gone astray.
MOST_STEPS = 100_000


@dataclass(frozen=True)
class Schedule:
    """How long to run: to ``until`` [s], or to the target where that is None; ``corners`` are hit exactly."""

    until: float | None
    corners: Sequence[float] = ()
    tolerance: float = 0.1


def run(
    model: HeatModel,
    start: Array,
    schedule: Schedule,
    *,
    target: Target | None = None,
    thermostats: Sequence[Thermostat] = (),
    renewals: Sequence[Renewal] = (),
    finished: Callable[[History], bool] = lambda history: False,
    shortcut: Shortcut | None = None,
    advance: Callable[[Past], None] = lambda now: None,
) -> History:
    """Follow the temperatures from ``start`` (n,) [degC] at time 0.

    ``finished`` is asked at every corner whether to stop there; a ``shortcut`` may see the mold by the coordinates of a
    basis for a while; ``advance`` is told the state after every step, or every stretch of a reduced mold.
    Raises NotConverged where the step falls below any use or more than ``MOST_STEPS`` are taken.
    """
    state = initial_state(model, 0.0, start)
    history = History(Trail([state]), Ledger.begin(model, model.total(state.stored), [r.name for r in renewals]))
    held = model.hold(0.0, start)  # what thermostats and the target meet first: held places jump at once
    for thermostat in thermostats:
        thermostat.heater.on = True
    _set(thermostats, held)
    corners = sorted({t for t in (*schedule.corners, *(t for r in renewals for t in r.times)) if t > 0.0})
    end = schedule.until
    length = _first_length(model, state, schedule)
    if target is not None and dot(target.sensor, held) >= target.value:
        history.reached = 0
    view = View(model, thermostats, target)
    while end is None or state.time < end:
        stop = min([c for c in corners if c > state.time] + ([end] if end is not None else []), default=None)
        length, last = _fit(length, state.time, stop)
        step, length, rejected = _accepted(view.model, state, length, schedule.tolerance)
        last = last and rejected == 0
        history.rejected += rejected
        following = length * _factor(step.error, schedule.tolerance)
        step, events, hit_target = _stop_at_event(view, state, step, history.reached is None)
        if last and stop is not None and abs(step.state.time - stop) <= EVENT_TIME * stop:
            step = replace(step, state=replace(step.state, time=stop))
        state = step.state
        history.states.append(state, view.lift)
        history.residual = max(history.residual, step.residual)
        history.ledger.add(step.entered(view.model), view.model.total(state.stored), step.moved)
        if hit_target:
            history.reached = len(history.states) - 1
            if end is None:
                break
        if stop is not None and state.time == stop and finished(history):
            break
        jump = bool(events) or (stop is not None and state.time == stop)
        if jump or view.lift is None:
            advance(history.states[-1])
        if jump and shortcut is not None and not shortcut.holds(history, view):
            view, state, length = shortcut.back(history, view)
            continue
        for event in events:
            event.switch()
        if events:
            history.switches.append(state.time)
        if jump:
            history.jumps.append(len(history.states) - 1)
            before = state.rate
            state = _after_jump(view.model, state, renewals, history, thermostats)
            speed = view.model.speed(state.rate - before)
            following = min(following, 10.0 * schedule.tolerance / speed) if speed > 0 else following
            if shortcut is not None:
                view, state = shortcut.turn(history, view, state, following)
        if end is None and target is not None and _never(history, target, model.total_capacity(state.temperature)):
            history.settled = True
            break
        length = following
        if len(history.states) > MOST_STEPS:
            raise NotConverged(
                f"{MOST_STEPS} time steps did not reach the end",
                remedy="widen the thermostat's band or the tolerance",
            )
    model.changed()  # the room is for what is made of the result
    return history


def _after_jump(
    model: Model,
    state: State,
    renewals: Sequence[Renewal],
    history: History,
    thermostats: Sequence[Thermostat],
) -> State:
    """Return the state with which to go on: parts that come fresh now are put in, the flow is found anew."""
    temperature, stored = state.temperature, state.stored
    for renewal in renewals:
        if state.time in renewal.times:
            temperature = temperature.copy()
            renewal.apply(temperature)
            stored = model.stored(temperature)
            history.ledger.exchange(renewal.name, model.total(stored))
            model.changed()
            # A probe in a fresh part jumps past where it would have switched.
            if _set(thermostats, temperature):
                history.switches.append(state.time)
    return State(state.time, temperature, stored, model.flow(state.time, temperature))


def _set(thermostats: Sequence[Thermostat], temperature: Array) -> bool:
    """Switch the thermostats whose probes have jumped past their switching temperature; whether any had."""
    passed = [one for one in thermostats if one.excess(temperature) >= 0.0]
    for one in passed:
        one.switch()
    return bool(passed)


def _first_length(model: HeatModel, state: State, schedule: Schedule) -> float:
    """Guess a first step: ten times the time in which the fastest mean change makes the allowed error."""
    speed = model.capacity_norm(state.rate / model.lumped_capacity)
    guess = 10.0 * schedule.tolerance / speed if speed > 0 else np.inf
    return min(guess, (LONGEST if schedule.until is None else schedule.until) / 20)


def _fit(length: float, time: float, stop: float | None) -> tuple[float, bool]:
    """Shorten or stretch a step so that it ends at ``stop``, or halves the way to it when it is near."""
    if stop is None:
        return length, False
    left = stop - time
    if length >= left * (1.0 - 1e-9):
        return left, True
    return (left / 2, False) if length > left / 2 else (length, False)


def _accepted(model: Model, state: State, length: float, tolerance: float) -> tuple[Step, float, int]:
    """Take a step, shorter until its stages settle and its error is allowed."""
    unsettled: NotConverged | None = None
    for rejected in range(40):
        try:
            step = take_step(model, state, length)
        except NotConverged as error:  # a film that falls steeply: the shorter the step, the more storage outweighs it
            unsettled = error
            length *= LEAST_FACTOR
        else:
            if step.error <= tolerance:
                return step, length, rejected
            length *= min(_factor(step.error, tolerance), 0.9)
        if length <= 1e-12 * max(state.time, 1e-6):
            break
    if unsettled is not None:
        raise unsettled
    raise NotConverged(f"the time step at {state.time:.6g} s falls below any use", remedy="check tables for jumps")


def _factor(error: float, tolerance: float) -> float:
    if error <= 0.0:
        return GREATEST_FACTOR
    return float(np.clip(SAFETY * (tolerance / error) ** (1.0 / ORDER), LEAST_FACTOR, GREATEST_FACTOR))


def _stop_at_event(view: View, start: State, step: Step, waiting: bool) -> tuple[Step, list[Thermostat], bool]:
    """Shorten the step to the first event inside it: thermostats that switch, or the target reached."""
    model, target, thermostats = view.model, view.target, view.thermostats
    due = False
    hit = False
    if target is not None and waiting:
        wanted = target

        def missing(temperature: Array) -> float:
            return dot(wanted.sensor, temperature) - wanted.value

        if missing(step.state.temperature) >= 0.0:
            step = shortened(model, start, step, missing)
            hit = True
    for thermostat in thermostats:
        if thermostat.excess(step.state.temperature) >= 0.0 > thermostat.excess(start.temperature):
            shorter = shortened(model, start, step, thermostat.excess)
            hit = hit and shorter.state.time >= step.state.time
            step, due = shorter, True
    # Heaters that ask the same probe switch together.
    now = step.state.temperature
    return step, [t for t in thermostats if due and t.excess(now) >= -EVENT_TEMPERATURE], hit


def shortened(model: Model, start: State, step: Step, excess: Callable[[Array], float]) -> Step:
    """Find the step length at which ``excess`` of the end temperatures is zero.

    ``excess`` is linear in them, below zero at the start and not at the end of ``step``. The first guess is where the
    cubic of that step crosses zero, the next where the line through the last two does, or the middle of what is left;
    each step begins at what the cubic of the one before foretells.
    """
    low, high = 0.0, step.state.time - start.time
    length, found, value = high, step, excess(step.state.temperature)
    before = None
    trial = 0
    while abs(value) > EVENT_TEMPERATURE and high - low > EVENT_TIME * max(high, start.time):
        rise, begin, end = _piece(start, found.state, length)
        if before is None:
            begins = excess(start.temperature)
            slopes = [excess(start.temperature + one) - begins for one in (begin, end)]
            wanted = length * _crossing(begins, value - begins, *slopes)
        else:
            wanted = length - value * (length - before[0]) / (value - before[1])
        trial += 1
        if not low < wanted < high or trial % 6 == 0:
            wanted = 0.5 * (low + high)
        change, slope = along(rise, begin, end, wanted / length)
        guesses = stages(change, slope / length, wanted)
        found = take_step(model, start, wanted, estimate=False, guesses=guesses)
        before = length, value
        length, value = wanted, excess(found.state.temperature)
        if value >= 0.0 or abs(value) <= EVENT_TEMPERATURE:
            high, step = length, found
        else:
            low = length
    return step


def _piece(start: State, end: State, length: float) -> tuple[Array, Array, Array]:
    """Return the rise over a step and the slopes at its ends, of the whole step; a parabola's where it began anew."""
    assert end.slope is not None
    rise, last = end.temperature - start.temperature, length * end.slope
    return rise, 2.0 * rise - last if start.slope is None else length * start.slope, last


def _crossing(value: float, rise: float, begin: float, end: float) -> float:
    """Return at what share of a step a cubic from ``value`` below zero comes to zero, by Newton's method from its end.

    >>> round(_crossing(-0.25, 1.0, 0.0, 2.0), 12)  # a parabola
    0.5
    """
    share = 1.0
    for _ in range(20):
        risen, slope = along(rise, begin, end, share)
        if slope <= 0.0:
            break
        share -= (value + risen) / slope
    return share


def _never(history: History, target: Target, capacity: float) -> bool:
    """Whether the mold has come to rest, or swings about its thermostats, short of the target.

    The mean heating rate of the whole mold decays geometrically at the end; what is left of it is its sum.
    """
    if len(history.switches) > MOST_SWITCHES or history.states[-1].time > LONGEST:
        return True
    if len(history.states) < 4 or (history.jumps and history.jumps[-1] > len(history.states) - 3):
        return False
    before, now = history.states[-2], history.states[-1]
    missing = target.value - dot(target.sensor, now.temperature)
    earlier, rate = (float(s.rate.sum()) / capacity for s in (before, now))
    if rate <= 0.0:
        return earlier <= 0.0 and dot(target.sensor, now.temperature - before.temperature) <= 0.0
    if rate >= earlier:
        return False
    left = rate * (now.time - before.time) / math.log(earlier / rate)
    return left < SETTLED and left < missing
