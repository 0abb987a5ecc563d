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

    def stress(self, sheet: Sheet, along: int = 1) -> Array:
        """Return dW/dl1, or dW/dl2 with ``along`` 2."""

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives."""


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

    def stress(self, sheet: Sheet, along: int = 1) -> Array:
        """Return dW/dl1, or dW/dl2 with ``along`` 2, by the chain rule."""
        # d I2 / d l1 = l2^2 d I1 / d l1: what a mode leaves unstressed stays exactly zero.
        x, other = (sheet.x_1, sheet.l2) if along == 1 else (sheet.x_2, sheet.l1)
        if isinstance(self.W2, float) and self.W2 == 0.0:
            return np.asarray(self.W1 * x)
        return np.asarray((self.W1 + self.W2 * other**2) * x)

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives by the chain rule."""
        x1, x2 = sheet.x_1, sheet.x_2
        y1, y2 = np.asarray(sheet.l2**2 * x1), np.asarray(sheet.l1**2 * x2)
        x11, x12, x22 = sheet.x_second
        y11, y12, y22 = sheet.y_second
        p1, p2 = self.stress(sheet), self.stress(sheet, along=2)

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

    def stress(self, sheet: Sheet, along: int = 1) -> Array:
        """Return dW/dl: (l^alpha - l3^alpha) / l along l1, or l2, the difference without cancellation."""
        log3 = sheet.logs[2]
        log, stretch = (sheet.logs[0], sheet.l1) if along == 1 else (sheet.logs[1], sheet.l2)
        rise = np.expm1(self.alpha * (log - log3))
        return np.asarray(self.factor * np.exp(self.alpha * log3) * rise / stretch)

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives."""
        a, l1, l2 = self.alpha, sheet.l1, sheet.l2
        p1, p2 = self.stress(sheet), self.stress(sheet, along=2)
        power1, power2, power3 = (np.exp(a * log) for log in sheet.logs)
        total = sum(np.expm1(a * log) for log in sheet.logs)
        return Membrane(
            W=self.factor * total / np.where(a == 0.0, 1.0, a),
            P1=p1,
            P2=p2,
            A11=self.factor * ((a - 1.0) * power1 + (a + 1.0) * power3) / l1**2,
            A12=self.factor * a * power3 / (l1 * l2),
            A22=self.factor * ((a - 1.0) * power2 + (a + 1.0) * power3) / l2**2,
        )


def log_I2(sheet: Sheet) -> InvariantTerm:
    """Return ``ln(I2/3)``; Gent & Thomas (1958), J. Polym. Sci. 28, 625, doi:10.1002/pol.1958.1202811814."""
    I2 = 3.0 + sheet.y
    return of_I2(W=np.log1p(sheet.y / 3.0), W2=1.0 / I2, W22=-1.0 / I2**2)
