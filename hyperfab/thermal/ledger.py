"""The account of heat: supplied by heaters, lost through faces, stored in the body; the three must balance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hyperfab.thermal.heater import Heater
from hyperfab.thermal.model import HeatModel

Array = NDArray[np.float64]


@dataclass
class Ledger:
    """Heat since the start [J]. ``entered`` has one row a step and one column a condition (then held nodes).

    ``supplying`` marks the heaters' columns. ``stored`` is the heat in the body after each step, less that at the
    start.
    """

    names: list[str]
    supplying: NDArray[np.bool_]
    first_stored: float
    entered: list[Array] = field(default_factory=list)
    stored: list[float] = field(default_factory=list)

    @staticmethod
    def begin(model: HeatModel, stored: Array) -> Ledger:
        """Open the account with the heat in the body."""
        names = [c.name for c in model.conditions] + [held.name for held in model.prescribed]
        heaters = [isinstance(c, Heater) for c in model.conditions] + [False] * len(model.prescribed)
        return Ledger(names, np.array(heaters, dtype=bool), float(stored.sum()))

    def add(self, heat: Array, stored: Array) -> None:
        """Enter one step."""
        self.entered.append(heat)
        self.stored.append(float(stored.sum()) - self.first_stored)

    @property
    def by_condition(self) -> dict[str, float]:
        """Heat that entered through each condition so far [J]; lost heat is negative."""
        total = np.sum(self.entered, axis=0) if self.entered else np.zeros(len(self.names))
        return dict(zip(self.names, total.tolist(), strict=True))

    def supplied(self, steps: int | None = None) -> float:
        """Heat given by the heaters in the first ``steps`` steps (all) [J]."""
        return float(np.sum([row[self.supplying].sum() for row in self.entered[:steps]]))

    def lost(self, steps: int | None = None) -> float:
        """Heat that left through all other conditions [J]."""
        return -float(np.sum([row[~self.supplying].sum() for row in self.entered[:steps]]))

    def imbalance(self) -> float:
        """Return the largest |supplied - lost - stored| after any step, over the heat turned over in the whole run.

        The heat turned over is all that passed through any condition, in or out.
        """
        if not self.entered:
            return 0.0
        entered = np.cumsum([row.sum() for row in self.entered])
        turned = float(np.sum(np.abs(self.entered)))
        open_by = float(np.abs(entered - np.array(self.stored)).max())
        scale = max(turned, float(np.abs(self.stored).max()))
        return open_by / scale if scale > 0.0 else 0.0
