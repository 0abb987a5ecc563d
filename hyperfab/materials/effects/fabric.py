"""What tests of a fabric read: a strain-energy law, and the effects on top of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from hyperfab.arrays import Flags
from hyperfab.materials.effects import (
    anisotropy,
    compressibility,
    elastic_law,
    grip_slack,
    hysteresis,
    load_offset,
    mullins,
    permanent_set,
    rate,
    thermal_softening,
)
from hyperfab.materials.effects.columns import Columns
from hyperfab.materials.effects.kept import Kept, told
from hyperfab.materials.effects.path import GENERAL, MODE_NAMES, SIMPLE_SHEAR, Acts, Path, State
from hyperfab.materials.effects.threads import Threads
from hyperfab.materials.hyperfoam import Hyperfoam, HyperfoamLaw, Rows
from hyperfab.materials.law import Array, Law, scaled

#: A term: its form and its constants, in the order of the form.
Terms = Mapping[str, tuple[str, Array]]
#: Steps to the largest stretch of a test in which grips find what the specimen bears.
_STEPS = 200
#: An effect that is not there.
_NONE = ("", np.empty(0))
#: The effects within the law.
_IN_LAW: Mapping[str, Mapping[str, Any]] = {
    "anisotropy": anisotropy.FORMS,
    "compressibility": compressibility.FORMS,
    "elastic-law": elastic_law.FORMS,
}
#: The effects on the stress, in the order in which they act: the fabric's own, then time's, then the machine's.
_ON_STRESS = {
    "thermal-softening": thermal_softening.FORMS,
    "mullins": mullins.FORMS,
    "hysteresis": hysteresis.FORMS,
    "rate": rate.FORMS,
    "load-offset": load_offset.FORMS,
}
#: Effects on the load that are there from the first pull on, at any pace: what grips that yield feel.
_BORNE = (*_IN_LAW, "thermal-softening")
#: Effects of the machine that reads the stress, whatever that is; the last that acts.
_OF_THE_MACHINE = ("load-offset",)
#: Effects whose constants are told at a reference temperature.
AT_A_TEMPERATURE = ("thermal-softening", "rate")
#: Forms of what rides on history that leave a first pull as the law has it.
SPARES_FIRST_PULL: Mapping[str, Sequence[str]] = {
    "mullins": mullins.SPARES_FIRST_PULL,
    "hysteresis": hysteresis.SPARES_FIRST_PULL,
    "permanent-set": permanent_set.SPARES_FIRST_PULL,
}


@dataclass
class Fabric:
    """Predicts the stress of every row of ``path`` for a law, its constants and effects.

    ``reference_degC`` is the temperature the constants are of; ``speed`` the strain rate of a row [1/s],
    nan where unknown. What rides on history, on time and on the mounting takes a pressed specimen for one pulled as far
    (``Path.outward``). Of rows that ``hang`` the stress is never below zero: a sheet on its way back goes slack where
    it would have to push.
    """

    law: Law
    path: Path
    reference_degC: float = 20.0
    speed: Array | None = None
    hang: Flags | None = None
    _cut: Kept = field(default_factory=Kept, repr=False)
    _foams: Kept = field(default_factory=Kept, repr=False)
    _widths: Kept = field(default_factory=Kept, repr=False)
    _places: Kept = field(default_factory=Kept, repr=False)
    _states: Kept = field(default_factory=Kept, repr=False)
    _stages: Kept = field(default_factory=Kept, repr=False)

    def stress(self, warp: Array, weft: Array | None, terms: Terms) -> Array:
        """Return the nominal stress [MPa] of every row.

        ``warp`` and ``weft`` are the law's constants in its order; without ``weft`` both directions are
        alike. An effect that is not among ``terms`` leaves no trace: the result is bit for bit that of the law.
        """
        terms = _present(terms)
        needs_energy = "mullins" in terms or terms.get("hysteresis", ("",))[0] in hysteresis.OF_ENERGY
        with np.errstate(all="ignore"):
            *stretches, place = self._stretches(terms, warp, weft)
            own = (told(warp), None if weft is None else told(weft), _named(terms, _IN_LAW))
            key: tuple[object, ...] = (place, needs_energy, own)
            stress, energy = self._stages.of(
                key, lambda: self._before_effects(warp, weft, terms, stretches, place, needs_energy)
            )

            def acted(acts: Acts, before: Array, values: Array) -> tuple[Array]:
                [there] = self._states.of(place, lambda: (Kept(),))
                state = State(self.path.outward, stretches[0], energy, self.reference_degC, self.speed, kept=there)
                return (acts(state, before, values),)

            for name, forms in _ON_STRESS.items():
                if name in _OF_THE_MACHINE:
                    stress = self._turned * stress
                    if self.hang is not None:
                        stress = np.where(self.hang, np.maximum(stress, 0.0), stress)
                if name in terms:
                    form, values = terms[name]
                    # A slope by a constant of one effect asks for what the others before it answer once more.
                    key = (key, name, form, told(values))
                    [stress] = self._stages.of(key, partial(acted, forms[form], stress, values))
        return np.asarray(stress)

    @cached_property
    def _columns(self) -> Columns:
        return Columns(self.law, self.path)

    @cached_property
    def _turned(self) -> Array:
        return np.where(self.path.pressed, -1.0, 1.0)

    def _before_effects(
        self,
        warp: Array,
        weft: Array | None,
        terms: Terms,
        stretches: Sequence[Array],
        place: tuple[object, ...],
        needs_energy: bool,
    ) -> tuple[Array, Array]:
        """Return stress and energy of the law, with what the specimen keeps."""
        stretch, side, rest = stretches
        itself, turned = self.path.mirrored, self._turned
        kept, values = terms.get("permanent-set", _NONE)
        stress, energy = self._elastic(warp, weft, terms, (itself(stretch), side), place, needs_energy)
        stress = turned * stress
        if kept in permanent_set.NETWORKS:
            peak = self._peak(self.path.outward, stretch)
            second = (itself(stretch / peak), side)
            more, _ = self._elastic(warp, weft, terms, second, (*place, "second"), needs_energy)
            stress = permanent_set.second_network(stress, turned * more, peak, *values)
        elif kept:
            stress = stress * permanent_set.FORMS[kept].section(rest, values)
        return stress, energy

    def across(self, terms: Terms, warp: Array | None = None, weft: Array | None = None) -> Array:
        """Return the transverse stretch of uniaxial rows; the other rows are without meaning.

        ``warp`` and ``weft`` are the law's constants: a sheet of threads asks for them, and grips that yield.
        """
        terms = _present(terms)
        stretch, side, rest, place = self._stretches(terms, warp, weft)
        stretch = self.path.mirrored(stretch)

        def contracted(stretch: Array, where: str) -> Array:
            if "compressibility" in terms:
                form, values = terms["compressibility"]
                across = compressibility.FORMS[form].across
                [width] = self._widths.of((where, place, form, *values), lambda: (across(self.path, stretch, values),))
                return np.asarray(width)
            if warp is None or not self.law.compressible:
                return np.asarray(stretch**-0.5)
            if isinstance(self.law, HyperfoamLaw):
                return self._of_foam(warp, terms, (stretch, side))[2]
            _, theta = self.law.split(dict(zip(self.law.names, map(float, warp), strict=True)))
            return np.asarray(stretch ** -self.law.contraction(theta))

        if _is_of_threads(terms) and not compressibility.is_of_width(terms):
            assert warp is not None
            with np.errstate(all="ignore"):
                found = self._of_threads(warp, terms, (stretch, side), place)[2]
        else:
            found = contracted(stretch, "pulled")
        kept, values = terms.get("permanent-set", _NONE)
        power = permanent_set.FORMS[kept].contraction(values) if kept in permanent_set.FORMS else 0.0
        return found if power == 0.0 else found * contracted(self.path.mirrored(1.0 + rest), "at rest") ** power

    def strained(self, terms: Terms, warp: Array, weft: Array | None) -> Array:
        """Return how far the specimen is stretched in every row, its set included: without what the grips gave."""
        given = {name: term for name, term in _present(terms).items() if name != "permanent-set"}
        return np.asarray(self.path.mirrored(self._stretches(given, warp, weft)[0]))

    def _stretches(
        self, terms: Terms, warp: Array | None, weft: Array | None
    ) -> tuple[Array, Array, Array, tuple[object, ...]]:
        """Return the elastic stretch, that along a general biaxial test's other axis, the set, and what tells them."""
        slack, kept = terms.get("grip-slack", _NONE), terms.get("permanent-set", _NONE)
        if kept[0] not in permanent_set.FORMS:
            kept = _NONE
        place = _named(terms, ("grip-slack", "permanent-set"))
        if slack[0] in grip_slack.OF_LOAD:
            place += (_named(terms, _BORNE), *(None if one is None else told(one) for one in (warp, weft)))

        def led() -> tuple[Array, Array, Array]:
            path = self.path.outward
            stretch, side = path.stretch, path.across
            if slack[0] in grip_slack.OF_LOAD:
                stretch = self._yielded(terms, warp, weft)
            elif slack[0]:
                stretch = grip_slack.FORMS[slack[0]](path, stretch, slack[1])
            rest = np.zeros_like(stretch)
            if kept[0]:
                stretch, rest = self._without_set(path, stretch, *kept)
                if np.any(path.mode == GENERAL):
                    side, _ = self._without_set(path.other_axis, side, *kept)
            return stretch, side, rest

        return *self._places.of(place, led), place

    def _yielded(self, terms: Terms, warp: Array | None, weft: Array | None) -> Array:
        """Return the stretch of specimens whose grips give with the load that the law has them bear."""
        assert warp is not None
        form, values = terms["grip-slack"]
        steps = self._in_steps
        bears = {name: term for name, term in terms.items() if name in _BORNE}
        turned = np.where(steps.path.pressed, -1.0, 1.0)
        load = np.maximum(np.nan_to_num(turned * steps.stress(warp, weft, bears)), 0.0)
        gives, stays = grip_slack.OF_LOAD[form](load, values), form in grip_slack.STAYS
        path, way = self.path.outward, steps.path.outward
        if way.shorter is not None:
            gives = gives * way.shorter
        found = np.empty_like(path.stretch)
        for rows, of in zip(path.curves, way.curves, strict=True):
            found[rows] = grip_slack.yielded(path.stretch[rows], way.stretch[of], gives[of], stays)
        return found

    @cached_property
    def _in_steps(self) -> Fabric:
        """What reads each test on a way of even steps out, as far as it went and a little beyond."""
        path, count = self.path.outward, _STEPS
        first = np.repeat([rows.start for rows in path.curves], count)
        tops = np.array([rows.start + int(np.argmax(path.stretch[rows])) for rows in path.curves])
        reach = 1.1 * np.maximum(path.stretch[tops] - 1.0, 1e-6)
        # Closer at the start, where the load rises steeply.
        stretch = 1.0 + np.outer(reach, np.linspace(0.0, 1.0, count) ** 2).ravel()
        far = np.repeat(tops, count)
        ratio = (path.across[far] - 1.0) / np.maximum(path.stretch[far] - 1.0, 1e-9)
        unknown = np.full(len(stretch), np.nan)
        stretch = np.where(self.path.pressed[first], 1.0 / stretch, stretch)
        way = Path(
            starts=tuple(range(0, len(stretch) + 1, count)),
            mode=path.mode[first],
            stretch=stretch,
            across=1.0 + ratio * (stretch - 1.0),
            time_s=unknown,
            temperature_degC=path.temperature_degC[first],
            angle_deg=path.angle_deg[first],
            branch=np.ones(len(stretch), dtype=np.int64),
            lengths_mm=path.lengths_mm,
        )
        return Fabric(self.law, way, self.reference_degC)

    def _without_set(self, path: Path, stretch: Array, form: str, values: Array) -> tuple[Array, Array]:
        of = permanent_set.FORMS[form]
        return of.lengthens(path, stretch, self._peak(path, stretch), values[: of.takes])

    def _peak(self, path: Path, stretch: Array) -> Array:
        if stretch is path.stretch:
            return path.peak
        found = np.empty_like(stretch)
        for rows in path.curves:
            found[rows] = np.maximum(np.maximum.accumulate(stretch[rows]), 1.0)
        return found

    def _elastic(
        self,
        warp: Array,
        weft: Array | None,
        terms: Terms,
        stretches: tuple[Array, Array],
        place: tuple[object, ...],
        needs_energy: bool,
    ) -> tuple[Array, Array]:
        if _is_of_threads(terms):
            return self._of_threads(warp, terms, stretches, place)[:2]

        def of(constants: Array, across: bool = False) -> tuple[Array, Array]:
            return self._of_law(constants, terms, stretches, place, needs_energy, across)

        if (form := anisotropy.form_of(terms)) is not None:
            return form.answer(of, self.path, stretches[0], warp, terms["anisotropy"][1])
        one = of(warp)
        return one if weft is None else anisotropy.between(self.path, one, of(weft, True))

    def _of_threads(
        self, warp: Array, terms: Terms, stretches: tuple[Array, Array], place: tuple[object, ...]
    ) -> tuple[Array, Array, Array]:
        """Return stress, energy and stretch across of a sheet whose ground is the law, with threads in it."""
        ground = dict(zip(self.law.names, map(float, warp), strict=True))
        sheet = anisotropy.form_of(terms)
        assert sheet is not None
        constants = sheet.constants(self.law, ground, terms["anisotropy"][1])
        if "compressibility" in terms:
            form, values = terms["compressibility"]
            nu = compressibility.FORMS[form].poisson(values)
            constants |= {} if nu is None else {"nu": nu}
        # Stress and stretch across ask for it, and so does every effect that it does not depend on.
        stress, energy, across = self._cut.of(
            (place, *constants.items()), lambda: self._threads.answer(constants, *stretches)
        )
        if "elastic-law" in terms:
            nothing = np.array(list(scaled(ground, 0.0).values()))
            more = self._of_law(nothing, terms, stretches, (*place, "added"), True)
            stress, energy = stress + more[0], energy + more[1]
        return stress, energy, across

    @cached_property
    def _threads(self) -> Threads:
        return Threads(self.path)

    def _of_law(
        self,
        constants: Array,
        terms: Terms,
        stretches: tuple[Array, Array],
        place: tuple[object, ...],
        needs_energy: bool,
        weft: bool = False,
    ) -> tuple[Array, Array]:
        if isinstance(self.law, HyperfoamLaw):
            return self._of_foam(constants, terms, stretches, needs_energy)[:2]
        given = dict(zip(self.law.names, map(float, constants), strict=True))
        if self.law.nonlinear and self.law.refusal(given) is not None:
            return np.full_like(stretches[0], np.nan), np.full_like(stretches[0], np.nan)
        c, theta = self.law.split(given)
        extra_form, extra = elastic_law.along(*terms.get("elastic-law", _NONE), weft)
        linear, shape = elastic_law.FORMS[extra_form].split(extra) if extra_form else ([], [])
        nu = terms.get("compressibility", _NONE)
        columns, energies = self._columns.of(theta, stretches, place, (extra_form, shape), nu, needs_energy)
        weights = np.array([*c, *linear])
        stress = columns @ weights
        return stress, energies @ weights if energies is not None else np.zeros_like(stress)

    def _of_foam(
        self, constants: Array, terms: Terms, stretches: tuple[Array, Array], needs_energy: bool = False
    ) -> tuple[Array, Array, Array]:
        """Return stress, energy (0 unless needed) and stretch across of a foam: its free sides ask for all constants
        together."""
        form, values = terms.get("elastic-law", _NONE)
        key = (needs_energy, tuple(constants), form, tuple(values), *(one.tobytes() for one in stretches))
        names = (*self.law.names, *(elastic_law.FORMS[form].names if form else ()))
        given = dict(zip(names, map(float, (*constants, *values)), strict=True))
        stress, energy, across = self._foams.of(
            key, lambda: tuple(self._answer_of_foam(given, stretches, needs_energy))
        )
        return stress, energy, across

    @cached_property
    def _of_each_mode(self) -> list[tuple[int, Flags]]:
        return [(int(mode), self.path.mode == mode) for mode in np.unique(self.path.mode)]

    def _answer_of_foam(
        self, constants: Mapping[str, float], stretches: tuple[Array, Array], needs_energy: bool
    ) -> Array:
        found = np.full((3, len(stretches[0])), np.nan)
        try:
            law = Hyperfoam.of(constants)
        except ValueError:
            return found
        for mode, at in self._of_each_mode:
            stretch, side = (one[at] for one in stretches)
            rows = Rows.of(MODE_NAMES[mode], stretch - 1.0 / stretch if mode == SIMPLE_SHEAR else stretch, side)
            with np.errstate(all="ignore"):
                e = rows.strain(law)
                energy = law.energy(e) if needs_energy else np.zeros(len(e))
                found[:, at] = rows.stress(law, e), energy, np.exp(e[:, 2])
        return found


def _present(terms: Terms) -> Terms:
    """Return the terms less those at a null that would leave rounding behind: the law is then itself to the bit."""
    return {
        name: (form, values)
        for name, (form, values) in terms.items()
        if name not in _IN_LAW or not _IN_LAW[name][form].absent(values)
    }


def _named(terms: Terms, names: Iterable[str]) -> tuple[object, ...]:
    """Return what tells those of the ``terms`` from others that have one of the ``names``."""
    return tuple((name, terms[name][0], told(terms[name][1])) for name in names if name in terms)


def _is_of_threads(terms: Terms) -> bool:
    form = anisotropy.form_of(terms)
    return form is not None and form.whole
