"""Thermocouples in a heated mold as a problem of the loop, on the reduced finite-element model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.loop.catalogue.heat import FARTHEST_K, FASTEST_K_S, DataContext, entries
from hyperfab.loop.problem import Constant, Curve, Extra, Form, Problem, split
from hyperfab.thermal.reduced import ReducedMold
from hyperfab.thermal.sensors import as_shown, lagging
from hyperfab.thermal.settings import Settings, air_drift
from hyperfab.thermal.tables import Table

#: Kinds of constants that a mold has of its own.
_KINDS = ("film", "conductivity", "capacity", "power", "joint", "start", "ambient")
#: What is known of the temperature at the start and of the ambient [K]: what a thermometer on the wall tells.
_LEVEL_SD = {"start": 0.5, "ambient": 1.0}
#: Standard deviations of its prior by which a constant may move; less those that could stand in for a bad joint.
_FAR, _FARTHEST = 9.0, {"conductivity": 6.0, "joint": 8.0}
#: Runs that could be done next: what to say, times in units of the present run, shares of the largest power then, and
#: whether a probe sits in each part.
_MENU = (
    ("heat up at full power, then cool down with the power off", (0.0, 0.5, 0.502, 1.5), (1.0, 1.0, 0.0, 0.0), False),
    ("a plateau at half the power, then full power", (0.0, 1.0, 1.002, 2.0), (0.5, 0.5, 1.0, 1.0), False),
    ("full power until it settles, then a quarter of it", (0.0, 1.5, 1.502, 2.5), (1.0, 1.0, 0.25, 0.25), False),
    ("power on and off four times, read closely",
     (0.0, 0.125, 0.126, 0.25, 0.251, 0.375, 0.376, 0.5), (1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0), False),
    ("the present run and a cool-down, with a thermocouple in each part (both sides of every joint)",
     (0.0, 0.5, 0.502, 1.5), (1.0, 1.0, 0.0, 0.0), True),
)  # fmt: skip


@dataclass(frozen=True)
class Run:
    """A reduced mold and the times [s] its probes were read at; ``kept`` are the readings there are, by probe."""

    mold: ReducedMold
    times: Array
    kept: Ints

    @cached_property
    def clock(self) -> tuple[Array, Ints]:
        """Times to compute at, from the start of the mold's clock on and close where much happens, and the read ones.

        A sensor lags behind what it has seen before the first reading, and between two.
        """
        begin, end = min(0.0, float(self.times[0])), float(self.times[-1])
        clock = np.union1d(self.mold.grid(begin, end), self.times)
        return clock, np.searchsorted(clock, self.times)

    @staticmethod
    def whole(mold: ReducedMold, times: Array) -> Run:
        """Return a run of which no reading is missing."""
        return Run(mold, times, np.arange(len(times) * len(mold.probes)))


@dataclass(kw_only=True)
class HeatProblem(Problem):
    """A reduced mold, the times and probes that were read, and the readings, probe after probe."""

    rich = 8
    well_known = True

    runs: Sequence[Run]
    kinds: Sequence[str]
    joints: Array
    pairs: Sequence[tuple[str, str]] = ()
    lag_s: Array = field(default_factory=lambda: np.zeros((2, 1)))
    names: Sequence[str]
    base: Sequence[str | tuple[int, int]] = ()
    tables: Mapping[str, Table] = field(default_factory=dict)
    #: Numbers of the heaters whose power was read.
    read: tuple[int, ...] = ()

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the temperatures [degC] of every probe at every time, probe after probe."""
        return self._run(own[None, :], [terms])[0]

    def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much the air would drift farther or faster than that of a room, and specific heat fall."""
        return {**self._of_room(terms), **self._of_solids(terms)}

    def _of_solids(self, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much the specific heat falls at the highest temperature, as a share within the rise of it."""
        amounts = self.amounts({name: term for name, term in terms.items() if name == "property-drift"})
        if "capacity_per_K2" not in amounts:
            return {}
        rise = float(np.ptp(self.measured))
        slope = amounts.get("capacity_per_K", 0.0) + 2.0 * amounts["capacity_per_K2"] * rise
        return {"how far specific heat falls": -slope * rise}

    def _of_room(self, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        if "ambient-drift" not in terms:
            return {}
        amounts = self.amounts({"ambient-drift": terms["ambient-drift"]})
        swing = float(np.hypot(amounts.pop("ambient_sin_K", 0.0), amounts.pop("ambient_cos_K", 0.0)))
        period = amounts.get("ambient_period_s", np.inf)
        clock = np.linspace(0.0, float(self.runs[0].times[-1]), 33)
        drift = air_drift(lambda name: amounts.get(name, 0.0), clock)
        far, fast = np.max(np.abs(drift)), np.max(np.abs(np.gradient(drift, clock, edge_order=2)))
        # A sine is steeper where it is steepest than what it stands for: from one end of a swing to the other counts.
        far, fast = float(far) + swing, float(fast) + 4.0 * swing / period
        return {
            "how far the air drifts": far / FARTHEST_K - 1.0,
            "how fast the air drifts": fast / FASTEST_K_S - 1.0,
        }

    def predict_many(self, own: Array, forms: Mapping[str, Form], values: Array) -> Array:
        """Return many predictions in one pass through time."""
        return self._run(own, [split(rest, forms) for rest in values])

    def predict_near(self, x: Array, forms: Mapping[str, Form], moved: Array) -> Array:
        """Return the predictions for sets of all constants next to ``x``, by the matrices of the run at ``x``."""
        own, every = len(self.own), np.vstack([x, moved])
        return self._run(every[:, :own], [split(rest, forms) for rest in every[:, own:]], beside=True)[1:]

    def given_off(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> list[Table]:
        """Return the power [W] that each heater brings into the mold over the first run, what is lost taken off."""
        mold = self.runs[0].mold
        clock, read, settings = self._read(np.stack([shape for shape, _ in mold.heaters]), own, terms)
        hot = read - mold.reference_degC
        names = ("lost", "lost_per_K", "lost_per_K2", "back_W_K", "wire_per_K")
        lost, rate, bend, back, wire = settings.of(0, *names)
        found = []
        for number, (_, table) in enumerate(mold.heaters):
            at = np.union1d(clock, table.x)
            above = np.interp(at, clock, hot[:, number])
            power = table(at) * settings.power[0, number]
            share = np.maximum(1.0 - lost - (rate + bend * above) * above, 0.0)
            share /= np.maximum(1.0 + wire * above, 0.05)
            found.append(Table(at, share * power - np.where(power == 0.0, 0.0, back * above)))
        return found

    def bench_degC(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Table:
        """Return how warm [degC] what the mold stands on is over the first run."""
        mold = self.runs[0].mold
        under = mold.bench.weights @ mold.bench.rows / np.sum(mold.bench.weights)
        clock, face, settings = self._read(under[None, :], own, terms)
        air = mold.surroundings(clock) + settings.air_K(0, clock)[:, -1]
        share, time = settings.of(0, "bench_share", "bench_s")
        follows, late = share * (face[:, 0] - air), max(time, 1e-9)
        # It follows the face as a sensor does, but begins as warm as the air.
        warmed = as_shown(clock, follows - follows[0], [late]) - follows[0] * np.expm1((clock[0] - clock) / late)
        return Table(clock, air + warmed)

    def joint_share(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Table:
        """Return how many times better the opened joints conduct over the first run than at the mold's start."""
        mold = self.runs[0].mold
        clock, mean, settings = self._read(mold.mean[None, :], own, terms)
        # It turns where it has closed.
        at = np.union1d(clock, np.clip(settings.of(0, "joint_tightens_s"), clock[0], clock[-1]))
        above = np.interp(at, clock, mean[:, 0]) - mold.reference_degC
        warm = 1.0 + np.maximum(settings.of(0, "joint_per_K") * above, -0.95)
        return Table(at, warm * settings.closes(0, at))

    def temperatures(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> tuple[Array, Array]:
        """Return the temperatures [degC] over the first run at which films and materials are read, row by row of time:
        those of the faces that have a film, and the parts' means.
        """
        mold = self.runs[0].mold
        _, found, _ = self._read(np.concatenate([mold.parts, *(face.rows for face in mold.films)]), own, terms)
        return found[:, len(mold.parts) :], found[:, : len(mold.parts)]

    def _read(self, probes: Array, own: Array, terms: Mapping[str, tuple[str, Array]]) -> tuple[Array, Array, Settings]:
        """Return the times [s] of the first run, what ``probes`` (p, n) read at these (t, p) [degC], and what the mold
        is run with."""
        run, (settings, _) = self.runs[0], self._settings(own[None, :], [terms])
        clock, _ = run.clock
        return clock, replace(run.mold, probes=probes).run(clock, settings)[0], settings

    def _run(self, own: Array, terms: Sequence[Mapping[str, tuple[str, Array]]], *, beside: bool = False) -> Array:
        settings, lags = self._settings(own, terms)
        # What differs in how late sensors follow alone is one run of the mold.
        settings, same = settings.distinct()
        rows = []
        for one in self.runs:
            clock, read = one.clock
            shown = one.mold.run(clock, settings, beside=beside)[same]
            for lag in lags:
                # Probes of a run to come that the present one does not have follow like the first.
                more = np.repeat(lag[:, :1], len(one.mold.probes) - lag.shape[1], axis=1)
                shown = lagging(clock, shown, np.maximum(np.hstack([lag, more]), 0.0))
            rows.append(shown[:, read].transpose(0, 2, 1).reshape(len(own), -1)[:, one.kept])
        return np.concatenate(rows, axis=1)

    def _settings(self, own: Array, terms: Sequence[Mapping[str, tuple[str, Array]]]) -> tuple[Settings, list[Array]]:
        """Return what the mold is run with, and the first and second lag [s] of the probes (b, p)."""
        count = len(own)
        mold = self.runs[0].mold
        moved: dict[str, Array] = {}
        for row, given in enumerate(terms):
            for place, amount in self.amounts(given).items():
                moved.setdefault(place, np.zeros(count))[row] = amount

        def each(name: str, numbers: range) -> Array:
            """Return what is added to each of several, (count, how many)."""
            none = np.zeros(count)
            return np.stack([none, *(moved.pop(f"{name}.{k}", none) for k in numbers)], axis=1)[:, 1:]

        new, old = len(mold.opened), len(self.joints)
        opened, added = each("resistance", range(new)), each("resistance", range(new, new + old))
        first, second = (moved.pop(name, np.zeros(count))[:, None] for name in ("lag_s", "second_lag_s"))
        lags = [self.lag_s[0] + first + each("lag_s", range(len(mold.probes))), self.lag_s[1] + second]
        of = {kind: own[:, [i for i, other in enumerate(self.kinds) if other == kind]] for kind in _KINDS}
        starts = of["start"]
        # The first is the start of all parts; the others say by how much a part began warmer.
        starts[:, 1:] += starts[:, :1]
        settings = Settings(
            film=of["film"],
            conductivity=of["conductivity"],
            capacity=of["capacity"],
            power=of["power"],
            joint=of["joint"] * self.joints / (1.0 + added * of["joint"] * self.joints),
            opened=opened,
            start_K=starts,
            ambient_K=of["ambient"],
            effects=moved,
        )
        return settings, lags

    def extras(self) -> Sequence[Extra]:
        """Return runs that could be done next, each with the problem it would make."""
        mold, times = self.runs[0].mold, self.runs[0].times
        begin = min(0.0, float(times[0]))
        whole = float(times[-1]) - begin
        most = [float(np.max(np.abs(table.y))) for _, table in mold.heaters]
        found = []
        for text, knots, levels, everywhere in _MENU:
            ends = begin + whole * np.array(knots)
            clock = np.linspace(begin, float(ends[-1]), 200)
            powered = [
                (shape, Table(ends, np.array(levels) * top)) for (shape, _), top in zip(mold.heaters, most, strict=True)
            ]
            probes = np.concatenate([mold.probes, mold.parts]) if everywhere else mold.probes
            run = Run.whole(
                replace(mold, heaters=powered, corners=tuple(float(t) for t in ends), probes=probes),
                clock,
            )
            rows = len(self.measured)
            curves = [
                Curve(f"{text}, probe {i}", rows + i * len(clock), rows + (i + 1) * len(clock), clock)
                for i in range(len(probes))
            ]
            details = {
                "time_s": [float(t) for t in ends],
                "power_share": list(levels),
                "probe_in_each_part": everywhere,
            }
            found.append(Extra(text, details, self.longer(curves, runs=[*self.runs, run])))
        return found


def _curve(name: str, first: int, times: Array, kept: Ints, jumps: Ints) -> Curve:
    """Return the curve of a probe whose readings would be the rows from ``first`` on, had none been missing."""
    start, stop = np.searchsorted(kept, [first, first + len(times)])
    cuts = start + np.searchsorted(kept[start:stop] - first, jumps)
    inside = sorted({int(cut) for cut in cuts if start < cut < stop})
    return Curve(name, int(start), int(stop), times[kept[start:stop] - first], tuple(inside))


def bounds_of(kind: str, prior: float) -> tuple[float, float]:
    """Return the least and the greatest factor that a constant of a kind may take, whose relative standard deviation is
    ``prior``."""
    reach = prior * _FARTHEST.get(kind, _FAR)
    return max(1.0 - reach, 0.05), 1.0 + reach


def heat_problem(
    mold: ReducedMold,
    times: Array,
    readings: Array,
    names: Sequence[str],
    own: Sequence[tuple[str, str]],
    joints: Sequence[float],
    prior: float,
    fixed: Sequence[str] = (),
) -> HeatProblem:
    """Return the problem of ``readings`` (times, probes) [degC], nan where one is missing.

    ``own`` are the keys of the mold's own constants and their kinds (film, conductivity, capacity, power,
    joint); they are factors on the document's values with a relative standard deviation ``prior``.
    """
    # Far from what the document says a constant would only stand in for what the model lacks.
    constants = tuple(
        Constant(key, 0.0, *((0.0, 0.0) if key in fixed else (-30.0, 30.0)), 0.5, _LEVEL_SD[kind])
        if kind in _LEVEL_SD
        else Constant(key, 1.0, *((1.0, 1.0) if key in fixed else bounds_of(kind, prior)), 0.1, prior)
        for key, kind in own
    )
    rows, count = len(times), len(names)
    power = sum(table(times) for _, table in mold.heaters) if mold.heaters else np.zeros(rows)
    jumps = np.flatnonzero(np.abs(np.diff(power)) > 0.02 * max(float(np.max(np.abs(power))), 1e-12)) + 1
    kept = np.flatnonzero(np.isfinite(readings.T))
    measured = readings.T.ravel()[kept]
    curves = tuple(_curve(name, i * rows, times, kept, jumps) for i, name in enumerate(names))
    air = mold.films[0].ambient if mold.films else None
    context = DataContext(
        duration_s=float(times[-1] - times[0]),
        rise_K=max(float(np.ptp(measured)), 1.0),
        power_W=max((float(np.max(np.abs(table.y))) for _, table in mold.heaters), default=1.0) or 1.0,
        films=len(mold.films),
        heaters=len(mold.heaters),
        opened=len(mold.opened),
        declared=len(mold.joints),
        probes=count,
        bench=len(mold.bench.weights) > 0,
        emits=bool(mold.radiators),
        typical_film=float(np.mean(mold.films[0].film(measured))) if mold.films else 10.0,
    )
    states = {
        "time_s": np.tile(times, count)[kept],
        "temperature_degC": measured,
        "heating rate_K_s": np.concatenate([np.gradient(measured[c.rows], c.abscissa) for c in curves]),
        "power_W": np.tile(power, count)[kept],
        "probe": np.repeat(np.arange(count, dtype=np.float64), rows)[kept],
    }
    if air is not None:
        states["above ambient_K"] = measured - np.tile(air(times), count)[kept]
    return HeatProblem(
        measured=measured,
        curves=curves,
        own=constants,
        effects=entries(context),
        states=states,
        units=("K",),
        runs=[Run(mold, times, kept)],
        kinds=tuple(kind for _, kind in own),
        joints=np.asarray(joints, dtype=np.float64),
        names=tuple(names),
    )
