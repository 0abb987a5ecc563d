"""The readings a fit sees: one row a stress, whatever test it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Flags, Ints
from hyperfab.curve import TestCurve, share_of_shear
from hyperfab.materials.law import Array, Extent, Sheet
from hyperfab.materials.modes import SIMPLE_SHEAR, second_stretch, way


@dataclass(frozen=True)
class Rows:
    """All rows of a fit: loading stretch, second stretch where it is measured, stress, weight.

    In simple shear the stretches are the principal ones, and ``share`` what the stress is of dW/dl; 1 elsewhere.
    ``curve`` is the number of the curve a row belongs to, ``along`` is 0 for the stress along the first stretch and
    1 for the second, ``group`` numbers the sets of rows with linear constants of their own.
    """

    stretch: Array
    second: Array
    stress: Array
    weight: Array
    uniaxial: Flags
    along: Ints
    curve: Ints
    group: Ints
    share: Array
    _cache: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(
        cls,
        curves: Sequence[TestCurve],
        groups: Sequence[int] | None = None,
        axes: Sequence[int] | None = None,
    ) -> Rows:
        """Gather the rows of ``curves``; ``groups`` numbers the group of each curve (default: one group).

        ``axes`` is 2 for each curve that was tested along the second axis of an anisotropic sheet (default: none).
        """
        parts: list[tuple[Any, ...]] = []
        for number, curve in enumerate(curves):
            group = groups[number] if groups is not None else 0
            axis = axes[number] if axes is not None else 1
            uniaxial, weight = curve.mode == "uniaxial", curve.weights
            if curve.mode == "biaxial-general":
                if curve.stretch2 is None or curve.stress2 is None or curve.weight2 is None:
                    raise ValueError("a general biaxial curve needs stretch2, stress2 and weight2")
                one, two = curve.stretch, curve.stretch2
                sides = ((curve.stress, weight, axis - 1), (curve.stress2, curve.weight2, 2 - axis))
                if axis == 2:
                    one, two = two, one
                parts += [(one, two, stress, own, False, along, number, group, 1.0) for stress, own, along in sides]
            else:
                second = second_stretch(way(curve.mode), curve.principal)
                one, two = (curve.principal, second) if axis == 1 else (second, curve.principal)
                along = axis - 1
                share = share_of_shear(curve.principal) if curve.mode == SIMPLE_SHEAR else 1.0
                parts.append((one, two, curve.stress, weight, uniaxial, along, number, group, share))
        kinds = (float, float, float, float, bool, np.int64, np.int64, np.int64, float)
        columns: list[Any] = [
            np.concatenate([np.broadcast_to(np.asarray(part[i], dtype=kind), part[0].shape) for part in parts])
            for i, kind in enumerate(kinds)
        ]
        return cls(*columns)

    def __len__(self) -> int:
        return len(self.stretch)

    @property
    def groups(self) -> int:
        """How many sets of linear constants the rows ask for."""
        return int(self.group.max()) + 1 if len(self) else 0

    @property
    def extent(self) -> Extent:
        """Largest I1 - 3 and I2 - 3 of the rows, for a sheet that keeps its volume."""
        sheet = self.sheet(0.5)
        return Extent(float(sheet.x.max()), float(sheet.y.max()))

    def sheet(self, contraction: Any) -> Sheet:
        """Return the state of each row for a law that contracts by ``stretch^-contraction`` in uniaxial tension."""
        if isinstance(contraction, float) and contraction == 0.5:
            if "sheet" not in self._cache:
                self._cache["sheet"] = Sheet.of(self.stretch, self.second)
            found: Sheet = self._cache["sheet"]
            return found
        lateral = np.where(self.uniaxial, self.stretch**-contraction, self.second)
        return Sheet.of(self.stretch, lateral)

    def take(self, chosen: NDArray[Any]) -> Rows:
        """Return some of the rows."""
        names = ("stretch", "second", "stress", "weight", "uniaxial", "along", "curve", "group", "share")
        return Rows(*(getattr(self, name)[chosen] for name in names))
