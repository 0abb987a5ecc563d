"""The account of heat: supplied by heaters and held faces, lost through faces, stored; the three must balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array
from hyperfab.thermal.heater import Heater
from hyperfab.thermal.model import HeatModel

#: A body that changes by less [K] has turned no heat over that an error could be measured by.
LEAST_CHANGE = 1e-4


@dataclass
class Ledger:
    """Heat since the start [J]. ``entered`` has one row a step and one column a condition (then held nodes).

    ``supplying`` marks the heaters' columns, ``held`` those of held nodes, which supply in steps in which they give
    heat. ``stored`` is the heat in the body after each step, less that at the start. ``least`` is the heat that changes
    the body by LEAST_CHANGE [J].
    """

    names: list[str]
    supplying: NDArray[np.bool_]
    held: NDArray[np.bool_]
    first_stored: float
    least: float = 0.0
    entered: list[Array] = field(default_factory=list)
    stored: list[float] = field(default_factory=list)
    moved: float = 0.0

    @staticmethod
    def begin(model: HeatModel, stored: float, exchanged: Sequence[str] = ()) -> Ledger:
        """Open the account with the heat in the body; ``exchanged`` name parts that are renewed."""
        kinds = [
            *((c.name, isinstance(c, Heater), False) for c in model.conditions),
            *((one.name, False, True) for one in model.prescribed),
            *((name, False, False) for name in exchanged),
        ]
        least = LEAST_CHANGE * float(model.lumped_capacity.sum())
        heaters, held = (np.array([kind[k] for kind in kinds], dtype=bool) for k in (1, 2))
        return Ledger([name for name, _, _ in kinds], heaters, held, stored, least)

    def add(self, heat: Array, stored: float, moved: float) -> None:
        """Enter one step: ``stored`` is in the body after it, ``moved`` went from node to node in it."""
        self.moved += moved
        self.entered.append(np.concatenate([heat, np.zeros(len(self.names) - len(heat))]))
        self.stored.append(stored - self.first_stored)

    def cut(self, steps: int) -> None:
        """Forget all but the first ``steps`` steps."""
        del self.entered[steps:], self.stored[steps:]

    def exchange(self, name: str, stored: float) -> None:
        """Enter what a renewed part brings into the body, at the time of the last step."""
        now = stored - self.first_stored
        self.entered[-1][self.names.index(name)] += now - self.stored[-1]
        self.stored[-1] = now

    @property
    def by_condition(self) -> dict[str, float]:
        """Heat that entered through each condition so far [J]; lost heat is negative."""
        total = np.sum(self.entered, axis=0) if self.entered else np.zeros(len(self.names))
        return dict(zip(self.names, total.tolist(), strict=True))

    @property
    def by_step(self) -> tuple[Array, Array]:
        """Heat that was supplied and heat that was lost in each step (steps,) [J]."""
        rows = np.array(self.entered).reshape(len(self.entered), len(self.names))
        given = np.where(self.held, np.maximum(rows, 0.0), np.where(self.supplying, rows, 0.0))
        return given.sum(axis=1), -(rows - given).sum(axis=1)

    def supplied(self, steps: int | None = None) -> float:
        """Heat given by heaters and held nodes in the first ``steps`` steps (all) [J]."""
        return float(self.by_step[0][:steps].sum())

    def lost(self, steps: int | None = None) -> float:
        """Heat that left through all other conditions, and through held nodes that took it [J]."""
        return float(self.by_step[1][:steps].sum())

    def imbalance(self) -> float:
        """Return the largest |supplied - lost - stored| after any step, over the heat turned over in the whole run.

        The heat turned over is all that passed through any condition, in or out, or moved inside the body; at
        least what changes the body's temperature by LEAST_CHANGE, or rounding would be held against nothing.
        """
        if not self.entered:
            return 0.0
        entered = np.cumsum([row.sum() for row in self.entered])
        turned = max(float(np.sum(np.abs(self.entered))), self.moved)
        open_by = float(np.abs(entered - np.array(self.stored)).max())
        scale = max(turned, float(np.abs(self.stored).max()), self.least)
        return open_by / scale if scale > 0.0 else 0.0
