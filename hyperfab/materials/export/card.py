"""What all card formats share: settings, the laws they speak of, numbers in fields."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.effects.elastic_law import Richer
from hyperfab.materials.hyperfoam import Hyperfoam
from hyperfab.materials.law import InvariantTerm, Sheet
from hyperfab.materials.material import Material
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.registry import bind


class NoCard(Exception):
    """The solver has no law that is the same as the material's."""


@dataclass(frozen=True)
class Settings:
    """What a card needs beside the law's constants.

    ``bulk_modulus`` [MPa] is None where the material keeps its volume; ``density`` is in t/mm^3, the unit of mass that
    goes with N, mm and s. ``comments`` are lines for the reader of the card.
    """

    name: str = "fabric"
    bulk_modulus: float | None = None
    density: float = 1e-9
    comments: Sequence[str] = ()


#: Writes the card's lines for a law.
Writer = Callable[[Material, Settings], list[str]]
#: Writes the card's lines for an orthotropic sheet with threads.
SheetWriter = Callable[[Orthotropic, Settings], list[str]]
#: Writes the card's lines for a foam.
FoamWriter = Callable[[Hyperfoam, Settings], list[str]]


@dataclass(frozen=True)
class Format:
    """A solver's card format: its name, how it marks comments, a writer for each law.

    ``foam`` writes a hyperfoam; ``sheet`` an orthotropic sheet, where the solver has a law of threads; ``curve`` any
    law of I1 alone, where it takes that by its uniaxial curve.
    """

    name: str
    comment: Callable[[str], str]
    writers: Mapping[str, Writer]
    foam: FoamWriter
    sheet: SheetWriter | None = None
    curve: Writer | None = None

    def card(self, law: Material | Orthotropic | Hyperfoam, settings: Settings) -> str:
        """Return the card as text; NoCard with the reasons where the solver cannot hold the law."""
        comments = (self.comment(line) for line in settings.comments)
        return "\n".join([*comments, *self._lines(law, settings)]) + "\n"

    def _lines(self, law: Material | Orthotropic | Hyperfoam, settings: Settings) -> list[str]:
        if isinstance(law, Hyperfoam):
            return self.foam(law.without_nothing(), settings)
        if isinstance(law, Orthotropic):
            refuse(self.name, law)
            if not families(law):
                return self._lines(ground(law), settings)
            if self.sheet is None:
                raise NoCard(
                    f"{self.name} has no law of threads that bear tension alone; its fabrics take the curves of warp, "
                    "weft and shear each by itself, not one energy of the sheet"
                )
            return self.sheet(law, settings)
        if isinstance(law.law, Richer):
            if self.curve is None:
                raise NoCard(f"{self.name} has no law like {law.law.equation}")
            return self.curve(law, settings)
        writer = self.writers.get(law.law.name)
        if writer is None:
            known = ", ".join(self.writers)
            raise NoCard(f"{self.name} has no law like {law.law.name}; it has {known}; fit one of these")
        return writer(law, settings)


def as_foam(write: FoamWriter) -> Writer:
    """Return the writer of Blatz and Ko's law: a hyperfoam, alpha 2 for the bracket of I1 and -2 for that of I2."""

    def of_brackets(material: Material, settings: Settings) -> list[str]:
        foam = Hyperfoam(tuple(material.c), (2.0, -2.0), 2 * tuple(material.theta))
        return write(foam.without_nothing(), settings)

    return of_brackets


@dataclass(frozen=True)
class Family:
    """Threads that bear tension alone, ``angle_deg`` from the warp: k1/(2 k2) (exp(k2 <I - 1>^2) - 1)."""

    angle_deg: float
    k1: float
    k2: float


def families(law: Orthotropic) -> list[Family]:
    """Return the threads there are: along warp and weft, and at both sides of the warp."""
    p = law.parameters
    every = [
        Family(0.0, p["k1_warp_MPa"], p["k2_warp"]),
        Family(90.0, p["k1_weft_MPa"], p["k2_weft"]),
        Family(p["bias_deg"], p["k1_bias_MPa"], p["k2_bias"]),
        Family(-p["bias_deg"], p["k1_bias_MPa"], p["k2_bias"]),
    ]
    return [one for one in every if one.k1 > 0.0]


