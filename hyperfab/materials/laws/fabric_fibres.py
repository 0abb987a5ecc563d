"""Orthotropic fabric law: two families of fibres, along and across, in an isotropic ground.

``W = C10 (I1 - 3) + sum over both of k1/(2 k2) (exp(k2 <l^2 - 1>^2) - 1)``, where fibres bear tension only (<.> is the
positive part). After Holzapfel, Gasser & Ogden (2000), J. Elast. 61, 1, doi:10.1023/A:1010835316564, with the fibres
in the axes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.materials.law import Array, Axis, Extent, Law, Membrane, Sheet, Term, Value, log_axis, of_I1, positive


@dataclass(frozen=True)
class _Fibre:
    """Fibres along the first (1) or second (2) axis of the sheet, over their k1."""

    axis: int
    k2: Value

    def _tension(self, sheet: Sheet) -> tuple[Array, Array, Array]:
        """Return the stretch, l^2 - 1 where it is tension, and its exponential."""
        stretch = sheet.l1 if self.axis == 1 else sheet.l2
        strain = np.where(stretch.real > 1.0, (stretch - 1.0) * (stretch + 1.0), 0.0)
        return stretch, strain, np.exp(self.k2 * strain * strain)

    def stress(self, sheet: Sheet, along: int = 1) -> Array:
        """Return dW/dl1, or dW/dl2 with ``along`` 2; fibres have none across themselves."""
        stretch, strain, growth = self._tension(sheet)
        return np.asarray(2.0 * stretch * strain * growth if along == self.axis else 0.0 * strain * growth)

    def membrane(self, sheet: Sheet) -> Membrane:
        """Return the energy with first and second derivatives."""
        stretch, strain, growth = self._tension(sheet)
        square = stretch * stretch
        slope = growth * (2.0 * strain + 4.0 * square + 8.0 * self.k2 * square * strain * strain)
        slope = np.where(stretch.real > 1.0, slope, 0.0)
        none = 0.0 * slope
        return Membrane(
            W=0.5 * np.expm1(self.k2 * strain * strain) / self.k2,
            P1=self.stress(sheet, along=1),
            P2=self.stress(sheet, along=2),
            A11=slope if self.axis == 1 else none,
            A12=none,
            A22=slope if self.axis == 2 else none,
        )


class FabricFibres(Law):
    """Warp and weft as fibres; the first axis of the sheet is the direction the constants are given for.

    In uniaxial tension the fibres across are slack, so that the ground contracts as if it were alone.
    """

    name = "fabric-fibres"
    title = "orthotropic: fibres along and across in an isotropic ground"
    source = "doi:10.1023/A:1010835316564"
    equation = "W = C10 (I1 - 3) + sum of k1/(2 k2) (exp(k2 <l^2 - 1>^2) - 1) along and across"
    linear = ("C10_MPa", "k1_along_MPa", "k1_across_MPa")
    nonlinear = ("k2_along", "k2_across")
    isotropic = False

    def axes(self, extent: Extent) -> list[Axis]:
        """From a straight line over the data to an upturn at a fraction of the larger stretch of the two directions."""
        reach = (extent.x + 2.0) ** 2
        return [log_axis(1e-3 / reach, 300.0 / reach) for _ in self.nonlinear]

    def refusal(self, parameters: Mapping[str, float]) -> str | None:
        """k2 is above zero."""
        return positive(parameters, *self.nonlinear)

    def turned(self, values: Sequence[float]) -> list[float]:
        """Exchange along and across."""
        c10, along, across, k2_along, k2_across = values
        return [c10, across, along, k2_across, k2_along]

    def terms(self, sheet: Sheet, theta: Sequence[Value]) -> list[Term]:
        """Return the ground and both families."""
        return [of_I1(W=sheet.x, W1=1.0, W11=0.0), _Fibre(1, theta[0]), _Fibre(2, theta[1])]


LAWS = (FabricFibres(),)
