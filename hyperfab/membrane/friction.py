"""Coulomb friction and full stick between the sheet and the punch.

Within a load step a touching node is pulled back towards its anchor: the point of the punch where it sat at the
step's start, or where it lands in the step. It sticks there while the friction needed is below
mu times the normal force; else it slips, and the friction has this size and points against the way it slipped.

Where nodes go to and fro between the two, friction grows smoothly with slip instead, over a ``creep`` that is taken
towards nothing from equilibrium to equilibrium (regularised friction: J. T. Oden, E. B. Pires, J. Appl. Mech. 50 (1983)
67; smoothing as a path to the sharp law: X. Chen, J. Oper. Res. Soc. Japan 43 (2000) 32).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.contact import Memory, Terms
from hyperfab.membrane.punch import Nearness

#: A slip shorter than this [mm] has no direction of its own.
_NO_WAY = 1e-9
#: A node that went to and fro this often in one step is left slipping.
_MOST_CHANGES = 4
#: Without creep, a slip shorter than this [mm] turns too easily to be followed by Newton's stiffness.
_TURNS = 1e-6
#: A node that slipped less than this many creeps sticks: it rubs with less than 0.995 of what it could.
_STICKS = 10.0


@dataclass(frozen=True)
class Stick:
    """A node stays where it touches."""

    symmetric = True
    remembers = True
    holds = True

    def begin(self, memory: Memory, anchors: Array) -> _Sticking:
        """Start a load step: nodes are held at their anchors."""
        return _Sticking(anchors, np.ones(len(anchors), bool))


@dataclass(frozen=True)
class Coulomb:
    """Friction of at most ``coefficient`` times the normal force.

    ``creep`` [mm]: after a slip s there is s / sqrt(s^2 + creep^2) of that; where it is 0 all of it, or what sticking
    needs.
    """

    coefficient: float
    creep: float = 0.0
    symmetric = False
    remembers = True
    holds = False

    def begin(self, memory: Memory, anchors: Array) -> _Rubbing:
        """Start a load step from the flags and directions of the last one."""
        return _Rubbing(self.coefficient, memory, anchors, self.creep)


@dataclass(frozen=True)
class _Sticking:
    anchors: Array
    sticking: Flags
    settled = True

    def terms(self, nodes: Ints, places: Array, pull: Array, near: Nearness, spring: Array) -> Terms:
        away = places - self.anchors[nodes]
        across = away - (away * near.normal).sum(axis=1)[:, None] * near.normal
        return Terms(
            force=pull.copy(),
            right=-spring[:, None] * (near.gap[:, None] * near.normal + across),
            blocks=spring[:, None, None] * np.eye(3),
        )


class _Rubbing:
    def __init__(self, coefficient: float, memory: Memory, anchors: Array, creep: float) -> None:
        self.coefficient = coefficient
        self.creep = creep
        self.anchors = anchors
        # Slip is counted from the step's start, also where a node lands later: its way is then sure.
        self.origins = memory.origins
        self.ways = memory.ways.copy()
        self.sticking = memory.sticking.copy()
        self.changes = np.zeros(len(self.sticking), int)
        self.settled = True

    def terms(self, nodes: Ints, places: Array, pull: Array, near: Nearness, spring: Array) -> Terms:
        normal = near.normal
        pressure = (pull * normal).sum(axis=1)
        drag = pull - pressure[:, None] * normal
        away = places - self.origins[nodes]
        depth = (away * normal).sum(axis=1)
        slip = away - depth[:, None] * normal
        held_from = places - self.anchors[nodes]
        held_from -= (held_from * normal).sum(axis=1)[:, None] * normal
        size = np.hypot(np.linalg.norm(slip, axis=1), self.creep)
        if self.creep:
            stuck = np.zeros(len(nodes), bool)
            way = slip / size[:, None]
            self.sticking[nodes] = size < _STICKS * self.creep
        else:
            self._decide(nodes, pressure, drag, slip)
            stuck = self.sticking[nodes]
            way = self.ways[nodes] - (self.ways[nodes] * normal).sum(axis=1)[:, None] * normal
            way /= np.maximum(np.linalg.norm(way, axis=1), 1e-300)[:, None]
        identity = np.eye(3)
        outer = normal[:, :, None] * normal[:, None, :]
        # How the direction of slip turns with the node's place.
        turned = identity - outer - depth[:, None, None] * near.turning
        turned -= normal[:, :, None] * np.einsum("ki,kij->kj", away, near.turning)[:, None, :]
        least = min(_TURNS, self.creep or _TURNS)
        swing = np.einsum("kij,kjl->kil", identity - way[:, :, None] * way[:, None, :], turned)
        swing *= np.where(size >= least, 1.0 / np.maximum(size, least), 0.0)[:, None, None]
        rub = self.coefficient * pressure
        sliding = spring[:, None, None] * outer + np.einsum(
            "kij,kjl->kil",
            identity + self.coefficient * way[:, :, None] * normal[:, None, :],
            rub[:, None, None] * swing - pressure[:, None, None] * near.turning,
        )
        held = spring[:, None, None] * identity
        mix = np.where(
            stuck[:, None, None], identity, identity + self.coefficient * way[:, :, None] * normal[:, None, :]
        )
        force = np.where(stuck[:, None], pull, pressure[:, None] * normal - rub[:, None] * way)
        back = near.gap[:, None] * normal + np.where(stuck[:, None], held_from, 0.0)
        return Terms(
            force=force,
            right=-spring[:, None] * back,
            blocks=np.where(stuck[:, None, None], held, sliding),
            mix=mix,
        )

    def _decide(self, nodes: Ints, pressure: Array, drag: Array, slip: Array) -> None:
        """Let nodes go that would need more friction than there is, and hold those that slip backwards."""
        stuck = self.sticking[nodes]
        needed = np.linalg.norm(drag, axis=1)
        size = np.linalg.norm(slip, axis=1)
        loose = stuck & (needed > self.coefficient * np.maximum(pressure, 0.0) * (1 + 1e-9))
        self.ways[nodes[loose]] = -drag[loose] / needed[loose, None]
        moving = ~stuck & (size > _NO_WAY)
        direction = slip / np.maximum(size, _NO_WAY)[:, None]
        backwards = moving & ((direction * self.ways[nodes]).sum(axis=1) < 0.0) & (self.changes[nodes] < _MOST_CHANGES)
        onwards = moving & ~backwards
        self.ways[nodes[onwards]] = direction[onwards]
        self.sticking[nodes[loose]] = False
        self.sticking[nodes[backwards]] = True
        changed = loose | backwards
        self.changes[nodes[changed]] += 1
        self.settled = not changed.any()
