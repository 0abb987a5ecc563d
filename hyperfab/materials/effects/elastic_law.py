"""Terms that make a strain-energy law richer: what is added is itself an energy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from hyperfab.arrays import Array
from hyperfab.materials.effects.smooth import CLOSER, cardinal, straight
from hyperfab.materials.law import InvariantTerm, Law, PowerTerm, Sheet, Term, Value, log_I2, of_I1, of_I2
from hyperfab.materials.material import Material

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

#: What the name of a form ends with whose constants along warp and weft differ.
EACH_WAY = "-each-way"
#: Strains, over the largest, at which a smooth law has its values, closer together near rest; and where tests along
#: both axes tell it.
STRAINS = tuple(float(s) for s in (3.0 ** (np.arange(1, 10) / 9.0) - 1.0) / 2.0)
_CLOSE_TO_REST = tuple(float(s) for s in ((1.0 + CLOSER) ** (np.arange(1, 7) / 6.0) - 1.0) / CLOSER)


@dataclass(frozen=True)
class Added:
    """What a form adds to a law.

    names   its constants; the terms are linear in those that end in _MPa
    terms   the terms of these, in their order: of the sheet and the other constants (alpha, b)
    richer  laws that are another one with this added: the name of either
    lately  linear constants that older documents lack: none of them then
    """

    names: tuple[str, ...]
    terms: Callable[..., list[Term]]
    richer: Mapping[str, str] = field(default_factory=dict)
    lately: tuple[str, ...] = ()

    @cached_property
    def linear(self) -> tuple[str, ...]:
        """The constants that the terms are linear in."""
        return tuple(name for name in self.names if name.endswith("_MPa"))

    @cached_property
    def nonlinear(self) -> tuple[str, ...]:
        """The others."""
        return tuple(name for name in self.names if not name.endswith("_MPa"))

    def of(self, constants: Mapping[str, float]) -> list[float]:
        """Return the values of its constants by name; KeyError names one that is missing.

        >>> FORMS["ogden"].of({"alpha": 2.0, "mu_MPa": 0.1})
        [0.1, 2.0]
        """
        known = dict.fromkeys(self.lately, 0.0) | dict(constants)
        return [known[name] for name in self.names]

    def split(self, values: Sequence[float]) -> tuple[list[float], list[float]]:
        """Return the constants that the terms are linear in, in MPa, and the others.

        >>> FORMS["exponential"].split([0.3, 2.0])
        ([0.3], [2.0])
        """
        assert len(values) == len(self.names)
        linear, others = self._places
        return [float(values[place]) for place in linear], [float(values[place]) for place in others]

    @cached_property
    def _places(self) -> tuple[list[int], list[int]]:
        places = {name: place for place, name in enumerate(self.names)}
        return [places[name] for name in self.linear], [places[name] for name in self.nonlinear]

    def absent(self, values: Sequence[float]) -> bool:
        """Whether nothing is added."""
        return not any(self.split(values)[0])

    def and_log(self) -> Added:
        """Return the form with a term in ln(I2/3) beside its own."""
        return Added(
            (*self.names, "C2_MPa"),
            lambda sheet, *shape: [*self.terms(sheet, *shape), log_I2(sheet)],
            lately=self.lately,
        )

    def each_way(self, *shape: str) -> Added:
        """Return the form with other constants along the weft, all but its shape, or that too: see ``along``."""
        others = (of_weft(name) for name in self.names if name in (*self.linear, *shape))
        return Added((*self.names, *others), self.terms)


def of_weft(name: str) -> str:
    """Return what a constant along the weft is called.

    >>> of_weft("C01_MPa")
    'C01_weft_MPa'
    """
    stem = name.removesuffix("_MPa")
    return f"{stem}_weft{name.removeprefix(stem)}"


def _power(sheet: Sheet, n: float) -> Term:
    x = sheet.x
    return of_I1(x**n, n * x ** (n - 1.0), n * (n - 1.0) * x ** (n - 2.0))


def _second_invariant(sheet: Sheet) -> list[Term]:
    x, y = sheet.x, sheet.y
    mixed = InvariantTerm(W=x * y, W1=y, W2=x, W12=1.0 + 0.0 * x)
    return [of_I2(y, 1.0 + 0.0 * y, 0.0 * y), mixed, of_I2(y**2, 2.0 * y, 2.0 + 0.0 * y)]


def _straightening(sheet: Sheet, at: float, width: float) -> list[Term]:
    """Return a stiffness that rises where yarns have straightened, at I1 - 3 = ``at``, over ``width``."""
    from scipy.special import expit

    x = sheet.x
    step = expit((x - at) / width)
    grown = width * (np.logaddexp(0.0, (x - at) / width) - np.logaddexp(0.0, -at / width))
    return [of_I1(grown, step, step * (1.0 - step) / width)]


def _exponential(sheet: Sheet, b: float) -> list[Term]:
    """Return Fung's ``(exp(b (I1 - 3)) - 1)/b``: Fung (1967), Am. J. Physiol. 213, 1532."""
    power = np.minimum(b * sheet.x, 50.0)
    grown = np.exp(power)
    return [of_I1(np.expm1(power) / b, grown, b * grown)]


