"""Force over depth of a punch in a clamped sheet as a problem of the loop, on an emulated forward model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import CubicSpline

from hyperfab.loop.catalogue import catalogue
from hyperfab.loop.catalogue.contact.scene import Scene
from hyperfab.loop.emulator import Emulator
from hyperfab.loop.known import known, known_curve, sure, without_prior
from hyperfab.loop.problem import Array, Constant, Curve, Extra, Problem
from hyperfab.materials.effects.thermal_softening import factor

#: What is known of the depth's zero [mm].
ZERO_SD = 0.1
#: Readings of a file that are left out together, about.
_SEGMENT = 15
#: The effects in the order of the emulator's last settings: added prestretch, friction, slip of the rim.
EFFECTS = ("pretension", "friction", "rim-slip")


@dataclass(frozen=True)
class ForceDepth:
    """One file: depth (m,) [mm], force (m,) [N], the temperature (m,) [degC] where it is known, and what the model
    itself has the stiffness softened to there."""

    name: str
    depth: Array
    force: Array
    temperature: Array | None = None
    softened: Array | None = None

    @property
    def values(self) -> Array:
        """What was read."""
        return self.force


@dataclass(frozen=True)
class Sheet:
    """The emulated sheet: force over depth at ``knots`` (k,) [mm] for relative law constants and effects.

    ``correction`` (k,) is what finer meshes say of the force at the knots, over the emulated one. The law's constants
    are factors; those that are ``linear`` scale the whole force where they are alike, and the emulated settings are the
    ratios of the rest to the first. ``anchor`` (k,) is what of the correction came from a run at a finding.
    """

    emulator: Emulator
    knots: Array
    correction: Array
    names: tuple[str, ...]
    linear: tuple[bool, ...]
    anchor: Array
    friction: bool = True

    def force(self, own: Array, effects: Array, depth: Array) -> Array:
        """Return the force (m,) [N] at ``depth`` (m,) for factors ``own`` (p,) and effects (3,)."""
        scale = next((float(v) for v, one in zip(own, self.linear, strict=True) if one), 1.0)
        ratios = [v / scale if one else v for v, one in zip(own, self.linear, strict=True)]
        first = self.linear.index(True) if any(self.linear) else -1
        settings = np.array([*(v for i, v in enumerate(ratios) if i != first), *effects])
        # Force over depth: smooth, and finite at the first touch of a sheet under tension.
        stiffness = self.emulator(settings) * self.correction * scale
        spline = CubicSpline(self.knots, stiffness)
        inside = np.clip(depth, 0.0, None)
        return np.asarray(inside * spline(np.maximum(inside, self.knots[0] * 0.2)))


@dataclass
class ContactProblem(Problem):
    """A sheet and what was read while a punch went into it."""

    sheet: Sheet = field(kw_only=True)
    files: tuple[ForceDepth, ...] = field(kw_only=True)
    priors: tuple[Constant, ...] = field(kw_only=True)
    reference_degC: float = field(kw_only=True)
    scale: tuple[float, ...] = field(kw_only=True)
    measured_files: int = field(kw_only=True)
    rim_slip: float = field(default=0.0, kw_only=True)

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return the forces [N], then what is known of the constants, then further tests."""
        own = np.asarray(own, dtype=np.float64)
        law, zero = own[:-1], float(own[-1])
        effects = np.array([float(terms[name][1][0]) if name in terms else 0.0 for name in EFFECTS])
        found = []
        for one, scale in zip(self.files, self.scale, strict=True):
            force = self.sheet.force(law, effects, one.depth - zero)
            if "thermal-softening" in terms and one.temperature is not None:
                given = terms["thermal-softening"][1]
                force = force * factor(one.temperature, self.reference_degC, *(float(v) for v in given))
            if one.softened is not None:
                force = force * one.softened
            found.append(force * scale)
        found.insert(self.measured_files, known(self.priors, own))
        return np.concatenate(found)

    def extras(self) -> Sequence[Extra]:
        """Return what could be done next: other temperatures, the beginning read closely, all of it often."""
        deepest = float(max(np.max(one.depth) for one in self.files))
        usual = self.reference_degC
        menu = [
            ("the same test 40 K warmer, and again at room temperature", np.linspace(0.05, 1.0, 40), 40.0, 1.0),
            ("the first fifth of the depth, read with a load cell ten times finer, 40 readings",
             np.linspace(0.01, 0.2, 40), 0.0, 10.0),
            ("the whole depth five times, 200 readings", np.linspace(0.02, 1.0, 200), 0.0, 1.0),
        ]  # fmt: skip
        found = []
        for text, shares, warmer, finer in menu:
            depth = deepest * shares
            temperature = np.full(len(depth), usual)
            if warmer:
                temperature[::2] += warmer
            test = ForceDepth(text, depth, np.zeros(len(depth)), temperature)
            found.append(
                Extra(text, {"depth_mm": [float(depth[0]), float(depth[-1])]}, self.with_reading(test, finer))
            )
        return found

    def with_reading(self, test: ForceDepth, scale: float = 1.0) -> ContactProblem:
        """Return the problem with a further test at its end, its rows times ``scale``."""
        rows, size = len(self.measured), len(test.depth)
        return replace(
            self,
            files=(*self.files, test),
            scale=(*self.scale, scale),
            measured=np.concatenate([self.measured, np.zeros(size)]),
            curves=(*self.curves, Curve(test.name, rows, rows + size, test.depth)),
            states={},
        )