def ground(law: Orthotropic) -> Material:
    """Return a sheet's ground as Yeoh's law: all of it where it keeps its volume and has no term of I2."""
    return bind("yeoh-3", {name: law.parameters[name] for name in ("C10_MPa", "C20_MPa", "C30_MPa")})


def refuse(name: str, law: Orthotropic, also: Mapping[str, str] | None = None) -> None:
    """Raise NoCard, with all reasons, where a sheet has parts that solver ``name`` cannot hold.

    ``also`` are further constants it has no place for, and why.
    """
    p = law.parameters
    missing = {
        "C2_MPa": "no ground with ln I2",
        "G_MPa": "no energy of the angle between warp and weft alone",
        **(also or {}),
    }
    why = [f"{constant} {p[constant]:g}: {text}" for constant, text in missing.items() if p[constant] > 0.0]
    if p["nu"] < 0.5:
        why.append(f"nu {p['nu']:g}: its ground keeps its volume (0.5)")
    if why:
        raise NoCard(f"{name} cannot hold this orthotropic sheet: {'; '.join(why)}")


def is_of_I1(material: Material) -> bool:
    """Whether the energy is a function of I1 alone, which the curve of a strip then tells for every state.

    >>> is_of_I1(bind("gent", {"mu_MPa": 0.3, "Im": 20.0}))
    True
    >>> is_of_I1(bind("mooney-rivlin-2", {"C10_MPa": 0.2, "C01_MPa": 0.01}))
    False
    """
    terms = material.law.terms(Sheet.of(1.1, 1.0), material.theta)
    return all(
        c == 0.0 or (isinstance(term, InvariantTerm) and not np.any(term.W2))
        for c, term in zip(material.c, terms, strict=True)
    )


def cij(material: Material, *names: str) -> list[float]:
    """Return the constants Cij of a polynomial law by number, zero where the law has none."""
    return [material.parameters.get(f"C{name}_MPa", 0.0) for name in names]


def pairs(material: Material) -> list[tuple[float, float]]:
    """Return the (mu, alpha) of an Ogden law."""
    return list(zip(material.c, material.theta, strict=True))


def shear_modulus(material: Material) -> float:
    """Return the initial shear modulus [MPa]: Young's modulus over 2 (1 + nu)."""
    nu = float(material.law.contraction(material.theta))
    return float(material.uniaxial(1.0).A) / (2.0 * (1.0 + nu))


def poisson(material: Material, bulk_modulus: float) -> float:
    """Return Poisson's ratio at rest that goes with a bulk modulus [MPa]; below 1/2 however large that is."""
    mu, K = shear_modulus(material), bulk_modulus
    return min((3.0 * K - 2.0 * mu) / (6.0 * K + 2.0 * mu), math.nextafter(0.5, 0.0))


def series_as_powers(mu: float, lambda_m: float) -> list[float]:
    """Return c1 to c5 of ``sum c_k (I1 - 3)^k`` for the Arruda-Boyce series, which is the same polynomial.

    >>> [round(c, 12) for c in series_as_powers(2.0, 1e9)]
    [1.0, 0.0, 0.0, 0.0, 0.0]
    """
    from hyperfab.materials.laws.arruda_boyce import COEFFICIENTS

    powers = [0.0] * 5
    for i, coefficient in enumerate(COEFFICIENTS, start=1):
        for k in range(1, i + 1):
            powers[k - 1] += mu * coefficient / lambda_m ** (2 * i - 2) * math.comb(i, k) * 3.0 ** (i - k)
    return powers


def volumetric(settings: Settings, count: int = 1) -> list[float]:
    """Return 2 / bulk modulus [1/MPa] for the first of ``count`` terms, 0 for an incompressible law and the others."""
    return [0.0 if settings.bulk_modulus is None else 2.0 / settings.bulk_modulus, *[0.0] * (count - 1)]


def number(value: float) -> str:
    """Return a number with all its digits."""
    return repr(float(value))


def field(value: float | str, width: int) -> str:
    """Return a number right-aligned in a fixed field, with as many digits as fit.

    >>> field(0.123456789012, 10), field(-1.234567e-12, 10), len(field(-1.0e-300, 10))
    ('0.12345679', '-1.235e-12', 10)
    """
    if isinstance(value, str):
        return value.rjust(width)
    for digits in range(17, 0, -1):
        text = f"{value:.{digits}g}"
        if len(text) <= width:
            return text.rjust(width)
    raise ValueError(f"{value} does not fit a field of {width}")
