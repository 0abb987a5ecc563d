"""The states a run went through, kept small: older ones in a nameless file, reduced ones by coordinates."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import IO, Any, TypeVar, overload

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.vectors import dot
from hyperfab.thermal.facet_operator import Evenness, FacetOperator
from hyperfab.thermal.lumping import Alike
from hyperfab.thermal.step import State

T = TypeVar("T")

#: Bytes of states held in memory; what is more goes to the file, oldest first.
ROOM = 256 * 2**20
#: States that stand for all that a run goes through.
EXAMPLES = 20
#: States lifted at a time where all are looked through.
BLOCK = 64


@dataclass(frozen=True, eq=False)
class Lift:
    """Nodal fields from r coordinates: ``origin`` (n,) [degC] plus ``basis`` (n, r) times them.

    ``alike`` says which points of its faces count as one.
    """

    origin: Array
    basis: Array
    alike: Alike | None = None
    _made: dict[int, tuple[object, Any]] = field(default_factory=dict, init=False)

    def nodal(self, coordinates: Array) -> Array:
        """Return nodal temperatures [degC]."""
        return self.origin + self.basis @ coordinates

    @staticmethod
    def with_room(origin: Array, basis: Array, room: int, alike: Alike | None = None) -> Lift:
        """Return what lifts with a basis that may come to be one of ``room`` vectors without being copied."""
        store = np.empty((len(origin), max(room, basis.shape[1])))
        store[:, : basis.shape[1]] = basis
        return Lift(origin, store[:, : basis.shape[1]], alike)

    def wider(self, origin: Array, vectors: Array) -> Lift:
        """Return what lifts about another origin, with ``vectors`` (n, k) behind this basis, in the room it has.

        This one lifts as before: both see the same numbers.
        """
        store, known = self.basis.base, self.basis.shape[1]
        assert store is not None
        store[:, known : known + vectors.shape[1]] = vectors
        return Lift(origin, store[:, : known + vectors.shape[1]], self.alike)

    def part(self, nodes: Ints) -> Lift:
        """Return what lifts to ``nodes`` alone."""
        return self.once(nodes, lambda: Lift(self.origin[nodes], self.basis[nodes]))

    def sensor(self, sensor: Array) -> tuple[Array, float]:
        """Return what a sensor (n,) weighs the coordinates with (r,), and what it reads at the origin."""

        def made() -> tuple[Array, float]:
            felt = np.flatnonzero(sensor)
            return sensor[felt] @ self.basis[felt], dot(sensor, self.origin)

        return self.once(sensor, made)

    def once(self, of: object, make: Callable[[], T]) -> T:
        """Return what is made of something with this lift: made once."""
        # Kept with the thing itself: an id alone may come again for another.
        if id(of) not in self._made:
            self._made[id(of)] = of, make()
        found: T = self._made[id(of)][1]
        return found


def examples(states: Sequence[Past]) -> list[Array]:
    """Return the temperatures of some states from the first to the last, ``EXAMPLES`` at most."""
    chosen = np.linspace(0, len(states) - 1, min(len(states), EXAMPLES)).round().astype(int)
    return [states[k].temperature for k in chosen]


class Past:
    """A state gone through; ``stored`` and ``rate`` are kept of the last two alone.

    ``temperature`` (n,) [degC] and ``slope`` (n,) [K/s] are read or lifted when they are asked for.
    """

    def __init__(self, trail: Trail, number: int) -> None:
        self._trail = trail
        self._number = number
        self.time = trail.times[number]

    @property
    def is_reduced(self) -> bool:
        """Whether it is known by a reduced mold's coordinates."""
        return self._trail.entry(self._number)[0] is not None

    @property
    def temperature(self) -> Array:
        """Nodal temperatures [degC]."""
        lift, first, _ = self._trail.entry(self._number)
        return first if lift is None else lift.nodal(first)

    @property
    def coordinates(self) -> Array:
        """Its coordinates, where it is reduced."""
        return self._trail.entry(self._number)[1]

    @property
    def coordinates_slope(self) -> Array | None:
        """How fast its coordinates change, where it is reduced."""
        return self._trail.entry(self._number)[2]

    @property
    def slope(self) -> Array | None:
        """How fast they change [K/s], as the step found that led here; None at the start."""
        lift, _, second = self._trail.entry(self._number)
        return second if lift is None or second is None else lift.basis @ second

    @property
    def stored(self) -> Array:
        """Heat stored at each node [J]."""
        return self._trail.whole(self._number).stored

    @property
    def rate(self) -> Array:
        """Its rate of change [W]."""
        return self._trail.whole(self._number).rate

    def on(self, nodes: Ints) -> Array:
        """Return the temperatures of some nodes."""
        lift, first, _ = self._trail.entry(self._number)
        return first[nodes] if lift is None else lift.part(nodes).nodal(first)

    def reading(self, sensor: Array) -> tuple[float, float | None]:
        """Return what a sensor (n,) reads, and how fast that changes."""
        lift, first, second = self._trail.entry(self._number)
        if lift is None:
            return dot(sensor, first), None if second is None else dot(sensor, second)
        row, at_origin = lift.sensor(sensor)
        return at_origin + dot(row, first), None if second is None else dot(row, second)

    def evenness(self, surface: FacetOperator) -> Evenness:
        """Return how even a surface is; of a reduced state only the surface is lifted."""
        if not self.is_reduced:
            return surface.evenness(self.temperature)
        nodal = self.on(surface.all_nodes)
        return Evenness(self.reading(surface.mean_weights)[0], float(nodal.min()), float(nodal.max()))


