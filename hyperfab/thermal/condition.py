"""What a boundary condition is to the rest: a heat flow into the body, and how it changes with temperature."""

from __future__ import annotations

from typing import Protocol

from hyperfab.arrays import Array, Ints


class Condition(Protocol):
    """Heat that enters the body through a face, a volume or a joint.

    ``name`` says which in messages and in the energy balance. ``nodes`` (m, k) are the groups of nodes it couples
    (facets, or both sides of a joint).
    """

    name: str

    @property
    def nodes(self) -> Ints:
        """Return the node groups (m, k) coupled by the condition."""

    @property
    def linear(self) -> bool:
        """Whether the flow is linear in temperature, with a slope that never changes."""

    def flow(self, time: float, temperature: Array) -> Array:
        """Return the nodal heat flow into the body (n,) [W] at nodal temperatures (n,) [degC]."""

    def tangent(self, time: float, temperature: Array) -> Array:
        """Return minus the derivative of the flow by temperature, one matrix a group (m, k, k) [W/K]."""
