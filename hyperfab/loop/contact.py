"""Force over depth of a punch in a clamped sheet as a problem of the loop, on an emulated forward model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from hyperfab.arrays import Array, Ints
from hyperfab.loop.catalogue.contact import DataContext, entries
from hyperfab.loop.emulator import Emulator
from hyperfab.loop.known import SURE, FilesProblem
from hyperfab.loop.problem import Constant, Curve, Extra
from hyperfab.loop.scatter import Guess, guess_of_curve
from hyperfab.loop.slack import Slack
from hyperfab.materials.effects.thermal_softening import factor

#: What is known of the depth's zero [mm].
ZERO_SD = 0.1
#: Readings of a file that are left out together, about.
_SEGMENT = 15
#: What effects add to, in the order of the emulator's last settings, the pull up to which the clamp holds, what the
#: machine yields by, and the sphere's radius, which the emulator has before those.
ADDED = ("prestretch", "friction", "slip", "hold", "frame", "sphere")
#: Rounds in which the slip past a hold and the pull settle on each other; stiffnesses a changing one is taken at.
_ROUNDS, _STIFFNESSES = 8, 3
#: Newton's steps to where the punch is, as moves of it [mm]: how small the last one is, and their number at most.
_SETTLED, _STEPS = 1e-7, 60


@dataclass(frozen=True)
class ForceDepth:
    """One file: depth (m,) [mm], force (m,) [N], the temperature (m,) [degC] where it is known, and what the model
    itself has the stiffness softened to there; the coefficient of ``friction`` where that is known of the test, and the
    ``sd`` (m,) that it states of its forces."""

    name: str
    depth: Array
    force: Array
    temperature: Array | None = None
    softened: Array | None = None
    friction: float | None = None
    sd: Array | None = None

    kind: ClassVar[str] = "force"

    @property
    def values(self) -> Array:
        """What was read."""
        return self.force

    @property
    def index(self) -> Ints:
        """Where the rows stand in the file: it is left whole."""
        return np.arange(len(self.force))

    def guess(self, predicted: Array) -> Guess:
        """Return how loud the forces seem, by local differences less a prediction (m,)."""
        return guess_of_curve(self.force - predicted, self.depth, level=self.force, state=self.temperature)


@dataclass(frozen=True)
class Sheet:
    """The emulated sheet: force over depth at ``knots`` (k,) [mm] for relative law constants and effects, and then the
    pull of its rim [N/mm] there.

    ``correction`` (k,) is what finer meshes say of the force at the knots, over the emulated one. The law's constants
    are factors; those that are ``linear`` scale the whole force where they are alike, and the emulated settings are the
    ratios of the rest to the first. ``anchor`` (k,) is what of the correction came from a run at a finding.
    ``slacker`` emulates a sheet mounted slack, by the ``slack`` that tells at which knot it is: None where the model
    has another prestretch than none. ``coefficient`` of friction, ``slip`` [mm per N/mm] and ``frame`` [mm/N], by which
    the machine yields, are what the model has already.
    """

    emulator: Emulator
    knots: Array
    correction: Array
    names: tuple[str, ...]
    linear: tuple[bool, ...]
    anchor: Array
    friction: bool = True
    coefficient: float = 0.0
    slip: float = 0.0
    frame: float = 0.0
    slack: Slack | None = None
    slacker: Emulator | None = None

    @property
    def slackest(self) -> float:
        """How slack a sheet may be that it stands for."""
        axes = () if self.slacker is None else self.slacker.axes
        return sum(-axis.up for axis in axes if axis.name == "prestretch")

    @cached_property
    def of_any_sphere(self) -> bool:
        """Whether it stands for spheres of other radii too."""
        return any(axis.name == "sphere" for axis in self.emulator.axes)

    def slack_of(self, larger: float) -> Slack | None:
        """Return what tells a slack sheet over a sphere that is so much larger [mm]."""
        return None if self.slack is None else self.slack.over(larger)

    def force(self, own: Array, effects: Array, depth: Array, soft: Array | None = None) -> Array:
        """Return the force (m,) [N] at ``depth`` (m,), as the machine reads it, for factors ``own`` (p,) and effects
        (6,): added prestretch, friction and slip, the pull [N/mm] up to which the clamp holds, what the machine yields
        by [mm/N], and what the sphere's radius is more [mm]. ``soft`` (m,) scales the stiffness."""
        read = np.clip(depth, 0.0, None)
        resist = self.resistance(own, effects, np.ones(len(read)) if soft is None else soft)
        frame = self.frame + effects[4]
        if not frame:
            return resist(read)
        punch = read
        for _ in range(_STEPS):
            force = resist(punch)
            slope = np.maximum((resist(punch + 1e-5) - force) / 1e-5, 0.0)
            move = (punch + frame * force - read) / (1.0 + frame * slope)
            punch = np.clip(punch - move, 0.0, read)
            if np.max(np.abs(move)) < _SETTLED:
                break
        return resist(punch)

    def resistance(self, own: Array, effects: Array, soft: Array) -> Callable[[Array], Array]:
        """Return what tells the force (m,) [N] at depths (m,) of the punch in the sheet, none negative."""
        levels = np.unique(soft)
        if not (self.slip or effects[2]):
            # Without a clamp that gives, the force goes with the stiffness.
            levels = np.ones(1)
        between = len(levels) > _STIFFNESSES + 1
        if between:
            levels = np.linspace(levels[0], levels[-1], _STIFFNESSES)
        splines = [self._spline(own, effects, float(level)) for level in levels]
        added, slack = float(effects[0]), self.slack_of(float(effects[5]))

        def force(depth: Array) -> Array:
            at = depth
            if slack is not None and added < 0.0:
                at, depth = slack.knots(depth, added), slack.taut(depth, added)
            at = np.maximum(at, self.knots[0] * 0.2)
            found = np.stack([level * spline(at) for level, spline in zip(levels, splines, strict=True)])
            if len(levels) == 1:
                return np.asarray(depth * (soft / levels[0]) * found[0])
            if between:
                return np.asarray(depth * _parabola(levels, found, soft))
            return np.asarray(depth * found[np.searchsorted(levels, soft), np.arange(len(at))])

        return force

    def scale(self, own: Array) -> float:
        """Return the factor of the whole force."""
        return next((float(v) for v, one in zip(own, self.linear, strict=True) if one), 1.0)

    def ratios(self, own: Array) -> list[float]:
        """Return the emulated settings of the law."""
        scale = self.scale(own)
        first = self.linear.index(True) if any(self.linear) else -1
        return [float(v) / scale if one else float(v)
                for i, (v, one) in enumerate(zip(own, self.linear, strict=True)) if i != first]  # fmt: skip

    def slips(self, own: Array, effects: Array, soft: float) -> Array:
        """Return the slip (k,) that the emulator is asked for at the knots.

        A stiffer sheet slips as one on a softer clamp; a clamp that holds at first slips as a spring of its own at each
        depth.
        """
        scale = self.scale(own) * soft
        count = len(self.knots)
        given = np.full(count, float(effects[2]))

        def asked(slip: Array) -> Array:
            return np.asarray((self.slip + slip) * scale - self.slip)

        if effects[3] > 0.0:
            most = given.copy()
            for _ in range(_ROUNDS):
                pull = scale * np.diagonal(self._at(own, effects, asked(given))[:, count:])
                given = most * np.maximum(1.0 - effects[3] / np.maximum(pull, 1e-12), 0.0)
        return asked(given)

    def _at(self, own: Array, effects: Array, slips: Array) -> Array:
        """Return what the emulator says, a row for each of ``slips``."""
        settings = np.tile(self._settings(own, effects, 0.0), (len(slips), 1))
        settings[:, -1] = slips
        return self._emulated(effects)(settings)

    def _settings(self, own: Array, effects: Array, slip: float) -> list[float]:
        """Return the emulator's settings (d,), the slip last."""
        sphere = [effects[5]] if self.of_any_sphere else []
        return [*self.ratios(own), *sphere, effects[0], effects[1], slip]

    def _emulated(self, effects: Array) -> Emulator:
        return self.slacker if self.slacker is not None and effects[0] < 0.0 else self.emulator

    def _spline(self, own: Array, effects: Array, soft: float) -> CubicSpline:
        """Force over depth: smooth, and finite at the first touch of a sheet under tension."""
        return CubicSpline(self.knots, self.stiffness(own, effects, soft))

    def stiffness(self, own: Array, effects: Array, soft: float) -> Array:
        """Return force over depth (k,) [N/mm] at the knots."""
        slips, count, emulator = self.slips(own, effects, soft), len(self.knots), self._emulated(effects)
        if np.all(slips == slips[0]):
            found = emulator(np.array(self._settings(own, effects, slips[0])))[:count]
        else:
            found = np.diagonal(self._at(own, effects, slips)[:, :count])
        return np.asarray(found * self.correction * self.scale(own))


