"""One term of a strain energy and what it contributes to stress and tangent of the sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from hyperfab.materials.kinematics import Array, Sheet

#: A number or an array that broadcasts against the stretches.
Value = Any


@dataclass(frozen=True)
class Membrane:
    """Energy per undeformed volume [MPa] and its derivatives along the in-plane stretches, plane stress.

    ``P1``, ``P2`` are nominal stresses [MPa]; ``A11``, ``A12``, ``A22`` their tangent [MPa].
    """

    W: Array
    P1: Array
    P2: Array
    A11: Array
    A12: Array
    A22: Array


class Term(Protocol):
    """The factor of one linear constant in the energy W."""

    def stress(self, sheet: Sheet) -> tuple[Array, Array]:
        """Return dW/dl1 and dW/dl2."""
        ...

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives."""
        ...


@dataclass(frozen=True)
class InvariantTerm:
    """A term that is a function of I1 and I2: its value, and its derivatives by I1 (1) and I2 (2)."""

    #: May be a function without arguments, where the value is costly and stresses do without it.
    W: Value
    W1: Value = 0.0
    W2: Value = 0.0
    W11: Value = 0.0
    W12: Value = 0.0
    W22: Value = 0.0

    def stress(self, sheet: Sheet) -> tuple[Array, Array]:
        """Return dW/dl1 and dW/dl2 by the chain rule."""
        # y_1 = l2^2 x_1: what a mode leaves unstressed stays exactly zero.
        return (self.W1 + self.W2 * sheet.l2**2) * sheet.x_1, (self.W1 + self.W2 * sheet.l1**2) * sheet.x_2

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives by the chain rule."""
        x1, x2, y1, y2 = sheet.x_1, sheet.x_2, sheet.y_1, sheet.y_2
        x11, x12, x22 = sheet.x_second
        y11, y12, y22 = sheet.y_second
        p1, p2 = self.stress(sheet)

        def second(xa: Array, ya: Array, xb: Array, yb: Array, xab: Array, yab: Array) -> Array:
            mixed: Array = self.W11 * xa * xb + self.W12 * (xa * yb + ya * xb) + self.W22 * ya * yb
            return np.asarray(mixed + self.W1 * xab + self.W2 * yab)

        return Membrane(
            W=(self.W() if callable(self.W) else self.W) + 0.0 * sheet.x,
            P1=p1,
            P2=p2,
            A11=second(x1, y1, x1, y1, x11, y11),
            A12=second(x1, y1, x2, y2, x12, y12),
            A22=second(x2, y2, x2, y2, x22, y22),
        )


def of_I1(W: Value, W1: Value, W11: Value) -> InvariantTerm:
    """Return a term of I1 alone: its value, first and second derivative."""
    return InvariantTerm(W=W, W1=W1, W11=W11)


def of_I2(W: Value, W2: Value, W22: Value) -> InvariantTerm:
    """Return a term of I2 alone: its value, first and second derivative."""
    return InvariantTerm(W=W, W2=W2, W22=W22)


@dataclass(frozen=True)
class PowerTerm:
    """``factor (l1^alpha + l2^alpha + l3^alpha - 3) / alpha``, also for alpha near 0."""

    alpha: Value
    factor: Value = 1.0

    def stress(self, sheet: Sheet) -> tuple[Array, Array]:
        """Return dW/dl1 and dW/dl2: (l^alpha - l3^alpha) / l, the difference without cancellation."""
        log3 = np.log(sheet.l3)
        base = self.factor * np.exp(self.alpha * log3)
        return (
            base * np.expm1(self.alpha * (np.log(sheet.l1) - log3)) / sheet.l1,
            base * np.expm1(self.alpha * (np.log(sheet.l2) - log3)) / sheet.l2,
        )

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives."""
        a, l1, l2, l3 = self.alpha, sheet.l1, sheet.l2, sheet.l3
        p1, p2 = self.stress(sheet)
        power1, power2, power3 = (np.exp(a * np.log(stretch)) for stretch in (l1, l2, l3))
        total = sum(np.expm1(a * np.log(stretch)) for stretch in (l1, l2, l3))
        return Membrane(
            W=self.factor * total / np.where(a == 0.0, 1.0, a),
            P1=p1,
            P2=p2,
            A11=self.factor * ((a - 1.0) * power1 + (a + 1.0) * power3) / l1**2,
            A12=self.factor * a * power3 / (l1 * l2),
            A22=self.factor * ((a - 1.0) * power2 + (a + 1.0) * power3) / l2**2,
        )
