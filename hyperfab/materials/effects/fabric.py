"""What tests of a fabric read: a strain-energy law, and the effects on top of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

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
from hyperfab.materials.effects.path import BIAXIAL, SHEAR, UNIAXIAL, Path
from hyperfab.materials.effects.state import State
from hyperfab.materials.effects.threads import Threads
from hyperfab.materials.kinematics import Array, Sheet
from hyperfab.materials.law import Law
from hyperfab.materials.term import InvariantTerm, Term

#: A term: its form and its constants, in the order of the form.
Terms = Mapping[str, tuple[str, Array]]
_KEPT = 12
#: The effects on the stress, in the order in which they act: the fabric's own, then time's, then the machine's.
_ON_STRESS = {
    "thermal-softening": thermal_softening.FORMS,
    "mullins": mullins.FORMS,
    "hysteresis": hysteresis.FORMS,
    "rate": rate.FORMS,
    "load-offset": load_offset.FORMS,
}


@dataclass
class Fabric:
    """Predicts the stress of every row of ``path`` for a law, its constants and effects.

    ``reference_degC`` is the temperature the constants are of; ``speed`` the strain rate of a row [1/s],
    nan where unknown.
    """

    law: Law
    path: Path
    reference_degC: float = 20.0
    speed: Array | None = None
    _bases: dict[tuple[object, ...], tuple[Array, Array | None]] = field(default_factory=dict)

    def stress(self, warp: Array, weft: Array | None, terms: Terms) -> Array:
        """Return the nominal stress [MPa] of every row.

        ``warp`` and ``weft`` are the law's constants in its order; without ``weft`` both directions are
        alike. An effect that is not among ``terms`` leaves no trace: the result is bit for bit that of the law.
        """
        path = self.path
        terms = {name: term for name, term in terms.items() if not _absent(name, *term)}
        stretch, place = self._stretch(terms)
        with np.errstate(all="ignore"):
            stress, energy = self._elastic(warp, weft, terms, stretch, place)
            if terms.get("permanent-set", ("",))[0] in permanent_set.NETWORKS:
                peak = self._peak(stretch)
                second, _ = self._elastic(warp, weft, terms, stretch / peak, (*place, "second"))
                stress = permanent_set.second_network(stress, second, peak, *terms["permanent-set"][1])
            state = State(path, stretch, energy, self.reference_degC, self.speed)
            for name, forms in _ON_STRESS.items():
                if name in terms:
                    form, values = terms[name]
                    stress = forms[form](state, stress, values)
        return np.asarray(stress)

    def across(self, terms: Terms, warp: Array | None = None) -> Array:
        """Return the transverse stretch of uniaxial rows; the other rows are without meaning.

        ``warp`` are the law's constants: a sheet of threads asks for them.
        """
        stretch, _ = self._stretch(terms)
        if _is_of_threads(terms):
            assert warp is not None
            return self._of_threads(warp, terms, stretch)[2]
        if "compressibility" not in terms or _absent("compressibility", *terms["compressibility"]):
            return np.asarray(stretch**-0.5)
        form, values = terms["compressibility"]
        if form == "split":
            ratio = compressibility.volume(self.path.mode, stretch, self.path.across, values[0])
            return np.asarray(np.sqrt(ratio / stretch))
        nu, bend = self._contraction(terms["compressibility"])
        return compressibility.across(stretch, nu, bend)

    def _contraction(self, term: tuple[str, Array]) -> tuple[Array, float]:
        form, values = term
        nu = np.full_like(self.path.stretch, values[0])
        if form.startswith("directions"):
            share = anisotropy.weft_share(self.path)
            nu = nu + share * (values[1] - values[0])
        return nu, float(values[-1]) if form.endswith("bent") else 0.0

    def _stretch(self, terms: Terms) -> tuple[Array, tuple[object, ...]]:
        stretch = self.path.stretch
        place: tuple[object, ...] = ()
        if "grip-slack" in terms:
            form, values = terms["grip-slack"]
            stretch = grip_slack.FORMS[form](self.path, stretch, values)
            place = (*place, *values)
        form, values = terms.get("permanent-set", ("", np.empty(0)))
        if form in permanent_set.FORMS:
            stretch = permanent_set.FORMS[form](self.path, stretch, self._peak(stretch), values)
            place = (*place, form, *values)
        return stretch, place

    def _peak(self, stretch: Array) -> Array:
        if stretch is self.path.stretch:
            return self.path.peak
        found = np.empty_like(stretch)
        for rows in self.path.curves:
            found[rows] = np.maximum(np.maximum.accumulate(stretch[rows]), 1.0)
        return found

    def _elastic(
        self,
        warp: Array,
        weft: Array | None,
        terms: Terms,
        stretch: Array,
        place: tuple[object, ...],
    ) -> tuple[Array, Array]:
        needs_energy = "mullins" in terms or terms.get("hysteresis", ("",))[0] == "pseudo-elastic"
        if _is_of_threads(terms):
            return self._of_threads(warp, terms, stretch)[:2]
        one = self._of_law(warp, terms, stretch, place, needs_energy)
        form, values = terms.get("anisotropy", ("", np.empty(0)))
        if form.endswith("fibres"):
            # Beside constants of the weft's own, or alone.
            stress, energy = anisotropy.fibres(self.path, stretch, *_of_fibres(form, values))
            if form == "constants-fibres":
                plain = {**terms, "anisotropy": ("constants", values[:-3])}
                one = self._elastic(warp, weft, plain, stretch, place)
            return one[0] + stress, one[1] + energy
        if weft is None and not form:
            return one
        share = anisotropy.weft_share(self.path)
        if form == "ratio":
            factor = 1.0 + share * (values[0] - 1.0)
            return one[0] * factor, one[1] * factor
        if form:
            weft = np.asarray(warp) + np.asarray(values)
        assert weft is not None
        other = self._of_law(weft, terms, stretch, place, needs_energy)
        # The share 1 must give the weft itself, not a sum that rounds.
        stress = np.where(share == 1.0, other[0], one[0] + share * (other[0] - one[0]))
        return stress, one[1] + share * (other[1] - one[1])

    def _of_threads(self, warp: Array, terms: Terms, stretch: Array) -> tuple[Array, Array, Array]:
        """Return stress, energy and stretch across of a sheet whose ground is the law, with threads in it."""
        k1_warp, k1_weft, k2, shear = map(float, terms["anisotropy"][1])
        constants = dict(zip(self.law.names, map(float, warp), strict=True))
        constants |= {
            "k1_warp_MPa": k1_warp,
            "k1_weft_MPa": k1_weft,
            "k2_warp": k2,
            "k2_weft": k2,
            "G_MPa": shear,
        }
        form, values = terms.get("compressibility", ("", np.empty(0)))
        if form == "uniform":
            constants["nu"] = float(values[0])
        stress, energy, across = self._threads.answer(constants, stretch)
        if "elastic-law" in terms:
            more = self._of_law(np.zeros(len(warp)), terms, stretch, ("added",), True)
            stress, energy = stress + more[0], energy + more[1]
        return stress, energy, across

    @cached_property
    def _threads(self) -> Threads:
        return Threads(self.path)

    def _of_law(
        self,
        constants: Array,
        terms: Terms,
        stretch: Array,
        place: tuple[object, ...],
        needs_energy: bool,
    ) -> tuple[Array, Array]:
        given = dict(zip(self.law.names, map(float, constants), strict=True))
        if self.law.nonlinear and self.law.refusal(given) is not None:
            nowhere = np.full_like(stretch, np.nan)
            return nowhere, nowhere
        c, theta = self.law.split(given)
        extra_form, extra = terms.get("elastic-law", ("", np.empty(0)))
        linear, shape = elastic_law.split(extra_form, list(extra)) if extra_form else ([], [])
        nu = terms.get("compressibility", ("", np.empty(0)))
        key = (tuple(theta), place, extra_form, tuple(shape), nu[0], tuple(nu[1]), needs_energy)
        if key not in self._bases:
            if len(self._bases) >= _KEPT:
                self._bases.pop(next(iter(self._bases)))
            self._bases[key] = self._basis(theta, stretch, extra_form, shape, terms, needs_energy)
        columns, energies = self._bases[key]
        weights = np.array([*c, *linear])
        stress = columns @ weights
        return stress, energies @ weights if energies is not None else np.zeros_like(stress)

    def _basis(
        self,
        theta: Sequence[float],
        stretch: Array,
        extra_form: str,
        shape: Sequence[float],
        terms: Terms,
        needs_energy: bool,
    ) -> tuple[Array, Array | None]:
        form, values = terms.get("compressibility", ("", np.empty(0)))
        if form == "split":
            return self._split(theta, stretch, extra_form, shape, values[0], needs_energy)
        second = self._second(theta, stretch, terms)
        plain: Array | float = 1.0
        if form.startswith("slope"):
            thinner, second = second, self._second(theta, stretch, {})
            plain = compressibility.pull(stretch, thinner, second)
        return self._columns(theta, Sheet.of(stretch, second), extra_form, shape, plain, needs_energy)

    def _split(
        self,
        theta: Sequence[float],
        stretch: Array,
        extra_form: str,
        shape: Sequence[float],
        nu: float,
        needs_energy: bool,
    ) -> tuple[Array, Array | None]:
        path = self.path
        ratio = compressibility.volume(path.mode, stretch, path.across, nu)
        sheet = Sheet.of(*compressibility.of_shape(path.mode, stretch, path.across, ratio))
        return self._columns(theta, sheet, extra_form, shape, 1.0 / np.cbrt(ratio), needs_energy)

    def _columns(
        self,
        theta: Sequence[float],
        sheet: Sheet,
        extra_form: str,
        shape: Sequence[float],
        factor: Array | float,
        needs_energy: bool,
    ) -> tuple[Array, Array | None]:
        """Return the stress (times ``factor``) and the energy of each term of the law in a state of the sheet."""
        parts: list[Term] = list(self.law.terms(sheet, theta))
        if extra_form:
            parts += elastic_law.added_terms(extra_form, sheet, shape)
        nothing = 0.0 * sheet.l1
        columns = np.stack([part.stress(sheet) * factor + nothing for part in parts], axis=1)
        if not needs_energy:
            return columns, None
        return columns, np.stack([_energy(part, sheet) + nothing for part in parts], axis=1)

    def _second(self, theta: Sequence[float], stretch: Array, terms: Terms) -> Array:
        path = self.path
        nu = self.law.contraction(theta)
        second = np.where(path.mode == BIAXIAL, stretch, np.where(path.mode == SHEAR, 1.0, path.across))
        second = np.where(path.mode == UNIAXIAL, stretch**-nu, second)
        if "compressibility" in terms:
            contraction, bend = self._contraction(terms["compressibility"])
            second = compressibility.as_incompressible(path.mode, stretch, second, contraction, bend)
        return np.asarray(second)


def _is_of_threads(terms: Terms) -> bool:
    return (
        "anisotropy" in terms
        and terms["anisotropy"][0] == "threads"
        and not _absent("anisotropy", *terms["anisotropy"])
    )


def _of_fibres(form: str, values: Array) -> tuple[float, float, float]:
    """Return the stiffness of fibres along warp and weft, and their growth."""
    if form == "constants-fibres":
        return float(values[-3]), float(values[-2]), float(values[-1])
    one, growth = float(values[0]), float(values[1])
    return (one, 0.0, growth) if form == "warp-fibres" else (0.0, one, growth)


def _absent(name: str, form: str, values: Array) -> bool:
    """Whether a term stands at a null that would leave rounding behind; the law is then to be itself to the bit."""
    if name == "anisotropy":
        return form == "threads" and not np.any(values[[0, 1, 3]])
    if name == "elastic-law":
        return not np.any(elastic_law.split(form, list(values))[0])
    if name == "compressibility":
        bent = form.endswith("bent")
        return bool(np.all(values[: len(values) - bent] == 0.5) and not (bent and values[-1]))
    return name == "hysteresis" and form == "bent" and values[0] == 0.0


def _energy(term: Term, sheet: Sheet) -> Array:
    if isinstance(term, InvariantTerm):
        return np.asarray(term.W() if callable(term.W) else term.W)
    return term.membrane(sheet).W