def _smooth(sheet: Sheet, reach: float) -> list[Term]:
    """Return energies of I1 whose slopes are smooth functions, each 1 at one fifth of ``reach``, and the rest."""
    x = sheet.x / reach
    slope, bend = (np.moveaxis(straight(_stored(), x, order), -1, 0) for order in (1, 2))

    @cache
    def energy() -> Array:
        return reach * straight(_stored(), x)

    terms: list[Term] = [of_I1(lambda k=k: energy()[..., k], slope[k], bend[k] / reach) for k in range(len(slope))]
    return [*terms, *_of_other_modes(sheet)]


@lru_cache(maxsize=1)
def _stored() -> PPoly:
    """Return the integrals of the slopes of ``_smooth``."""
    return cardinal(5).antiderivative()


def _smooth_mixed(sheet: Sheet, reach: float) -> list[Term]:
    """Return the terms of ``_smooth`` and what I2 does beside I1: (I1 - 3)(I2 - 3) and (I2 - 3)^2."""
    return [*_smooth(sheet, reach), *_second_invariant(sheet)[1:]]


def _smooth_in_strain(strains: tuple[float, ...], ends: str, sheet: Sheet, reach: float) -> list[Term]:
    """Return energies of I1 whose slopes are smooth functions of its root, the strain, each 1 at one of ``strains``.

    ``ends`` says how a spline begins and ends, as SciPy has it.
    """
    stored, slopes = _in_strain(strains, ends)
    s = np.sqrt(np.maximum(sheet.x, 0.0) / reach)
    energy, slope, rate = (np.moveaxis(values, -1, 0) for values in (stored(s), slopes(s), slopes(s, 1)))
    # At rest I1 does not change with the strain: what its second derivative is there does not matter.
    per = 2.0 * reach * np.maximum(s, 1e-9)
    return [of_I1(reach * w, w1, w11 / per) for w, w1, w11 in zip(energy, slope, rate, strict=True)]


def _smooth_close(sheet: Sheet, reach: float) -> list[Term]:
    return [*_smooth_in_strain(_CLOSE_TO_REST, "natural", sheet, reach), *_of_other_modes(sheet)]


@lru_cache(maxsize=2)
def _in_strain(strains: tuple[float, ...], ends: str) -> tuple[PPoly, PPoly]:
    """Return the energies over ``reach`` and slopes (k) by s, the root of x over ``reach``; slopes go on straight."""
    from scipy.interpolate import CubicSpline, PPoly

    count = len(strains)
    spline = CubicSpline((0.0, *strains), np.eye(count + 1)[:, 1:], bc_type=ends)
    end = np.stack([np.zeros(count), np.zeros(count), spline(1.0, 1), spline(1.0)])[:, None]
    slopes = PPoly(np.concatenate([spline.c, end], axis=1), [*spline.x, 2.0])
    # dx = reach d(s^2): the slope times 2 s, s being its beginning and what is beyond that in each piece.
    begin = np.asarray(slopes.x[:-1])[:, None]
    c = np.concatenate([slopes.c, np.zeros((1, *slopes.c.shape[1:]))])
    c[1:] += begin * slopes.c
    return PPoly(2.0 * c, slopes.x).antiderivative(), slopes


def _of_other_modes(sheet: Sheet) -> list[Term]:
    """Return I2 - 3 and Ogden's term of exponent 1, which no function of I1 and I2 makes: a biaxial test tells it."""
    return [of_I2(sheet.y, 1.0 + 0.0 * sheet.y, 0.0 * sheet.y), PowerTerm(1.0)]


def _of_a_sheet(sheet: Sheet, *shape: float) -> list[Term]:
    raise TypeError("the terms of a foam are no terms of a sheet")


def _foam_terms(first: int, last: int) -> Added:
    """Return more terms of a hyperfoam, from the ``first`` to the ``last`` it then has."""
    names = (name for k in range(first, last + 1) for name in (f"mu{k}_MPa", f"alpha{k}", f"nu{k}"))
    return Added(tuple(names), _of_a_sheet, {f"hyperfoam-{first - 1}": f"hyperfoam-{last}"})