class Trail(Sequence[Past]):
    """A list of states, to be appended to; ``room`` is how many bytes stay in memory.

    >>> import numpy as np
    >>> trail = Trail(room=40)
    >>> for k in range(4):
    ...     trail.append(State(float(k), np.full(2, 1.0 * k), np.zeros(2), np.zeros(2), np.ones(2)))
    >>> [state.temperature.tolist() for state in trail], trail.in_memory
    ([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]], 1)
    """

    def __init__(self, states: Sequence[State] = (), room: int = ROOM) -> None:
        self.times: list[float] = []
        self._room = room
        self._entries: list[tuple[Lift | None, Array | int, Array | None, int]] = []
        self._ends: list[State] = []
        self._first = self._held = 0
        self._file: IO[bytes] | None = None
        for state in states:
            self.append(state)

    def append(self, state: State, lift: Lift | None = None) -> None:
        """Add a state: nodal, or by coordinates that ``lift`` makes nodal."""
        self.times.append(state.time)
        self._ends = [*self._ends[-1:], state]
        self._entries.append((lift, state.temperature, state.slope, len(state.temperature)))
        self._held += _bytes(state.temperature, state.slope)
        while self._held > self._room and self._first < len(self._entries) - 1:
            self._put_away(self._first)
            self._first += 1

    def cut(self, count: int) -> None:
        """Forget all but the first ``count`` states; those must be in memory."""
        for _, first, second, _ in self._entries[count:]:
            assert not isinstance(first, int)
            self._held -= _bytes(first, second)
        del self.times[count:], self._entries[count:]
        self._ends = []

    @property
    def in_memory(self) -> int:
        """How many states are in memory."""
        return len(self._entries) - self._first

    def __len__(self) -> int:
        return len(self._entries)

    @overload
    def __getitem__(self, number: int) -> Past: ...
    @overload
    def __getitem__(self, number: slice) -> list[Past]: ...
    def __getitem__(self, number: int | slice) -> Past | list[Past]:
        if isinstance(number, slice):
            return [Past(self, i) for i in range(*number.indices(len(self)))]
        if not -len(self) <= number < len(self):
            raise IndexError(number)
        return Past(self, number % len(self))

    def whole(self, number: int) -> State:
        """Return one of the last two states with all that the step found."""
        return self._ends[number - len(self)]

    def entry(self, number: int) -> tuple[Lift | None, Array, Array | None]:
        """Return lift, temperatures or coordinates, and their rates, of a state."""
        lift, first, second, size = self._entries[number]
        if not isinstance(first, int):
            return lift, first, second
        assert self._file is not None
        self._file.seek(first)
        known = second is not None  # an empty array in the place of what the file has
        read = np.frombuffer(self._file.read(8 * size * (1 + known)))
        return lift, read[:size], read[size:] if known else None

    def extremes(self, nodes: Ints) -> tuple[float, float]:
        """Return the least and the greatest temperature that any of ``nodes`` ever had [degC]."""
        least, greatest = np.inf, -np.inf
        start = 0
        while start < len(self):
            lift, first, _ = self.entry(start)
            stop = start + 1
            if lift is None:
                found = first[nodes]
            else:
                columns = [first]
                while stop < min(len(self), start + BLOCK) and self._entries[stop][0] is lift:
                    columns.append(self.entry(stop)[1])
                    stop += 1
                part = lift.part(nodes)
                found = part.origin[:, None] + part.basis @ np.stack(columns, axis=1)
            least, greatest = min(least, float(found.min())), max(greatest, float(found.max()))
            start = stop
        return least, greatest

    def _put_away(self, number: int) -> None:
        lift, first, second, size = self._entries[number]
        assert not isinstance(first, int)
        if self._file is None:
            self._file = tempfile.TemporaryFile()  # noqa: SIM115 - it lasts as long as the states
        at = self._file.seek(0, 2)
        self._file.write(first.tobytes())
        if second is not None:
            self._file.write(second.tobytes())
        self._held -= _bytes(first, second)
        self._entries[number] = (lift, at, None if second is None else np.zeros(0), size)


def _bytes(first: Array, second: Array | None) -> int:
    return first.nbytes + (0 if second is None else second.nbytes)
