"""Nested dissection of a mesh: the order in which unknowns are eliminated, and the dense fronts this is done in.

The elements are halved again and again across their longest extent. A node between two halves waits until both are
done; a node inside a piece goes with that piece (George, SIAM J. Numer. Anal. 10 (1973) 345, on elements). Elements
along a cut change sides where fewer nodes then lie between the halves (the idea of Fiduccia and Mattheyses, 19th Design
Automation Conference (1982) 175): it saves a third of the work of the factorisation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import kernel

#: Elements that are not divided any more.
_LEAF = 16


@dataclass(frozen=True)
class Dissection:
    """The order of elimination and its fronts, children before parents.

    ``order`` (unknowns,) lists the unknowns, first eliminated first. Front f eliminates ``firsts[f]:firsts[f + 1]`` of
    that order and is tied to the later ones ``rest[rest_starts[f]:rest_starts[f + 1]]``, ascending; ``above`` is the
    place of each of these in the front above. ``children`` (fronts, 2) are the fronts below it, or -1.
    """

    order: Ints
    firsts: Ints
    rest_starts: Ints
    rest: Ints
    above: Ints
    children: Ints


def dissect(elements: Ints, points: Array, free: NDArray[np.bool_]) -> Dissection:
    """Dissect a mesh of ``elements`` (m, a) between nodes at ``points`` (n, d); ``free`` (n, s) are the unknowns.

    >>> free = np.ones((3, 1), bool)
    >>> dissect(np.array([[0, 1], [1, 2]]), np.array([[0.0], [1.0], [2.0]]), free).order
    array([0, 1, 2])
    """
    levels = max(0, int(np.ceil(np.log2(len(elements) / _LEAF))))
    piece = _pieces(elements, points, levels)
    first = np.full(len(points), 1 << levels, np.int64)
    last = np.full(len(points), -1, np.int64)
    np.minimum.at(first, elements, piece[:, None])
    np.maximum.at(last, elements, piece[:, None])
    first = np.minimum(first, np.maximum(last, 0))
    # Pieces are leaves of a binary tree in order: a node belongs to the lowest branch that holds all its pieces.
    _, height = np.frexp((first ^ np.maximum(last, 0)).astype(float))
    branch = (1 << (levels - height)) + (first >> height)
    turn = np.empty(2 << levels, np.int64)
    walk = _children_first(levels)
    turn[walk] = np.arange(len(walk))
    unknown_turn = np.repeat(turn[branch], free.shape[1])[free.ravel()]
    order = np.argsort(unknown_turn, kind="stable")
    ends = np.concatenate([[0], np.cumsum(np.bincount(unknown_turn, minlength=len(walk)))])
    number = np.full(free.size, -1, np.int64)
    number[np.flatnonzero(free.ravel())[order]] = np.arange(len(order))
    numbers = number.reshape(free.shape)
    by_piece = np.argsort(piece, kind="stable")
    bounds = np.searchsorted(piece[by_piece], np.arange((1 << levels) + 1))
    children = np.full((len(walk), 2), -1)
    inner = walk < 1 << levels
    children[inner] = turn[2 * walk[inner, None] + np.arange(2)]
    of_piece = numbers[elements[by_piece]].reshape(len(elements), -1)
    starts, rest, above = _ties(children, ends, of_piece, bounds)
    return Dissection(order, ends, starts, rest, above, children)


@kernel
def _ties(children: Ints, firsts: Ints, unknowns: Ints, bounds: Ints) -> tuple[Ints, Ints, Ints]:
    """Return where the ties of each front begin, which unknowns they are, and their places in the front above.

    ``unknowns`` (m, k) of the elements (-1 where there is none), leaf by leaf, those of each from ``bounds`` on.
    """
    starts = np.zeros(len(children) + 1, np.int64)
    rest, above = np.empty(unknowns.size, np.int64), np.empty(unknowns.size, np.int64)
    seen = np.full(firsts[-1], -1)
    leaf = 0
    for f in range(len(children)):
        begin, end, start = firsts[f], firsts[f + 1], starts[f]
        left, right = children[f]
        if left < 0:
            most = unknowns[bounds[leaf] : bounds[leaf + 1]].size
        else:
            most = starts[left + 1] - starts[left] + starts[right + 1] - starts[right]
        if start + most > len(rest):
            rest = np.concatenate((rest, np.empty(len(rest) + most, np.int64)))
            above = np.concatenate((above, np.empty(len(above) + most, np.int64)))
        stop = start
        if left < 0:
            for number in unknowns[bounds[leaf] : bounds[leaf + 1]].ravel():
                if number >= end and seen[number] != f:
                    seen[number], rest[stop] = f, number
                    stop += 1
            rest[start:stop].sort()
            leaf += 1
        else:
            i, j, i_end, j_end = starts[left], starts[right], starts[left + 1], starts[right + 1]
            while i < i_end or j < j_end:
                one = rest[i] if i < i_end else firsts[-1]
                other = rest[j] if j < j_end else firsts[-1]
                number = min(one, other)
                place = number - begin if number < end else end - begin + stop - start
                if one == number:
                    above[i] = place
                    i += 1
                if other == number:
                    above[j] = place
                    j += 1
                if number >= end:
                    rest[stop] = number
                    stop += 1
        starts[f + 1] = stop
    return starts, rest[: starts[-1]].copy(), above[: starts[-1]].copy()


def _pieces(elements: Ints, points: Array, levels: int) -> Ints:
    """Return the piece of each element: halved ``levels`` times across the direction of largest spread."""
    centres = points[elements].mean(axis=1)
    piece = np.zeros(len(centres), np.int64)
    between = np.zeros(len(points), bool)
    for level in range(levels):
        count = np.bincount(piece, minlength=1 << level)
        mean = _sums(piece, centres, 1 << level) / np.maximum(count, 1)[:, None]
        away = centres - mean[piece]
        spread = _sums(piece, (away[:, :, None] * away[:, None, :]).reshape(len(away), -1), 1 << level)
        _, directions = np.linalg.eigh(spread.reshape(1 << level, centres.shape[1], centres.shape[1]))
        along = (away * directions[piece, :, -1]).sum(axis=1)
        sorted_ = np.lexsort((along, piece))
        start = np.concatenate([[0], np.cumsum(count)[:-1]])
        rank = np.empty_like(piece)
        rank[sorted_] = np.arange(len(piece)) - start[piece[sorted_]]
        half = (rank >= (count[piece] + 1) // 2).astype(np.int64)
        _straighten(elements, half, between)
        piece = 2 * piece + half
    return piece


@kernel
def _straighten(elements: Ints, half: Ints, between: NDArray[np.bool_]) -> None:
    """Let elements change ``half`` (m,) where fewer nodes then lie between halves, and mark those in ``between`` (n,).

    Nodes that are marked already lie between larger pieces and count no more.
    """
    around = np.zeros((len(between), 2), np.int64)
    for e in range(len(elements)):
        for node in elements[e]:
            around[node, half[e]] += 1
    for e in range(len(elements)):
        own = half[e]
        gain = 0
        for node in elements[e]:
            if not between[node]:
                mine, others = around[node, own], around[node, 1 - own]
                if mine == 1 and others > 0:
                    gain += 1
                elif mine > 1 and others == 0:
                    gain -= 1
        if gain > 0:
            half[e] = 1 - own
            for node in elements[e]:
                around[node, own] -= 1
                around[node, 1 - own] += 1
    for node in range(len(between)):
        if around[node, 0] > 0 and around[node, 1] > 0:
            between[node] = True


def _sums(piece: Ints, values: Array, pieces: int) -> Array:
    return np.column_stack([np.bincount(piece, column, pieces) for column in values.T])


def _children_first(levels: int) -> Ints:
    """Return the branches of a binary tree (1 the root, 2 k and 2 k + 1 below k), children before parents."""
    walk: Ints = np.array([1], np.int64)
    for _ in range(levels):
        # A branch at the end of each of its halves' walks: shift the walk below the root into both halves.
        depth = np.frexp(walk.astype(float))[1] - 1
        left, right = walk + (1 << depth), walk + (2 << depth)
        walk = np.concatenate([left, right, [1]])
    return walk
