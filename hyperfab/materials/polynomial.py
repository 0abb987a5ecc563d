"""Polynomials in the invariants: neo-Hookean, Mooney-Rivlin and Yeoh."""

from __future__ import annotations

from collections.abc import Sequence

from hyperfab.materials.law import InvariantTerm, Law, Sheet, Value


class Polynomial(Law):
    """``W = sum C_ij (I1 - 3)^i (I2 - 3)^j``; the initial shear modulus is 2 (C10 + C01).

    Rivlin & Saunders (1951), Phil. Trans. R. Soc. A 243, 251, doi:10.1098/rsta.1951.0004.
    """

    source = "doi:10.1098/rsta.1951.0004"
    equation = "W = sum Cij (I1 - 3)^i (I2 - 3)^j"

    def __init__(self, name: str, title: str, *powers: tuple[int, int]) -> None:
        self.name = name
        self.title = title
        self.powers = powers
        self.linear = tuple(f"C{i}{j}_MPa" for i, j in powers)

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[InvariantTerm]:
        """Return one monomial a constant."""
        return [_monomial(sheet, i, j) for i, j in self.powers]


def _monomial(sheet: Sheet, i: int, j: int) -> InvariantTerm:
    x, y = sheet.x, sheet.y
    fx, fx1, fx11 = _power(x, i), _power(x, i - 1), _power(x, i - 2)
    fy, fy1, fy11 = _power(y, j), _power(y, j - 1), _power(y, j - 2)
    return InvariantTerm(
        W=fx * fy,
        W1=i * fx1 * fy,
        W2=j * fx * fy1,
        W11=i * (i - 1) * fx11 * fy,
        W12=i * j * fx1 * fy1,
        W22=j * (j - 1) * fx * fy11,
    )


def _power(value: Value, exponent: int) -> Value:
    if exponent <= 0:
        return 1.0  # also below zero: the factor in front of it is zero
    return value**exponent if exponent > 1 else value
