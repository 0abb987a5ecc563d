"""Where a sheet is, one line of a solver's history, and what a solver ends with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from hyperfab.arrays import Array, Ints

from .mold import States


class State(NamedTuple):
    """Where the nodes are, and how each stands to the mold; kernels take it as it is."""

    x: Array  # (n, m, 3) mm
    contact: States  # (n, m) FREE, or 1 + feature
    slot: Ints  # (n, m) facet on or near
    clear: Array  # (n, m) mm, free of the mold at least this far
    crossed: States  # (n, m) 1: its last step led over a sharp edge, where the next one stops; 2: in valleys too

    def assign(self, other: State) -> None:
        """Become as ``other``."""
        for name in self._fields:
            getattr(self, name)[:] = getattr(other, name)

    def copy(self) -> State:
        """Arrays of its own."""
        return State(self.x.copy(), self.contact.copy(), self.slot.copy(), self.clear.copy(), self.crossed.copy())


@dataclass(frozen=True)
class Step:
    """One line of the energy history."""

    nodes: tuple[int, int]
    iteration: int
    energy: float  # N mm
    residual: float  # relative
    contacts: int
    step_length: float
    inner: int  # conjugate gradient steps
    set_changed: bool


@dataclass
class Equilibrium:
    """What a solve ended with."""

    state: State
    converged: bool
    energy: float  # N mm
    residual_max: float  # N
    residual_relative: float
    worst: tuple[int, int]
    press: Array  # (n, m) N
    force: Array  # (n, m, 3) N spring forces and weight
    residual: Array  # (n, m, 3) N
    bent: Ints  # (k, 4) springs laid over sharp edges: node, direction, crease
    bent_length: Array  # (k,) mm
    bent_at: Array  # (k, 3) mm, where they run over the edge
    push: Array  # (3,) N, of the sharp edges on the springs laid over them
    status: str
    history: list[Step]
