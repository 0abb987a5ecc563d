"""What a strain-energy law is: its constants, and its energy as a sum of terms linear in some of them.

A sheet is in plane stress and incompressible: two in-plane stretches, the thickness follows from them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]


@dataclass(frozen=True)
class Sheet:
    """In-plane principal stretches ``l1``, ``l2`` (same shape, dimensionless) of a sheet with l1 l2 l3 = 1.

    All derivatives are along the two in-plane stretches, with the thickness stretch eliminated. The
    invariants are measured from rest and computed without cancellation, so that stresses keep their digits
    at small strain.

    >>> Sheet.of(2.0, 1.0).x
    array(2.25)
    """

    l1: Array
    l2: Array

    @classmethod
    def of(cls, l1: ArrayLike, l2: ArrayLike) -> Sheet:
        """Return the state for stretches of any shape that broadcast against each other."""
        first, second = np.broadcast_arrays(np.asarray(l1), np.asarray(l2))
        kind = np.result_type(first, second, np.float64)
        return cls(first.astype(kind), second.astype(kind))

    @cached_property
    def l3(self) -> Array:
        """Thickness stretch."""
        return 1.0 / (self.l1 * self.l2)

    @cached_property
    def logs(self) -> tuple[Array, Array, Array]:
        """Logarithms of the three stretches."""
        one, two = np.log(self.l1), np.log(self.l2)
        return one, two, -(one + two)

    @cached_property
    def x(self) -> Array:
        """I1 - 3 = l1^2 + l2^2 + l3^2 - 3."""
        return _from_rest(self.l1, self.l2)

    @cached_property
    def y(self) -> Array:
        """I2 - 3 = l1^-2 + l2^-2 + l3^-2 - 3."""
        return _from_rest(1.0 / self.l1, 1.0 / self.l2)

    @cached_property
    def x_1(self) -> Array:
        """d I1 / d l1."""
        return np.asarray(2.0 * (self.l1 - self.l3) * (self.l1 + self.l3) / self.l1)

    @cached_property
    def x_2(self) -> Array:
        """d I1 / d l2."""
        return np.asarray(2.0 * (self.l2 - self.l3) * (self.l2 + self.l3) / self.l2)

    @cached_property
    def x_second(self) -> tuple[Array, Array, Array]:
        """Second derivatives of I1: 11, 12, 22."""
        a, b = self.l3 / self.l1, self.l3 / self.l2
        return 2.0 + 6.0 * a * a, 4.0 * a * b, 2.0 + 6.0 * b * b

    @cached_property
    def y_second(self) -> tuple[Array, Array, Array]:
        """Second derivatives of I2: 11, 12, 22."""
        one, two = self.l1, self.l2
        return 6.0 / one**4 + 2.0 * two**2, 4.0 * one * two, 6.0 / two**4 + 2.0 * one**2


def _from_rest(a: Array, b: Array) -> Array:
    """Return a^2 + b^2 + (a b)^-2 - 3 as a sum of squares."""
    p = a * b
    return np.asarray((a - b) ** 2 + ((p - 1.0) / p) ** 2 * (2.0 * p + 1.0))


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


#: Where exp(y) - 1 - y is summed: fourteen powers leave nothing, beyond it little cancels.
_NEAR = 0.3


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
        # The logarithms add up to zero: without them what is left is positive, and nothing cancels at a small alpha.
        total = sum(above_tangent(a * log) for log in sheet.logs)
        return Membrane(
            W=self.factor * total / np.where(a == 0.0, 1.0, a),
            P1=p1,
            P2=p2,
            A11=self.factor * ((a - 1.0) * power1 + (a + 1.0) * power3) / l1**2,
            A12=self.factor * a * power3 / (l1 * l2),
            A22=self.factor * ((a - 1.0) * power2 + (a + 1.0) * power3) / l2**2,
        )


def above_tangent(y: Value) -> Array:
    """Return ``exp(y) - 1 - y``, near 0 by its series: to rounding of itself.

    >>> above_tangent(1e-6)
    array(5.00000167e-13)
    """
    y = np.asarray(y)
    near = np.abs(y) < _NEAR
    z = np.where(near, y, 0.0)
    series = np.zeros_like(z)
    for order in range(14, 1, -1):
        series = series * z + 1.0 / math.factorial(order)
    return np.where(near, z * z * series, np.expm1(y) - y)


def log_I2(sheet: Sheet) -> InvariantTerm:
    """Return ``ln(I2/3)``; Gent & Thomas (1958), J. Polym. Sci. 28, 625, doi:10.1002/pol.1958.1202811814."""
    I2 = 3.0 + sheet.y
    return of_I2(W=np.log1p(sheet.y / 3.0), W2=1.0 / I2, W22=-1.0 / I2**2)


@dataclass(frozen=True)
class Extent:
    """What the stretches of a data set allow: the largest I1 - 3 and I2 - 3 in it."""

    x: float
    y: float


@dataclass(frozen=True)
class Axis:
    """How a constant the energy is not linear in is sought: ``value(u)`` for u in ``[low, high]``, evenly scanned.

    ``value`` is smooth and takes arrays and complex numbers, so that derivatives along u come from it.
    """

    low: float
    high: float
    value: Callable[[Value], Value]

    def coordinate(self, value: float) -> float:
        """Return u in the box at which the constant is ``value`` (``value(u)`` rises or falls throughout)."""
        low, high = self.low, self.high
        rising = self.value(high) > self.value(low)
        for _ in range(50):
            middle = 0.5 * (low + high)
            if (self.value(middle) < value) == rising:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)


def stresses(names: Iterable[str]) -> tuple[str, ...]:
    """Return which constants are stresses: their names end in the unit."""
    return tuple(name for name in names if name.endswith("_MPa"))


def scaled(parameters: Mapping[str, float], factor: float) -> dict[str, float]:
    """Return the constants of any law ``factor`` times as stiff at every stretch.

    >>> scaled({"mu_MPa": 0.4, "f": 0.0, "nu": 0.25}, 0.5)
    {'mu_MPa': 0.2, 'f': 0.0, 'nu': 0.25}
    """
    every = stresses(parameters)
    return {name: value * factor if name in every else value for name, value in parameters.items()}


def linear_axis(low: float, high: float) -> Axis:
    """Scan evenly from ``low`` to ``high``."""
    return Axis(low, high, lambda u: u)


def log_axis(low: float, high: float, beyond: float = 0.0) -> Axis:
    """Scan ``beyond + d`` with d from ``low`` to ``high``, evenly in the logarithm of d."""
    return Axis(math.log(low), math.log(high), lambda u: beyond + np.exp(u))


class Law(ABC):
    """A strain energy ``W = sum_k c_k w_k(stretches; theta)`` of an incompressible sheet.

    A law is one file: subclasses state the names of the constants and the terms ``w_k``. The constants in
    documents and on paper (``parameters``) are ``c`` and ``theta`` under their names unless a law says otherwise.
    """

    #: Name on the command line and in documents.
    name: str
    #: One line for help and the table of laws.
    title: str
    #: Where the equation comes from.
    source: str
    #: The energy in the field's notation.
    equation: str
    #: Names of the factors the energy is linear in, constants in MPa as a rule (see ``stresses``).
    linear: tuple[str, ...]
    #: Names of the other constants.
    nonlinear: tuple[str, ...] = ()
    #: Constants, by these names, that a fit leaves at a value.
    held: Mapping[str, float] = MappingProxyType({})
    #: Whether the terms are alike and differ by one nonlinear constant each, as in Ogden's law.
    exchangeable: bool = False
    #: Whether its own constants tell how the volume changes.
    compressible: bool = False
    #: Between which values a constant has a meaning, where a refit must not leave them.
    bounds: Mapping[str, tuple[float, float]] = MappingProxyType({})
    #: Whether all directions of the sheet are alike; else the constants are those of its first axis.
    isotropic: bool = True

    @property
    def carries_simple_shear(self) -> bool:
        """Whether simple shear is planar tension to it but for a turn: it keeps its volume and is alike all round."""
        return self.isotropic and not self.compressible

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all constants, in the order of the document."""
        return (*self.linear, *self.nonlinear)

    @property
    def stresses(self) -> tuple[str, ...]:
        """Names of the constants that are stresses: energy, stress and stiffness go with all of them together."""
        return stresses(self.names)

    @abstractmethod
    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> Sequence[Term]:
        """Return the term of each linear constant; ``theta`` may hold arrays that broadcast on the stretches."""

    def split(self, parameters: Mapping[str, float]) -> tuple[list[float], list[float]]:
        """Return the linear constants ``c`` and the others ``theta`` of a set of parameters."""
        theta = [float(parameters[name]) for name in self.nonlinear]
        return [float(parameters[name]) for name in self.linear], theta

    def join(self, c: Sequence[float], theta: Sequence[float]) -> dict[str, float]:
        """Return the parameters, by name, of ``c`` and ``theta``."""
        return dict(zip(self.names, [*map(float, c), *map(float, theta)], strict=True))

    def axes(self, extent: Extent) -> list[Axis]:
        """Return how each nonlinear constant is sought, for data of that extent."""
        return []

    def sign(self, theta: Sequence[Value]) -> Value | None:
        """Return the sign each linear constant must have (array, +1 or -1), or None where all are free.

        nan where the nonlinear constants are none that a fit takes.
        """
        return None

    def order(self, theta: Sequence[float]) -> list[int]:
        """Return the order in which exchangeable terms are written."""
        return list(range(len(theta)))

    def lower(self) -> Law | None:
        """Return the law with one exchangeable term less, or None."""
        return None

    def turned(self, values: Sequence[float]) -> list[float]:
        """Return constants in the order of ``names`` for the sheet turned by a quarter."""
        return list(values)

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """Say what is wrong with constants that have no meaning, or None."""
        return None

    def contraction(self, theta: Sequence[Value]) -> Value:
        """Return nu in ``lateral = stretch^-nu``, the contraction of a uniaxial test: 1/2 keeps the volume."""
        return 0.5


def distance_to(limit: Value, value: Array) -> Array:
    """Return ``limit - value``, nan where the limit is reached: the energy does not exist beyond it."""
    left = np.asarray(limit - value)
    return np.where(left.real > 0.0, left, np.nan)


def positive(parameters: Mapping[str, float], *names: str) -> str | None:
    """Return the complaint about the first of ``names`` that is not above zero, or None."""
    bad = [name for name in names if parameters[name] <= 0.0]
    return f"{bad[0]} is not above zero" if bad else None