_POWERS = Added(
    ("C20_MPa", "C30_MPa"),
    lambda sheet: [_power(sheet, 2.0), _power(sheet, 3.0)],
    richer=dict.fromkeys(("neo-hookean", "yeoh-1", "yeoh-2"), "yeoh-3"),
)
_OGDEN = Added(("mu_MPa", "alpha"), lambda sheet, alpha: [PowerTerm(alpha)])
_TOE = Added(("D_MPa", "at", "width"), _straightening)
_FUNG = Added(("D_MPa", "b"), _exponential)
_SECOND = Added(("C01_MPa", "C11_MPa", "C02_MPa"), _second_invariant)
_CLOSE = Added(("reach", *(f"D_{k}_MPa" for k in range(1, 7)), "C01_MPa", "mu_MPa"), _smooth_close).and_log()
_STRAIN = Added(
    ("reach", *(f"D_{k}_MPa" for k in range(1, len(STRAINS) + 1))),
    # Where a test ends a law bends on as it does within.
    partial(_smooth_in_strain, STRAINS, "not-a-knot"),
)
_SMOOTH = Added(
    ("reach", *(f"D_{k}_MPa" for k in range(1, 6)), "C01_MPa", "mu_MPa"), _smooth, lately=("mu_MPa",)
).and_log()
#: The forms of what is added.
FORMS: Mapping[str, Added] = {
    "powers": _POWERS,
    "powers-log": _POWERS.and_log(),
    "powers-mixed": Added(
        ("C20_MPa", "C30_MPa", "C01_MPa", "C11_MPa"),
        lambda sheet: [*_POWERS.terms(sheet), *_second_invariant(sheet)[:2]],
    ),
    "ogden": _OGDEN,
    "exponential": _FUNG,
    "high-powers": Added(("C40_MPa",), lambda sheet: [_power(sheet, 4.0)]).and_log(),
    "second-invariant": _SECOND,
    "second-invariant-log": _SECOND.and_log(),
    "straightening": _TOE,
    "smooth": _SMOOTH,
    f"smooth{EACH_WAY}": _SMOOTH.each_way(),
    "smooth-mixed": Added(
        ("reach", *(f"D_{k}_MPa" for k in range(1, 6)), "C01_MPa", "mu_MPa", "C11_MPa", "C02_MPa"), _smooth_mixed
    ).and_log(),
    "smooth-strain": _STRAIN,
    f"smooth-strain{EACH_WAY}": _STRAIN.each_way("reach"),
    "smooth-close": _CLOSE,
    f"smooth-close{EACH_WAY}": _CLOSE.each_way(),
    "straightening-log": _TOE.and_log(),
    "ogden-log": _OGDEN.and_log(),
    "exponential-log": _FUNG.and_log(),
    "term-2": _foam_terms(2, 2),
    "term-3": _foam_terms(3, 3),
    "terms-2-3": _foam_terms(2, 3),
}


def along(form: str, values: Iterable[float], weft: bool) -> tuple[str, list[float]]:
    """Return the form of one direction and its constants, of one that has others along the ``weft``.

    >>> form, values = along("smooth-close-each-way", [0.5, *range(9), *range(10, 19)], weft=True)
    >>> form, values
    ('smooth-close', [0.5, 10, 11, 12, 13, 14, 15, 16, 17, 18])
    >>> along("ogden", [0.1, 2.0], weft=True)
    ('ogden', [0.1, 2.0])
    """
    one, places = _along(form, weft)
    given = list(values)
    return one, given if places is None else [given[place] for place in places]


@cache
def _along(form: str, weft: bool) -> tuple[str, tuple[int, ...] | None]:
    """Return the form of one direction and which constants it has of one that has others along the weft; None: all."""
    one = form.removesuffix(EACH_WAY)
    if one == form:
        return form, None
    places = {name: place for place, name in enumerate(FORMS[form].names)}
    names = FORMS[one].names
    return one, tuple(places.get(of_weft(name), places[name]) if weft else places[name] for name in names)


def richer(material: Material, form: str, constants: Mapping[str, float], *, weft: bool = False) -> Material:
    """Return ``material``, along the warp or the ``weft``, with the terms of a ``form`` of the effect, of these
    ``constants`` by name.

    With linear constants of zero it answers bit for bit as before. Raises KeyError for a form or constant unknown.

    >>> from hyperfab.materials import bind
    >>> rubber = richer(bind("neo-hookean", {"C10_MPa": 0.2}), "high-powers", {"C40_MPa": 0.0, "C2_MPa": 0.1})
    >>> bool(rubber.uniaxial(1.5).P > bind("neo-hookean", {"C10_MPa": 0.2}).uniaxial(1.5).P)
    True
    """
    one, values = along(form, FORMS[form].of(constants), weft)
    law = Richer(material.law, one)
    c, shape = FORMS[one].split(values)
    return Material(law, (*material.c, *c), (*material.theta, *shape))


class Richer(Law):
    """A law with the terms of a form of the effect on top."""

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
