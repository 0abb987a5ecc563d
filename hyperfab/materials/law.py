"""What a strain-energy law is: its constants, and its energy as a sum of terms linear in some of them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from hyperfab.materials.kinematics import Array, Sheet
from hyperfab.materials.term import Term, Value


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
