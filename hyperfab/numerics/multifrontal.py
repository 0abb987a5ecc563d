"""Cholesky's factorisation of a symmetric positive definite matrix on a mesh, front by front (multifrontal).

Each front of a nested dissection is a small dense matrix: its pivots are eliminated by LAPACK, and what remains goes
into the front above (Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302). Twice to four times as fast as a general
sparse LU where the mesh is known. Branches of the dissection do not touch each other: they are worked side by side on
the cores there are, and the bits do not depend on how many.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.dissection import Dissection
from hyperfab.numerics.kernels import kernel, part
from hyperfab.numerics.lapack import addresses, call_routine
from hyperfab.numerics.threads import in_blocks

Numbers = NDArray[np.int32] | NDArray[np.int64]

#: Branches that are worked side by side; above them, front by front of a level.
_BRANCHES = 16
#: Entries of a factor from which threads are worth their while.
_LARGE = 300_000


class NotPositiveDefiniteError(ArithmeticError):
    """The matrix is symmetric, but not positive definite."""


class Fronts(NamedTuple):
    """The fronts of a dissection, children before parents, as arrays with one number a front.

    ``firsts``, ``pivots``: its unknowns, in the order of elimination; ``rests``: how many later ones it is tied to,
    which are ``rest[rest_starts[f]:]``, and there ``above`` is the place of each in the front above. ``starts``:
    where its panel begins in the factor (pivots × pivots, then rest × pivots, by columns), ``entries[f:f + 2]``:
    which entries of the matrix go there. ``children[child_starts[f]:child_starts[f + 1]]`` are the fronts below.
    What remains of it (rest × rest) is worked out in the room from ``worked`` on and kept from ``kept`` on.
    """

    firsts: Ints
    pivots: Ints
    rests: Ints
    starts: Ints
    rest_starts: Ints
    rest: Ints
    above: Ints
    child_starts: Ints
    children: Ints
    worked: Ints
    kept: Ints
    entries: Ints


class Elimination:
    """Where everything goes when a matrix with a known pattern is factorised in a known order.

    ``rows`` and ``columns`` (k,) of the entries, of which those below the diagonal count.
    """

    def __init__(self, dissection: Dissection, rows: Numbers, columns: Numbers) -> None:
        self.order, firsts, rest_starts = dissection.order, dissection.firsts[:-1], dissection.rest_starts
        pivots, rests = np.diff(dissection.firsts), np.diff(rest_starts)
        starts = _sums(pivots * (pivots + rests))
        number = np.empty(len(self.order), np.int64)
        number[self.order] = np.arange(len(self.order))
        owner = np.repeat(np.arange(len(pivots)), pivots)
        #: Entries of the matrix, by number, and where each stands in the factor, front by front.
        self.source, self.target, entries = _places(
            rows, columns, number, owner, firsts, pivots, starts, rest_starts, dissection.rest
        )
        #: Ranges of fronts: those of one stage do not touch each other, and come after all of the stages before.
        inner = dissection.children[:, 0] >= 0
        children = [tuple(pair) if has else () for pair, has in zip(dissection.children.tolist(), inner, strict=True)]
        self.stages = _stages(children, int(starts[-1]))
        worked, kept, self._room = _stacked(children, rests, self.stages)
        self.fronts = Fronts(
            firsts,
            pivots,
            rests,
            starts,
            rest_starts,
            dissection.rest,
            dissection.above,
            _sums(2 * inner),
            dissection.children[inner].ravel(),
            worked,
            kept,
            entries,
        )

    @property
    def size(self) -> int:
        """Entries of the factor."""
        return int(self.fronts.starts[-1])

    @cached_property
    def space(self) -> Array:
        """Room for one factor, used again for the next: fresh memory costs a tenth of the time."""
        return np.empty(self.size)

    @cached_property
    def room(self) -> Array:
        """Room for what remains of fronts."""
        return np.empty(self._room)

    def upwards(self, work: Callable[[int, int], None]) -> None:
        """Call ``work(first, last)`` for all fronts, children before parents."""
        for stage in self.stages:
            _side_by_side(work, stage)

    def downwards(self, work: Callable[[int, int], None]) -> None:
        """Call ``work(first, last)`` for all fronts, parents before children; within a range it goes downwards."""
        for stage in self.stages[::-1]:
            _side_by_side(work, stage)


class CholeskyFactor:
    """A factorised matrix: ``values`` (k,) of the entries that the elimination was planned for.

    It stands in the room of its plan until the next is factorised. Raises NotPositiveDefiniteError.
    """

    def __init__(self, plan: Elimination, values: Array) -> None:
        self.plan = plan
        self.factor = plan.space
        failed: list[int] = []

        def work(first: int, last: int) -> None:
            words = np.zeros(5, np.int32)
            if not failed and _eliminate(
                plan.fronts, plan.source, plan.target, values, self.factor, plan.room, words, _LETTERS, _NUMBERS,
                _routines(), first, last,
            ):  # fmt: skip
                failed.append(first)

        plan.upwards(work)
        if failed:
            raise NotPositiveDefiniteError("a pivot is not positive")

    def solve(self, right: Array) -> Array:
        """Return x with A x = right (n,)."""
        plan = self.plan
        values, carried = right[plan.order], np.empty(len(plan.fronts.rest))
        plan.upwards(lambda first, last: _forwards(plan.fronts, self.factor, values, carried, first, last))
        plan.downwards(lambda first, last: _backwards(plan.fronts, self.factor, values, first, last))
        found = np.empty_like(values)
        found[plan.order] = values
        return found


def _sums(counts: Ints) -> Ints:
    """Return where each of ``counts`` begins, and where the last ends."""
    return np.concatenate([[0], np.cumsum(counts)])


def _side_by_side(work: Callable[[int, int], None], ranges: list[tuple[int, int]]) -> None:
    in_blocks(lambda first, _: work(*ranges[first]), len(ranges), 1)


def _stages(children: list[tuple[int, ...]], size: int) -> list[list[tuple[int, int]]]:
    """Return ranges of fronts that may be worked side by side, stage after stage: branches, then the levels above.

    A factor of few entries (``size``) is one range: a thread takes longer to begin than its share to be worked.
    """
    levels = [[len(children) - 1]]
    while size >= _LARGE and len(levels[-1]) < _BRANCHES and all(children[front] for front in levels[-1]):
        levels.append([child for front in levels[-1] for child in children[front]])
    branches = []
    for front in levels[-1]:
        first = front
        while children[first]:
            first = children[first][0]
        branches.append((first, front + 1))
    return [branches, *([(front, front + 1) for front in level] for level in levels[-2::-1])]


def _stacked(
    children: list[tuple[int, ...]], rests: Ints, stages: list[list[tuple[int, int]]]
) -> tuple[Ints, Ints, int]:
    """Return where what remains of each front is worked out and kept, and how much room that takes.

    A branch has a stack of its own: what remains of a front takes the place of what remained of those below it.
    """
    worked, kept = np.zeros(len(children), np.int64), np.zeros(len(children), np.int64)
    end = 0
    for ranges in stages:
        for first, last in ranges:
            top = end
            for front in range(first, last):
                inside = [child for child in children[front] if child >= first]
                worked[front] = top
                end = max(end, top + int(rests[front]) ** 2)
                kept[front] = kept[inside[0]] if inside else top
                top = int(kept[front]) + int(rests[front]) ** 2
    return worked, kept, end


#: What LAPACK and BLAS are told by letters and numbers, one after another: see ``_eliminate``.
_LETTERS = np.frombuffer(b"LRTN", np.uint8).copy()
_NUMBERS = np.array([1.0, -1.0])


@cache
def _routines() -> Ints:
    return addresses("dpotrf", "dtrsm", "dsyrk")


@kernel
def _places(
    rows: Numbers,
    columns: Numbers,
    number: Ints,
    owner: Ints,
    firsts: Ints,
    pivots: Ints,
    starts: Ints,
    rest_starts: Ints,
    all_rests: Ints,
) -> tuple[Ints, Ints, Ints]:
    """Return which entries lie on or below the diagonal in the new order, and where they stand in the factor.

    They come front by front; the third array (fronts + 1,) says where those of each begin.
    """
    entries = np.zeros(len(pivots) + 1, np.int64)
    for k in range(len(rows)):
        if number[rows[k]] >= number[columns[k]]:
            entries[owner[number[columns[k]]] + 1] += 1
    entries = np.cumsum(entries)
    source, target = np.empty(entries[-1], np.int64), np.empty(entries[-1], np.int64)
    free = entries[:-1].copy()
    for k in range(len(rows)):
        i, j = number[rows[k]], number[columns[k]]
        if i < j:
            continue
        front = owner[j]
        p = pivots[front]
        row, column = i - firsts[front], j - firsts[front]
        if row < p:
            place = column * p + row
        else:
            rest = all_rests[rest_starts[front] : rest_starts[front + 1]]
            place = p * p + column * len(rest) + np.searchsorted(rest, i)
        source[free[front]], target[free[front]] = k, starts[front] + place
        free[front] += 1
    return source, target, entries


@kernel
def _eliminate(
    fronts: Fronts,
    source: Ints,
    target: Ints,
    values: Array,
    factor: Array,
    room: Array,
    words: NDArray[np.int32],
    letters: NDArray[np.uint8],
    numbers: Array,
    routines: Ints,
    first: int,
    last: int,
) -> bool:
    """Factorise the fronts ``first:last``; return whether a pivot is not positive.

    ``words`` (5,) is room for pivots, rest, leading dimensions and LAPACK's answer.
    """
    lower, one, word = letters.ctypes.data, numbers.ctypes.data, words.ctypes.data
    right, turned, plain, minus_one = lower + 1, lower + 2, lower + 3, one + 8
    count, rest, lead, lead_low, answer = word, word + 4, word + 8, word + 12, word + 16
    at, room_at = factor.ctypes.data, room.ctypes.data
    for f in range(first, last):
        p, b = fronts.pivots[f], fronts.rests[f]
        start, left = fronts.starts[f], fronts.worked[f]
        factor[start : fronts.starts[f + 1]] = 0.0
        for k in range(fronts.entries[f], fronts.entries[f + 1]):
            factor[target[k]] = values[source[k]]
        room[left : left + b * b] = 0.0
        for k in range(fronts.child_starts[f], fronts.child_starts[f + 1]):
            _add(fronts, fronts.children[k], factor, room, start, left, p, b)
        words[0], words[1], words[2], words[3], words[4] = p, b, max(p, 1), max(b, 1), 0
        top, low = at + 8 * start, at + 8 * (start + p * p)
        if p:
            call_routine(routines[0], (lower, count, top, lead, answer))
            if words[4] != 0:
                return True
        if p and b:
            call_routine(routines[1], (right, lower, turned, plain, rest, count, one, top, lead, low, lead_low))
            call_routine(
                routines[2],
                (lower, plain, rest, count, minus_one, low, lead_low, one, room_at + 8 * left, lead_low),
            )
        if fronts.kept[f] != left:
            for k in range(b * b):
                room[fronts.kept[f] + k] = room[left + k]
    return False


@part
def _add(fronts: Fronts, child: int, factor: Array, room: Array, start: int, left: int, p: int, b: int) -> None:
    """Add what remains of a child (lower triangle) to the three parts of its parent's front."""
    count, place = fronts.rests[child], fronts.above[fronts.rest_starts[child] :]
    for j in range(count):
        column, from_ = place[j], fronts.kept[child] + j * count
        if column < p:
            top, low = start + column * p, start + p * p + column * b - p
            for i in range(j, count):
                row = place[i]
                factor[(top if row < p else low) + row] += room[from_ + i]
        else:
            into = left + (column - p) * b - p
            for i in range(j, count):
                room[into + place[i]] += room[from_ + i]


