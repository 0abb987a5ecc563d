"""The terms of a law in the rows of tests: their stress and energy, whatever their linear constants are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hyperfab.materials.effects import compressibility, elastic_law
from hyperfab.materials.effects.kept import Kept, told
from hyperfab.materials.effects.path import Path, second_stretch
from hyperfab.materials.law import Array, InvariantTerm, Law, Sheet, Term

#: Stress and energy of each term (n, terms); None where the energy is not asked for.
Terms = tuple[Array, Array | None]


@dataclass(frozen=True)
class Columns:
    """The terms of a ``law``, and of what is added to it, in the rows of ``path``.

    What a constant has no say in is kept: the sheet, the terms of the law, the terms added.
    """

    law: Law
    path: Path
    _every: Kept = field(default_factory=Kept, repr=False)
    _parts: Kept = field(default_factory=Kept, repr=False)
    _sheets: Kept = field(default_factory=Kept, repr=False)

    def of(
        self,
        theta: Sequence[float],
        stretches: tuple[Array, Array],
        place: tuple[object, ...],
        added: tuple[str, Sequence[float]],
        narrows: tuple[str, Array],
        needs_energy: bool,
    ) -> Terms:
        """Return stress and energy of all terms at the stretches along and across, which ``place`` tells.

        ``theta`` are the constants that the law is not linear in, ``added`` the form of the terms added and such
        constants of theirs, ``narrows`` the form of the contraction and its constants.
        """
        (form, shape), (width, values) = added, narrows
        state = (place, needs_energy, width, told(values), self.law.contraction(theta))

        def stretched() -> tuple[Sheet, Array | float]:
            l1, side = stretches
            l2 = second_stretch(self.path.mode, l1, l1 ** -self.law.contraction(theta), side)
            factor: Array | float = 1.0
            if width:
                l1, l2, factor = compressibility.FORMS[width].state(self.path, l1, l2, values)
            return Sheet.of(l1, l2), factor

        def of_law() -> Terms:
            sheet, factor = self._sheets.of(state, stretched)
            return _told_of(self.law.terms(sheet, theta), sheet, factor, needs_energy)

        def of_added() -> Terms:
            sheet, factor = self._sheets.of(state, stretched)
            return _told_of(elastic_law.FORMS[form].terms(sheet, *shape), sheet, factor, needs_energy)

        def both() -> Terms:
            parts = [self._parts.of((state, *theta), of_law), self._parts.of((state, form, *shape), of_added)]
            stress, energy = zip(*parts, strict=True)
            return np.concatenate(stress, axis=1), np.concatenate(energy, axis=1) if needs_energy else None

        found: Terms
        if not form:
            found = self._parts.of((state, *theta), of_law)
        else:
            found = self._every.of((state, *theta, form, *shape), both)
        return found


def _told_of(parts: Sequence[Term], sheet: Sheet, factor: Array | float, needs_energy: bool) -> Terms:
    nothing = 0.0 * sheet.l1
    columns = np.stack([part.stress(sheet) * factor + nothing for part in parts], axis=1)
    if not needs_energy:
        return columns, None
    return columns, np.stack([_energy(part, sheet) + nothing for part in parts], axis=1)


def _energy(term: Term, sheet: Sheet) -> Array:
    if isinstance(term, InvariantTerm):
        return np.asarray(term.W() if callable(term.W) else term.W)
    return term.membrane(sheet).W
