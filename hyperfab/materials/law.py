"""What a strain-energy law is: its constants, and its energy as a sum of terms linear in some of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.kinematics import Array, Sheet
from hyperfab.materials.term import Term, Value


@dataclass(frozen=True)
class Extent:
    """What the stretches of a data set allow: the largest I1 - 3 and I2 - 3 in it."""

    x: float
    y: float


@dataclass(frozen=True)
class Nonlinear:
    """A constant the energy is not linear in: its name, the box it is sought in, and how it is scanned.

    ``low`` and ``high`` bound the box. With ``above_extent`` the constant is a limit that must lie beyond the
    data: the box holds ``value / limit of the data - 1``. With ``log`` the scan is even in the logarithm.
    """

    name: str
    low: float
    high: float
    log: bool = False
    points: int = 24


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
    #: Names of the constants the energy is linear in; those that end in ``_MPa`` are stresses.
    linear: tuple[str, ...]
    #: The other constants and the boxes they are sought in.
    nonlinear: tuple[Nonlinear, ...] = ()
    #: Whether every ``c_k`` must be positive (``+1``), negative (``-1``) or free (``0``).
    signs: tuple[int, ...] = ()
    #: Whether the law is part of ``--model all``.
    listed: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all constants, in the order of the document."""
        return (*self.linear, *(constant.name for constant in self.nonlinear))

    @abstractmethod
    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> Sequence[Term]:
        """Return the term of each linear constant; ``theta`` may hold arrays that broadcast on the stretches."""

    def split(self, parameters: Mapping[str, float]) -> tuple[list[float], list[float]]:
        """Return the linear constants ``c`` and the others ``theta`` of a set of parameters."""
        theta = [float(parameters[constant.name]) for constant in self.nonlinear]
        return [float(parameters[name]) for name in self.linear], theta

    def join(self, c: Sequence[float], theta: Sequence[float]) -> dict[str, float]:
        """Return the parameters, by name, of ``c`` and ``theta``."""
        return dict(zip(self.names, [*map(float, c), *map(float, theta)], strict=True))

    def box(self, extent: Extent) -> list[tuple[float, float]]:
        """Return the box each nonlinear constant is sought in, for data of that extent."""
        return [(constant.low, constant.high) for constant in self.nonlinear]

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
