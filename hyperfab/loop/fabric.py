"""Tests of a fabric as a problem of the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.curve import TestCurve
from hyperfab.loop.catalogue.fabric import DataContext, context_of, entries
from hyperfab.loop.catalogue.fabric.history import MOST_TAKEN
from hyperfab.loop.catalogue.fabric.mounting import MOST_OFF
from hyperfab.loop.fabric_constants import constants_of
from hyperfab.loop.fabric_menu import menu
from hyperfab.loop.fabric_tests import curves_of, hanging, path_of, ridden_states, smooth_of, states_of
from hyperfab.loop.near import predicted_near
from hyperfab.loop.problem import HAS_IT, Constant, Extra, Form, Problem
from hyperfab.loop.thresholds import MACHINE
from hyperfab.materials.effects import anisotropy, grip_slack, load_offset, mullins
from hyperfab.materials.effects.corners import cornered
from hyperfab.materials.effects.fabric import Fabric, Terms
from hyperfab.materials.effects.grip_slack import BENDS, STAYS
from hyperfab.materials.effects.path import (
    BIAXIAL,
    GENERAL,
    MODE_NAMES,
    SHEAR,
    UNIAXIAL,
    second_stretch,
    uniaxial_pull,
)
from hyperfab.materials.effects.threads import GROUND
from hyperfab.materials.hyperfoam import HyperfoamLaw
from hyperfab.materials.law import Law, Sheet, stresses

#: Effects that have a say in the stiffness at rest, and the least of it, as a share of the stiffness that the tests end
#: with: no sheet lengthens without a force.
_ELASTIC, _LEAST = ("anisotropy", "elastic-law"), 1e-3
#: The strain that is rest, a hair beyond where threads begin to bear, and that over which a slope is told.
_REST, _STEP = 1e-4, 1e-5
#: The kinds of tests whose stress rises with what tests of one of them add to a law.
_RISING = (UNIAXIAL, SHEAR, BIAXIAL)
#: Shares of the strain tested at which it is asked, closer at the start, where loops straighten.
_PLACES = tuple((k / 10.0) ** 2 for k in range(1, 11))


class Slopes(NamedTuple):
    """Slopes of the stress that are asked for: their names, the ``least`` of each, as a share of the stiffness that the
    tests end with, and ``pairs`` of rows over which they are told."""

    names: list[str]
    least: Array
    pairs: Fabric


@dataclass(kw_only=True)
class FabricProblem(Problem):
    """A law with constants, terms it already has, and the measured tests.

    Rows of channel 0 are stresses; those of channel 1 transverse stretches of uniaxial tests (``transverse_rows``).
    ``fabric`` has the rows read; ``whole`` is led through corners between them too, and is ``read`` (m,) at those.
    The columns of ``combinations`` (p, p) are the constants of the law that an own one stands for; None: each for one.
    """

    least_noise: ClassVar[float] = MACHINE
    plain: ClassVar[str] = "elastic-law"
    fabric: Fabric
    whole: Fabric
    read: Flags
    tests: Sequence[TestCurve]
    law: Law
    both: bool
    held: Mapping[str, tuple[str, tuple[float, ...]]]
    transverse_rows: Array
    remake: Callable[[Sequence[TestCurve]], FabricProblem]
    combinations: Array | None = None

    def of_own(self, own: Array) -> tuple[Array, Array | None, dict[str, tuple[str, Array]]]:
        """Return the law's constants along warp and weft (None: alike), and the terms the model already has."""
        count = len(self.law.names)
        at = count * (2 if self.both else 1)
        had: dict[str, tuple[str, Array]] = {}
        for name, (form, null) in self.held.items():
            had[name] = (form, own[at : at + len(null)])
            at += len(null)
        law = own[: count * (1 + self.both)].reshape(-1, count)
        if self.combinations is not None:
            law = law @ self.combinations.T
        return law[0], law[1] if self.both else None, had

    @property
    def expected(self) -> tuple[Constant, ...]:
        """The own constants; of combinations no document says what is known beforehand."""
        return self.own if self.combinations is None else ()

    def as_stated(self, own: Array) -> dict[str, float]:
        """Return the law's constants, along warp and weft where these differ, and those of the terms it has."""
        warp, weft, _ = self.of_own(own)
        of_law = warp if weft is None else np.concatenate([warp, weft])
        names = [f"{way}{name}" for way in (("warp ", "weft ") if self.both else ("",)) for name in self.law.names]
        names += [one.name for one in self.own[len(names) :]]
        return dict(zip(names, map(float, [*of_law, *own[len(of_law) :]]), strict=True))

    def predict(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Array:
        """Return stresses [MPa], then transverse stretches."""
        warp, weft, had = self.of_own(own)
        given = {**had, **terms}
        stress = self.whole.stress(warp, weft, given)[self.read]
        if len(self.transverse_rows) == 0:
            return stress
        return np.concatenate([stress, self.whole.across(given, warp, weft)[self.read][self.transverse_rows]])

    def predict_near(self, x: Array, forms: Mapping[str, Form], moved: Array) -> Array:
        """Return the predictions for sets of all constants next to ``x``."""
        constants = [*self.own, *(constant for form in forms.values() for constant in form.constants)]
        of_one = {place: one.curve for place, one in enumerate(constants) if one.curve is not None}
        every = super().predict_near
        # Tests that a form does not tell of have the mean of what it tells of all others.
        if not of_one or max(of_one.values()) + 1 < len(self.tests):
            return every(x, forms, moved)
        return predicted_near(x, moved, of_one, self._test, lambda sets: every(x, forms, sets))

    @cached_property
    def _test(self) -> Ints:
        """The number of the test of each row."""
        every = np.repeat(np.arange(len(self.tests)), [len(test.stretch) for test in self.tests])
        return np.concatenate([every, every[self.transverse_rows]])

    def look_alikes(self, forms: Mapping[str, Form]) -> Sequence[frozenset[str]]:
        """Return effects that these tests do not tell apart, whatever they read.

        Only second pulls, or several rates and holds, tell what makes loops; that one moves with the rate is told by
        several rates or holds alone. What grips give smoothly with the extension bends all curves of a kind as another
        law does, and those of all kinds as the terms of a foam may, beside which no free law is tried; what they give
        with the load does so where there is but one, or each direction's law is its own; beside a sheet whose warp and
        weft differ, and answer to each other, as its law would. Where each direction was tested at a temperature of its
        own, either may be what they differ by. A zero that wanders beside a stress that relaxes shows where a specimen
        waits or is let go: in pulls alone both go on as the stretch does, and a law that is not quite the fabric's
        leaves as much. Where all were pulled along both axes, what each arm has of its own is what warp and weft may
        differ by.
        """
        turns = self.both or "anisotropy" in self.held
        context = DataContext(self.law, (), self.fabric.path, self.measured, self.both, anisotropic=turns)
        alike = []
        gives = forms["grip-slack"].name if "grip-slack" in forms else ""
        given = {*forms, *self.held}
        one_curve = context.has_one_curve(turns="anisotropy" in given, softens="thermal-softening" in given)
        told = context.path.shorter is not None  # the same length is another strain in each
        bends = not told and gives in BENDS and (one_curve or ("anisotropy" in given and context.tells_coupling))
        any_law = context.has_one_mode or isinstance(self.law, HyperfoamLaw)
        if bends or (not told and gives == "smooth" and any_law):
            alike.append(frozenset({"grip-slack", "elastic-law"}))
        if context.each_way_at_its_own_heat:
            alike.append(frozenset({"anisotropy", "thermal-softening"}))
        wanders = "load-offset" in forms and forms["load-offset"].name in load_offset.IN_TIME
        if wanders and "rate" in given and not (context.unloads or np.any(context.path.still)):
            alike.append(frozenset({"load-offset", "elastic-law"}))
        if np.all(context.path.mode == GENERAL):
            arms = [name for name in ("grip-slack", "load-offset") if name in forms and forms[name].of_each]
            alike += [frozenset({name, "anisotropy"}) for name in arms]
        again = any(np.any(np.diff(context.path.up[rows]) > 0) for rows in context.path.curves)
        if context.unloads and not again:  # none was pulled once more after it was let go
            same = {"hysteresis", "mullins", "permanent-set"}
            if gives in STAYS:
                same.add("grip-slack")
            alike.append(frozenset(same if context.several_rates else {*same, "rate"}))
        if "rate" in forms and "hysteresis" not in given and not context.several_rates:
            alike.append(frozenset({"rate", "hysteresis"}))
        return alike

    @property
    def inexact(self) -> frozenset[str]:
        """The plain law, and that of the contraction where it was read."""
        return frozenset({self.plain, "compressibility"} if len(self.transverse_rows) else {self.plain})

    @property
    def has_valleys(self) -> bool:
        """Whether the law is not linear in its constants: else other starts only spare a long way."""
        return len(self.starts) > 0 and self.combinations is None

    def scaled(self, own: Array, factor: float) -> Array:
        """Return the constants with those that are stresses ``factor`` times as large."""
        names = [constant.name for constant in self.own]
        of_stress = np.isin(names, stresses(names))
        if self.combinations is not None:  # of a law that is linear in all of its constants
            of_stress[: len(self.law.names) * (1 + self.both)] = True
        return np.where(of_stress, factor * own, own)

    def forbidden(self, own: Array, terms: Mapping[str, tuple[str, Array]]) -> Mapping[str, float]:
        """Return by how much the modulus at rest along each direction tested falls short of what a sheet has.

        In units of the stiffness these tests show at their ends. Where terms are added to the law by tests of one
        kind, also by how much that and other kinds fall instead of rising, up to the invariant that these reach; by how
        much a load cell that drifts is too far off its zero; by how much softening takes more than all of the load; and
        by how much grips take back on the way of what they gave.
        """
        warp, weft, had = self.of_own(own)
        elastic = {name: term for name, term in {**had, **terms}.items() if name in _ELASTIC}
        off = {**self._zero_off(terms), **self._taken(terms), **self._taken_back(terms)}
        form = anisotropy.form_of(elastic)
        if form is not None and form.whole:
            # The ground of a sheet of threads is stable where none of its constants is below zero.
            of_law = dict(zip(self.law.names, map(float, warp), strict=True))
            every = form.constants(self.law, of_law, elastic["anisotropy"][1])
            ground = {name: value for name, value in every.items() if name in GROUND}
            asked = {name: -value / self._secant for name, value in ground.items()}
            soft = 6.0 * (ground.get("C10_MPa", 0.0) + ground.get("C2_MPa", 0.0) / 3.0) / self._secant
            return asked | {"Young's modulus at rest of the ground": _LEAST - soft} | off
        if "elastic-law" not in elastic:
            return off | self._falls_short(self._at_rest, warp, weft, elastic)
        # The law of a document stands by itself too: what is added to it stands elsewhere in there.
        itself = {name: term for name, term in elastic.items() if name != "elastic-law"}
        alone = self._falls_short(self._by_itself, warp, weft, itself)
        return off | alone | self._falls_short(self._rising, warp, weft, elastic)

    def _falls_short(self, slopes: Slopes, warp: Array, weft: Array | None, terms: Terms) -> dict[str, float]:
        low, high = slopes.pairs.stress(warp, weft, terms).reshape(-1, 2).T
        short = slopes.least - (high - low) / _STEP / self._secant
        return dict(zip(slopes.names, short.tolist(), strict=True))

    def _zero_off(self, terms: Mapping[str, tuple[str, Array]]) -> dict[str, float]:
        """Return by how much the zero of a load cell is farther off than one may be that stays."""
        if "load-offset" not in terms:
            return {}
        off = np.abs(load_offset.added(self.fabric.path, *terms["load-offset"]))
        peak = float(np.max(np.abs(self.measured[self.channel == 0]), initial=0.0)) or 1.0
        return {"zero of the load cell": float(np.max(off)) / peak - MOST_OFF}

    def _taken(self, terms: Mapping[str, tuple[str, Array]]) -> dict[str, float]:
        """Return by how much softening takes more of the load than leaves a specimen tight."""
        if "mullins" not in terms:
            return {}
        share = mullins.taken_at_rest(self.fabric.path.outward, *terms["mullins"])
        return {"load that softening takes": share - MOST_TAKEN}

    def _taken_back(self, terms: Mapping[str, tuple[str, Array]]) -> dict[str, float]:
        """Return by how much grips give less than they did before, though the pull went on."""
        if "grip-slack" not in terms:
            return {}
        back = grip_slack.taken_back(*terms["grip-slack"], self.fabric.path.reach)
        return {f"what grips take back at place {k}": float(one) for k, one in enumerate(back, 2)}

    @cached_property
    def _directions(self) -> Array:
        """The directions tested [deg], nan where none is stated."""
        known = np.unique(self.fabric.path.angle_deg[np.isfinite(self.fabric.path.angle_deg)])
        return known if len(known) else np.array([np.nan])

    @cached_property
    def _at_rest(self) -> Slopes:
        return self._slopes([f"Young's modulus at rest{_along(angle)}" for angle in self._directions], [])

    @cached_property
    def _by_itself(self) -> Slopes:
        names = [f"Young's modulus at rest of the law itself{_along(angle)}" for angle in self._directions]
        return self._at_rest._replace(names=names)

    @cached_property
    def _rising(self) -> Slopes:
        """Those at rest, and those of each kind of test along each direction, up to the largest I1 of its tests; not
        where several kinds hold the law, nor of a foam, whose plateau is flat."""
        path = self.fabric.path
        if len(np.unique(path.mode)) > 1 or isinstance(self.law, HyperfoamLaw):
            return self._at_rest
        reach, way = _I1(path.mode, path.stretch, path.across), np.nan_to_num(path.angle_deg)
        far = [float(np.max(reach[way == angle])) for angle in np.nan_to_num(self._directions)]
        stretch = np.linspace(1.0, float(np.sqrt(3.0 + max(far))), 2001)
        names, places = [*self._at_rest.names], []
        for mode in _RISING:
            ends = np.interp(far, _I1(np.full_like(stretch, mode), stretch, stretch), stretch)
            for angle, end in zip(self._directions, ends, strict=True):
                for share in _PLACES:
                    names.append(
                        f"slope of {MODE_NAMES[mode]} stress{_along(angle)} at {share:.0%} of the strain tested"
                    )
                    places.append((mode, angle, 1.0 + share * (end - 1.0)))
        return self._slopes(names, places)

    def _slopes(self, names: list[str], more: Sequence[tuple[int, float, float]]) -> Slopes:
        """Return the slopes at rest and at ``more`` places, which are told by kind of test, direction [deg] and
        stretch."""
        places = [*((UNIAXIAL, angle, 1.0 + _REST) for angle in self._directions), *more]
        modes, angles, ways = (np.repeat(one, 2) for one in zip(*places, strict=True))
        pull = replace(uniaxial_pull(ways + np.tile([0.0, _STEP], len(names))), mode=modes, angle_deg=angles)
        least = np.repeat([_LEAST, 0.0], [len(self._directions), len(more)])
        return Slopes(names, least, Fabric(self.law, pull, self.fabric.reference_degC))

    @cached_property
    def _secant(self) -> float:
        path = self.fabric.path
        far = np.abs(path.stretch - 1.0)
        first = self.measured[: len(far)]
        return float(np.max(np.abs(first)) / max(float(np.max(far)), 1e-9)) or 1.0

    def extras(self) -> Sequence[Extra]:
        """Return tests that could be done next, each with the problem it would make."""
        found = []
        for text, details, test in menu(self.tests):
            problem = self.remake([*self.tests, test])
            if np.all(np.isfinite(self.fabric.path.time_s)) == np.all(np.isfinite(problem.fabric.path.time_s)):
                found.append(Extra(text, details, problem))
        return found


def _I1(mode: Ints, stretch: Array, across: Array) -> Array:
    """Return I1 - 3 of tests, strips as they contract at constant volume."""
    return Sheet.of(stretch, second_stretch(mode, stretch, stretch**-0.5, across)).x


def _along(angle: float) -> str:
    if not np.isfinite(angle):
        return ""
    return {0.0: " along the warp", 90.0: " along the weft"}.get(float(angle), f" at {angle:g} degrees")


def fabric_problem(
    law: Law,
    warp: Sequence[float],
    tests: Sequence[TestCurve],
    *,
    weft: Sequence[float] | None = None,
    held: Mapping[str, tuple[str, tuple[Constant, ...]]] | None = None,
    fixed: Sequence[str] = (),
    prior: float | None = None,
    reference_degC: float | None = None,
    units: tuple[str, ...] = ("MPa", ""),
) -> FabricProblem:
    """Return the problem of tests of a fabric whose model is ``law`` with constants ``warp`` (and ``weft``).

    ``held`` are the effects the model already has; their constants are refitted along with the law's. ``fixed`` names
    constants that stay. ``prior`` is one relative standard deviation of the law's constants, None: they are free.
    """
    path, speed = path_of(tests)
    known = path.temperature_degC[np.isfinite(path.temperature_degC)]
    reference = reference_degC if reference_degC is not None else (float(np.min(known)) if len(known) else 20.0)
    stress = np.concatenate([test.stress for test in tests])
    held = held or {}
    ways = {"": warp} if weft is None else {"warp ": warp, "weft ": weft}
    had = [constant for _, constants in held.values() for constant in constants]
    plain = Fabric(law, path, reference)
    own, starts, combinations = constants_of(plain, ways, stress, had, fixed, prior)
    curves, rows, measured = curves_of(path, tests, stress)
    if ridden := ridden_states(tests, curves, measured):
        curves, rows, measured = curves_of(path, tests, stress, ridden)
    hang = None if isinstance(law, HyperfoamLaw) else hanging(path, curves, stress)
    fabric = Fabric(law, path, reference, speed, hang)
    way, near = cornered(path)
    whole = fabric if way is path else Fabric(law, way, reference, speed[near], None if hang is None else hang[near])
    both = weft is not None
    turns = both or "anisotropy" in held
    context = context_of(law, warp, path, tests, stress, ridden, len(rows) > 0, both=both, turns=turns)
    effects = tuple(replace(effect, not_sought=HAS_IT) if effect.id in held else effect for effect in entries(context))
    stated = None
    if all(test.stress_sd is not None for test in tests):
        stated = np.concatenate([test.stress_sd for test in tests] + [np.full(len(rows), np.nan)])

    def remake(others: Sequence[TestCurve]) -> FabricProblem:
        wider = fabric_problem(
            law, warp, others, weft=weft, held=held, fixed=fixed, prior=prior, reference_degC=reference, units=units
        )  # fmt: skip
        return replace(wider, own=own, combinations=combinations)

    return FabricProblem(
        measured=measured,
        curves=curves,
        own=own,
        effects=effects,
        states=states_of(path, tests, speed),
        ridden=ridden,
        stated_sd=stated,
        nuisance=smooth_of(path, len(measured)),
        units=units,
        starts=starts,
        fabric=fabric,
        whole=whole,
        read=np.diff(near, prepend=-1) > 0,
        tests=tuple(tests),
        law=law,
        both=both,
        held={name: (form, tuple(c.value for c in constants)) for name, (form, constants) in held.items()},
        transverse_rows=rows,
        remake=remake,
        combinations=combinations,
    )
