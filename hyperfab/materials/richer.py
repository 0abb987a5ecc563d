"""A strain-energy law with the terms of the ``elastic-law`` effect added to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hyperfab.materials.effects.elastic_law import FORMS
from hyperfab.materials.kinematics import Sheet
from hyperfab.materials.law import Law
from hyperfab.materials.material import Material
from hyperfab.materials.term import Term, Value


def richer(material: Material, form: str, constants: Mapping[str, float]) -> Material:
    """Return ``material`` with the terms of a ``form`` of the effect, of these ``constants`` by name.

    With linear constants of zero it answers bit for bit as before. Raises KeyError for a form or constant unknown.

    >>> from hyperfab.materials import bind
    >>> rubber = richer(bind("neo-hookean", {"C10_MPa": 0.2}), "high-powers", {"C40_MPa": 0.0, "C2_MPa": 0.1})
    >>> bool(rubber.uniaxial(1.5).P > bind("neo-hookean", {"C10_MPa": 0.2}).uniaxial(1.5).P)
    True
    """
    law = _Richer(material.law, form)
    added = FORMS[form]
    c, shape = added.split(added.of(constants))
    return Material(law, (*material.c, *c), (*material.theta, *shape))


class _Richer(Law):
    title = "a law with terms added"
    source = "hyperfab.materials.effects.elastic_law"

    def __init__(self, base: Law, form: str) -> None:
        self.base, self.added = base, FORMS[form]
        self.name, self.isotropic = base.name, base.isotropic
        self.equation = f"{base.equation}, and {form}"
        self.linear = (*base.linear, *self.added.linear)
        self.nonlinear = (*base.nonlinear, *self.added.nonlinear)

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[Term]:
        """Return the terms of the base law, then those added."""
        own = len(self.base.nonlinear)
        added = self.added.terms(sheet, *(float(value) for value in theta[own:]))
        return [*self.base.terms(sheet, theta[:own]), *added]

    def contraction(self, theta: Sequence[Value]) -> Value:
        """Contract as the base law does."""
        return self.base.contraction(theta[: len(self.base.nonlinear)])