def contact_problem(
    sheet: Sheet,
    files: Sequence[ForceDepth],
    *,
    reference_degC: float,
    prior: float = 0.10,
    fixed: Sequence[str] = (),
    rim_slip: float = 0.0,
) -> ContactProblem:
    """Return the problem of force-depth files; each is cut into segments, which are left out in turn.

    ``rim_slip`` [mm per N/mm] is what the model's clamp gives already.
    """
    constants = [Constant(name, 1.0, 0.05, 20.0, 0.1, prior) for name in sheet.names]
    constants.append(Constant("depth.zero", 0.0, -5.0, 5.0, ZERO_SD, ZERO_SD))
    priors = tuple(
        replace(one, low=one.value, high=one.value, prior_sd=np.inf) if one.name in fixed else sure(one)
        for one in constants
    )
    curves, row = [], 0
    for one in files:
        count = max(1, min(4, len(one.depth) // _SEGMENT))
        for part in np.array_split(np.arange(len(one.depth)), count):
            curves.append(
                Curve(one.name, row + int(part[0]), row + int(part[-1]) + 1, one.depth[part], setup="")
            )
        row += len(one.depth)
    curves.append(known_curve(priors, row, 1))
    known_T = [one.temperature for one in files if one.temperature is not None]
    temperatures = np.unique(np.round(np.concatenate(known_T))) if known_T else np.empty(0)
    axes = {axis.name: axis for axis in sheet.emulator.axes}
    scene = Scene(
        deepest_mm=float(sheet.knots[-1]),
        temperatures=tuple(float(v) for v in temperatures),
        reference_degC=reference_degC,
        prestretch=(axes["prestretch"].down, axes["prestretch"].up),
        friction=axes["friction"].up if sheet.friction else 0.0,
        slip=axes["slip"].up,
    )
    measured = np.concatenate([*(one.force for one in files), np.zeros(curves[-1].stop - row)])
    depth = np.concatenate([one.depth for one in files])
    states = {"depth_mm": depth, "force_N": measured[:row]}
    if known_T and len(known_T) == len(files):
        states["temperature_degC"] = np.concatenate(known_T)
    return ContactProblem(
        measured=measured,
        curves=tuple(curves),
        own=without_prior(priors),
        effects=catalogue("contact", scene),
        states=states,
        units=("N",),
        sheet=sheet,
        files=tuple(files),
        priors=priors,
        reference_degC=reference_degC,
        scale=(1.0,) * len(files),
        measured_files=len(files),
        rim_slip=rim_slip,
    )