@kernel
def _forwards(fronts: Fronts, factor: Array, values: Array, carried: Array, first: int, last: int) -> None:
    """Solve with the factor of the fronts ``first:last``, in place; ``carried`` goes to the front above."""
    for f in range(first, last):
        begin, p, b = fronts.firsts[f], fronts.pivots[f], fronts.rests[f]
        on = carried[fronts.rest_starts[f] : fronts.rest_starts[f + 1]]
        on[:] = 0.0
        for k in range(fronts.child_starts[f], fronts.child_starts[f + 1]):
            child = fronts.children[k]
            for i in range(fronts.rest_starts[child], fronts.rest_starts[child + 1]):
                place = fronts.above[i]
                if place < p:
                    values[begin + place] += carried[i]
                else:
                    on[place - p] += carried[i]
        for j in range(p):
            top = fronts.starts[f] + j * p
            x = values[begin + j] / factor[top + j]
            values[begin + j] = x
            for i in range(j + 1, p):
                values[begin + i] -= factor[top + i] * x
            low = fronts.starts[f] + p * p + j * b
            for i in range(b):
                on[i] -= factor[low + i] * x


@kernel
def _backwards(fronts: Fronts, factor: Array, values: Array, first: int, last: int) -> None:
    """Solve with the factor's transpose of the fronts ``first:last``, the last first, in place."""
    for f in range(last - 1, first - 1, -1):
        begin, p, b = fronts.firsts[f], fronts.pivots[f], fronts.rests[f]
        rest = fronts.rest[fronts.rest_starts[f] : fronts.rest_starts[f + 1]]
        for j in range(p - 1, -1, -1):
            top = fronts.starts[f] + j * p
            low = fronts.starts[f] + p * p + j * b
            x = values[begin + j]
            for i in range(b):
                x -= factor[low + i] * values[rest[i]]
            for i in range(j + 1, p):
                x -= factor[top + i] * values[begin + i]
            values[begin + j] = x / factor[top + j]
