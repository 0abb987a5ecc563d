"""The stress of each row as a linear function of the linear constants: the design matrix, and its slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hyperfab.materials.identification.rows import Rows
from hyperfab.materials.law import Array, Axis, Law

#: Step of the complex-step derivative: no subtraction, so it may be tiny.
_STEP = 1e-40


@dataclass(frozen=True)
class Problem:
    """A law on rows: weighted design matrix ``A(u)`` and right side ``b``, so that the fit is min |b - A(u) c|.

    ``u`` are the free nonlinear constants in the coordinates of their axes; ``c`` the free linear constants, for
    each group of rows in turn.
    """

    law: Law
    rows: Rows

    @cached_property
    def axes(self) -> list[Axis]:
        """The axes of the free nonlinear constants."""
        every = self.law.axes(self.rows.extent)
        return [axis for name, axis in zip(self.law.nonlinear, every, strict=True) if name not in self.law.held]

    @cached_property
    def free(self) -> list[int]:
        """The numbers of the free linear constants."""
        return [number for number, name in enumerate(self.law.linear) if name not in self.law.held]

    @cached_property
    def b(self) -> Array:
        """Weighted stresses."""
        return self.rows.weight * self.rows.stress

    def theta(self, u: Sequence[Any]) -> list[Any]:
        """Return all nonlinear constants for the coordinates ``u`` of the free ones."""
        values = iter([axis.value(value) for axis, value in zip(self.axes, u, strict=True)])
        return [self.law.held[name] if name in self.law.held else next(values) for name in self.law.nonlinear]

    def coordinates(self, theta: Sequence[float]) -> Array:
        """Return ``u`` for all nonlinear constants ``theta``, kept inside the box."""
        free = [value for name, value in zip(self.law.nonlinear, theta, strict=True) if name not in self.law.held]
        return np.array([axis.coordinate(value) for axis, value in zip(self.axes, free, strict=True)])

    def design(self, u: Array) -> Array:
        """Return A, shape (..., rows, constants), for ``u`` of shape (..., free nonlinear constants)."""
        columns = self.columns(self.theta([u[..., j, None] for j in range(u.shape[-1])]))
        return self._by_group(columns)

    def columns(self, theta: Sequence[Any]) -> Array:
        """Return the weighted stress of each free linear term, shape (..., rows, terms)."""
        sheet = self.rows.sheet(self.law.contraction(theta))
        terms = self.law.terms(sheet, theta)
        second = self.rows.along == 1 if self.rows.along.any() else None
        counts = self.rows.weight * self.rows.share
        found = []
        for number in self.free:
            stress = terms[number].stress(sheet)
            if second is not None:
                stress = np.where(second, terms[number].stress(sheet, along=2), stress)
            found.append(stress * counts)
        return np.stack(np.broadcast_arrays(*found), axis=-1)

    def slopes(self, u: Array) -> list[Array]:
        """Return dA/du_j for each free nonlinear constant, by complex steps."""
        found = []
        for j in range(u.shape[-1]):
            shifted = u.astype(complex)
            shifted[..., j] += 1j * _STEP
            found.append(self.design(shifted).imag / _STEP)
        return found

    def signs(self, u: Array) -> Array | None:
        """Return the sign each constant must have, shape (..., constants), or None."""
        sign = self.law.sign(self.theta([u[..., j] for j in range(u.shape[-1])]))
        return None if sign is None else np.tile(np.moveaxis(sign, 0, -1), self.rows.groups)

    def _by_group(self, columns: Array) -> Array:
        if self.rows.groups <= 1:
            return columns
        own = self.rows.group[:, None] == np.arange(self.rows.groups)
        blocks = columns[..., None, :] * own[..., :, None]
        return blocks.reshape(*columns.shape[:-1], -1)