def _parabola(levels: Array, values: Array, at: Array) -> Array:
    """Return the parabola through ``values`` (3, m) at three ``levels``, each row at its own place ``at`` (m,)."""
    a, b, c = levels
    return np.asarray(
        values[0] * (at - b) * (at - c) / ((a - b) * (a - c))
        + values[1] * (at - a) * (at - c) / ((b - a) * (b - c))
        + values[2] * (at - a) * (at - b) / ((c - a) * (c - b))
    )


@dataclass
class ContactProblem(FilesProblem[ForceDepth]):
    """A sheet and what was read while a punch went into it."""

    sheet: Sheet = field(kw_only=True)
    reference_degC: float = field(kw_only=True)

    def added(self, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the effects (6,) as ``Sheet.force`` takes them."""
        amounts = self.amounts(terms)
        return np.array([amounts.get(name, 0.0) for name in ADDED])

    def shown(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> list[Array]:
        """Return the forces [N] of each test."""
        law, zero = own[:-1], float(own[-1])
        effects = self.added(terms)
        found = []
        for one in self.every:
            soft = np.ones(len(one.depth))
            if "thermal-softening" in terms and one.temperature is not None:
                given = terms["thermal-softening"][1]
                soft = soft * factor(one.temperature, self.reference_degC, *(float(v) for v in given))
            if one.softened is not None:
                soft = soft * one.softened
            here = effects
            if one.friction is not None:
                here = np.array([effects[0], one.friction - self.sheet.coefficient, *effects[2:]])
            found.append(self.sheet.force(law, here, one.depth - zero, soft))
        return found

    def extras(self) -> Sequence[Extra]:
        """Return what could be done next: other temperatures, the beginning read closely, all of it often."""
        deepest = float(max(np.max(one.depth) for one in self.files))
        usual = self.reference_degC
        whole = np.linspace(0.02, 1.0, 200)
        menu: list[tuple[str, Array, float, float, float | None]] = [
            ("the same test 40 K warmer, and again at room temperature", np.linspace(0.05, 1.0, 40), 40.0, 1.0, None),
            ("the first fifth of the depth, read with a load cell ten times finer, 40 readings",
             np.linspace(0.01, 0.2, 40), 0.0, 10.0, None),
            ("the whole depth five times, 200 readings", whole, 0.0, 1.0, None),
        ]  # fmt: skip
        if self.sheet.friction:
            text = (
                'the same test with the punch oiled or powdered until nothing rubs, 60 readings, "# friction: 0" on '
                "top of its file"
            )
            menu.append((text, np.linspace(0.05, 1.0, 60), 0.0, 1.0, 0.0))
        found = []
        for text, shares, warmer, finer, coefficient in menu:
            depth = deepest * shares
            temperature = np.full(len(depth), usual)
            if warmer:
                temperature[::2] += warmer
            test = ForceDepth(text, depth, np.zeros(len(depth)), temperature, friction=coefficient)
            details: dict[str, object] = {"depth_mm": [float(depth[0]), float(depth[-1])]}
            if coefficient is not None:
                details["friction"] = coefficient
            found.append(Extra(text, details, self.with_reading(test, finer)))
        return found


def _way(one: ForceDepth) -> tuple[int, str, float | None]:
    """Return how a sheet was pushed: into how many segments its file is cut, how warm [degC], with which friction."""
    warm = "" if one.temperature is None else f"{np.mean(one.temperature):.0f} to {np.max(one.temperature):.0f}"
    return max(1, min(4, len(one.depth) // _SEGMENT)), warm, one.friction


def contact_problem(
    sheet: Sheet,
    files: Sequence[ForceDepth],
    *,
    reference_degC: float,
    prior: float = 0.10,
    fixed: Sequence[str] = (),
) -> ContactProblem:
    """Return the problem of force-depth files; each is cut into segments, which are left out in turn."""
    constants = [Constant(name, 1.0, 0.05, 20.0, 0.1, prior) for name in sheet.names]
    constants.append(Constant("depth.zero", 0.0, -5.0, 5.0, ZERO_SD, ZERO_SD))
    curves, row = [], 0
    ways = [_way(one) for one in files]
    for one, way in zip(files, ways, strict=True):
        # Sheets pushed alike are specimens of one cloth, and differ in stiffness.
        again = ways.count(way) > 1
        for k, part in enumerate(np.array_split(np.arange(len(one.depth)), way[0])):
            begin, setup, specimen = row + int(part[0]), f"{way} {k}" if again else "", one.name if again else ""
            curves.append(Curve(one.name, begin, begin + len(part), one.depth[part], setup=setup, specimen=specimen))
        row += len(one.depth)
    known_T = [one.temperature for one in files if one.temperature is not None]
    temperatures = np.unique(np.round(np.concatenate(known_T))) if known_T else np.empty(0)
    axes = {axis.name: axis for axis in sheet.emulator.axes}
    model = np.array([axis.base for axis in sheet.emulator.axes])
    at_rest = sheet.emulator(model)
    deepest = len(sheet.knots) - 1
    reach = axes["sphere"].up if "sphere" in axes else 0.0
    # A sphere of another radius is nearly a factor on the force, as the law's constants are.
    sphere = sheet.emulator(np.where([name == "sphere" for name in axes], reach, model))
    off = abs(float(sphere[deepest] / at_rest[deepest]) - 1.0)
    context = DataContext(
        temperatures=tuple(float(v) for v in temperatures),
        reference_degC=reference_degC,
        prestretch=(max(axes["prestretch"].down, sheet.slackest), axes["prestretch"].up),
        friction=axes["friction"].up if sheet.friction else 0.0,
        slip=axes["slip"].up,
        pull=float(at_rest[-1]),
        yields=1.0 / max(float(at_rest[deepest]), 1e-12),
        larger=reach,
        taken_up=off <= SURE * prior and not {*fixed} & {*sheet.names},
    )
    depth, force = (np.concatenate(rows) for rows in zip(*((one.depth, one.force) for one in files), strict=True))
    states = {"depth_mm": depth, "force_N": force}
    if known_T and len(known_T) == len(files):
        states["temperature_degC"] = np.concatenate(known_T)
    return ContactProblem.posed(
        files,
        curves,
        constants,
        fixed,
        effects=entries(context),
        states=states,
        units=("N",),
        sheet=sheet,
        reference_degC=reference_degC,
    )
