"""What happens at a node that touches the punch, and what friction remembers of it from load step to load step.

The constraint is exact: at the solution touching nodes lie on the punch. In each Newton step a touching node gets a
very stiff spring along the normal (and along the surface where it sticks); the contact force itself is taken from the
sheet's own nodal force, so the spring leaves no error behind, needs no rotated axes and does not change the matrix
pattern.

Within a load step a node that rubs is pulled back towards its anchor: the point of the punch where it sat at the step's
start, or where it lands in the step. It sticks there while the friction needed is below mu times the normal force; else
it slips, and the friction has this size and points against the way it slipped.

Where nodes go to and fro between the two, friction grows smoothly with slip instead, over a ``creep`` that is taken
towards nothing from equilibrium to equilibrium (regularised friction: J. T. Oden, E. B. Pires, J. Appl. Mech. 50 (1983)
67; smoothing as a path to the sharp law: X. Chen, J. Oper. Res. Soc. Japan 43 (2000) 32).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.punch import Nearness, Punch

#: Stiff spring of a touching node relative to its own stiffness: large enough to hold the node, and far from the
#: 1e16 at which the solver would lose the sheet.
STIFF = 1e6
#: A slip shorter than this [mm] has no direction of its own.
_NO_WAY = 1e-9
#: A node that went to and fro this often in one step is left slipping.
_MOST_CHANGES = 4
#: Without creep, a slip shorter than this [mm] turns too easily to be followed by Newton's stiffness.
_TURNS = 1e-6
#: A node that slipped less than this many creeps sticks: it rubs with less than 0.995 of what it could.
_STICKS = 10.0


@dataclass(frozen=True)
class Terms:
    """What contact adds to Newton's equations at the touching nodes (k of them).

    ``force`` (k, 3) [N]: contact force on the sheet; ``right`` (k, 3): addition to the right-hand side beyond the
    balance of forces; ``blocks`` (k, 3, 3): addition to the diagonal blocks. ``mix`` (k, 3, 3), where there is
    friction, first multiplies the balance and its stiffness at these nodes: it takes the stiff spring out of the
    tangential equations, and ``right`` and ``blocks`` are what remains of them.
    """

    force: Array
    right: Array
    blocks: Array
    mix: Array | None = None


@dataclass(frozen=True)
class Frictionless:
    """The sheet slides freely: the contact force is normal.

    Of a law of friction ``symmetric`` tells whether its stiffness is, ``remembers`` whether an equilibrium hangs on how
    it was reached, ``holds`` whether a touching node stays where it landed, so that the result is of first order in the
    load step.
    """

    symmetric = True
    remembers = False
    holds = False

    def begin(self, memory: Memory, anchors: Array) -> _Sliding:
        """Start a load step from what is remembered of the last one; ``anchors`` (n, 3): where nodes begin to rub."""
        return _Sliding(np.zeros(len(anchors), bool))


@dataclass(frozen=True)
class _Sliding:
    """How the punch holds touching nodes along its surface during one load step: which nodes (n,) are ``sticking``,
    should they touch, and whether the last call of ``terms`` changed none of them (``settled``)."""

    sticking: Flags
    settled = True

    def terms(self, nodes: Ints, places: Array, pull: Array, near: Nearness, spring: Array) -> Terms:
        """Return the contact terms.

        ``nodes`` (k,) touch; ``places`` and ``pull`` (k, 3) are their places relative to the punch [mm] and the
        sheet's nodal forces [N]; ``near`` and ``spring`` (k,) [N/mm] belong to them.
        """
        normal = near.normal
        pressure = (pull * normal).sum(axis=1)
        outer = normal[:, :, None] * normal[:, None, :]
        return Terms(
            force=pressure[:, None] * normal,
            right=-(spring * near.gap)[:, None] * normal,
            blocks=spring[:, None, None] * outer - pressure[:, None, None] * near.turning,
        )

    def cost(self, nodes: Ints, places: Array, normal: Array, pressed: Array, stray: float) -> float:
        """Return the energy [N mm] that slip costs, of pressing forces ``pressed`` (k,) [N] that are held.

        ``stray`` [N]: what a node counts per mm that should stay in its place.
        """
        return 0.0


@dataclass(frozen=True)
class Memory:
    """An equilibrium at ``depth`` [mm] as friction sees it, for all nodes, in the frame of the punch.

    ``places`` (n, 3) [mm]; ``gap`` (n,) and ``normal`` (n, 3) to the punch; ``touching`` and ``sticking`` (n,);
    ``friction`` (n, 3) [N] on the sheet; ``ways`` (n, 3): directions of slip; ``dissipated`` [N mm] so far by what
    is meshed; ``drift`` (n, 3): how places move per mm of depth, None where that is not known.
    """

    depth: float
    places: Array
    gap: Array
    normal: Array
    touching: Flags
    friction: Array
    ways: Array
    sticking: Flags
    dissipated: float = 0.0
    drift: Array | None = None

    @property
    def origins(self) -> Array:
        """Points (n, 3) [mm] of the punch nearest to the nodes, from where slip is counted in the step that follows."""
        return np.asarray(self.places - self.gap[:, None] * self.normal)


def mounted(flat: Array, punch: Punch) -> Memory:
    """Return the memory of the mounted sheet, places (n, 3), before the punch moves: nothing touches."""
    near = punch.near(flat, 0.0)
    nothing, zeros = np.zeros(len(flat), bool), np.zeros_like(flat)
    return Memory(0.0, flat, near.gap, near.normal, nothing, zeros, zeros, nothing)


def remembered(
    before: Memory,
    anchors: Array,
    depth: float,
    places: Array,
    near: Nearness,
    touching: Flags,
    pull: Array,
    sticking: Flags,
) -> Memory:
    """Return the memory of the equilibrium that followed ``before``.

    ``places`` (n, 3) are those in space, ``pull`` (n, 3) the sheet's nodal forces, ``anchors`` (n, 3) where the nodes
    began to rub. The energy that slip has cost is the mean of the friction before and after times the slip.
    """
    own = places - np.array([0.0, 0.0, depth])
    across = pull - (pull * near.normal).sum(axis=1)[:, None] * near.normal
    friction = np.where(touching[:, None], across, 0.0)
    size = np.linalg.norm(friction, axis=1)
    ways = -friction / np.where(size > 0.0, size, 1.0)[:, None]
    slip = np.where(touching[:, None], own - anchors, 0.0)
    # A node that has just landed was rubbed with its present friction from the start.
    first = np.where(before.touching[:, None], before.friction, friction)
    spent = -float((0.5 * (first + friction) * slip).sum())
    return Memory(
        depth,
        own,
        near.gap,
        near.normal,
        touching,
        friction,
        ways,
        sticking & touching,
        before.dissipated + spent,
    )


def landings(memory: Memory, punch: Punch, depth: float) -> Array:
    """Return where each node touches, or comes to touch, the punch on the way to ``depth`` (n, 3).

    A touching node stays where it is. Near the edge of contact the gap closes as the square of the way that is left,
    so a node lands after 2 gap / (closing speed); until then it keeps its drift. The mounted sheet is taken straight
    down onto the punch.
    """
    if memory.drift is None:
        height = punch.height(memory.places[:, :2], 0.0)
        below = np.isfinite(height)
        lands = memory.places - memory.gap[:, None] * memory.normal
        lands[below] = np.column_stack([memory.places[below, :2], height[below]])
        return np.asarray(lands)
    step = depth - memory.depth
    closing = -(memory.normal * memory.drift).sum(axis=1)
    way = np.where(closing > 0.0, 2.0 * memory.gap / np.where(closing > 0.0, closing, 1.0), step)
    way = np.where(memory.touching, 0.0, np.clip(way, 0.0, step))
    places = memory.places + way[:, None] * memory.drift
    near = punch.near(places, 0.0)
    return np.asarray(places - near.gap[:, None] * near.normal)


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

    def cost(self, nodes: Ints, places: Array, normal: Array, pressed: Array, stray: float) -> float:
        return stray * float(_along(places - self.anchors[nodes], normal).sum())


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

    def cost(self, nodes: Ints, places: Array, normal: Array, pressed: Array, stray: float) -> float:
        slip = _along(places - self.origins[nodes], normal)
        return self.coefficient * float((pressed * np.hypot(slip, self.creep)).sum())

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


def _along(away: Array, normal: Array) -> Array:
    """Return how long (k,) the part of ``away`` (k, 3) along the surface is."""
    return np.asarray(np.linalg.norm(away - (away * normal).sum(axis=1)[:, None] * normal, axis=1))


#: How the punch holds touching nodes, and a law of friction.
Grip = _Sliding | _Sticking | _Rubbing
Tangential = Frictionless | Stick | Coulomb


def counted(grip: Grip, nodes: Ints, force: Array, normal: Array, places: Array, near: Nearness) -> float:
    """Return what an iteration that must lower the energy counts beside the sheet's own [N mm]: leaving the punch and,
    by the pressing forces as they were, slip. Friction has no energy; with these held it has.

    ``force`` (k, 3) [N] and ``normal`` (k, 3) are those of the touching ``nodes`` (k,) before a step, ``places`` (n, 3)
    and ``near`` of all nodes after it, relative to the punch.
    """
    stray = 2.0 * float(np.linalg.norm(force, axis=1).max(initial=0.0))
    pressed = np.maximum((force * normal).sum(axis=1), 0.0)
    slip = grip.cost(nodes, places[nodes], near.normal[nodes], pressed, stray)
    return stray * float(np.abs(near.gap[nodes]).sum()) + slip
