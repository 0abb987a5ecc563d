"""What all card formats share: settings, the laws they speak of, numbers in fields."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from hyperfab.materials.material import Material


class NoCard(Exception):
    """The solver has no law that is the same as the material's."""


@dataclass(frozen=True)
class Settings:
    """What a card needs beside the law's constants.

    ``bulk_modulus`` [MPa] is None where the material keeps its volume; ``density`` is in t/mm^3, the unit of mass that
    goes with N, mm and s. ``comments`` are lines for the reader of the card.
    """

    name: str = "fabric"
    number: int = 1
    bulk_modulus: float | None = None
    density: float = 1e-9
    comments: Sequence[str] = ()


#: Writes the card's lines for a law.
Writer = Callable[[Material, Settings], list[str]]


@dataclass(frozen=True)
class Format:
    """A solver's card format: its name, the ending of its files, how it marks comments, a writer for each law."""

    name: str
    suffix: str
    comment: Callable[[str], str]
    writers: Mapping[str, Writer]

    def card(self, material: Material, settings: Settings) -> str:
        """Return the card as text; NoCard where the solver has no such law."""
        writer = self.writers.get(material.law.name)
        if writer is None:
            known = ", ".join(self.writers)
            raise NoCard(f"{self.name} has no law like {material.law.name}; it has {known}")
        comments = [self.comment(line) for line in settings.comments]
        return "\n".join([*comments, *writer(material, settings)]) + "\n"


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


def series_as_powers(mu: float, lambda_m: float) -> list[float]:
    """Return c1 to c5 of ``sum c_k (I1 - 3)^k`` for the Arruda-Boyce series, which is the same polynomial.

    >>> [round(c, 12) for c in series_as_powers(2.0, 1e9)]
    [1.0, 0.0, 0.0, 0.0, 0.0]
    """
    from math import comb

    from hyperfab.materials.laws.arruda_boyce import COEFFICIENTS

    powers = [0.0] * 5
    for i, coefficient in enumerate(COEFFICIENTS, start=1):
        for k in range(1, i + 1):
            powers[k - 1] += mu * coefficient / lambda_m ** (2 * i - 2) * comb(i, k) * 3.0 ** (i - k)
    return powers


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
