"""Sparse matrices of small dense blocks, of which some rows and columns are held fixed.

The pattern is found once; new values only have to be copied into place.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.dissection import dissect
from hyperfab.numerics.kernels import kernel
from hyperfab.numerics.linear import DirectSolver
from hyperfab.numerics.multifrontal import Elimination
from hyperfab.numerics.vectors import rows

Index = NDArray[np.int32]

#: From so many elements on they are divided into so many batches to be added up side by side.
_MANY, _BATCHES = 4000, 8


class BlockPattern:
    """The pattern of a matrix that couples the nodes of each element through ``size`` × ``size`` blocks.

    ``elements`` (m, a) are node numbers below ``nodes``; ``free`` (nodes, size) marks the unknowns that stay.
    ``points`` (nodes, d), where given, are their places: neighbours are then eliminated together (``solver``).
    ``block_of`` (m, a, a) is the block of each pair of element nodes, ``diagonal`` (nodes,) that of each node,
    ``rows`` and ``columns`` (blocks,) the nodes whose rows and columns a block belongs to.

    >>> free = np.array([[False], [True], [True]])
    >>> pattern = BlockPattern(np.array([[0, 1], [1, 2]]), 3, free)
    >>> blocks = np.ones((pattern.blocks, 1, 1))
    >>> pattern.matrix(blocks).toarray()
    array([[1., 1.],
           [1., 1.]])
    """

    def __init__(self, elements: Ints, nodes: int, free: NDArray[np.bool_], points: Array | None = None) -> None:
        self._elements, self._points = elements, points
        count, shapes = elements.shape
        rows = np.repeat(elements, shapes, axis=1).ravel()
        columns = np.tile(elements, (1, shapes)).ravel()
        keys, inverse = np.unique(rows * nodes + columns, return_inverse=True)
        self.blocks = len(keys)
        self.rows: Ints = keys // nodes
        self.columns: Ints = keys % nodes
        self.block_of: Ints = inverse.reshape(count, shapes, shapes).astype(np.int64)
        self.diagonal: Ints = np.searchsorted(keys, np.arange(nodes) * (nodes + 1)).astype(np.int64)
        self.free = free
        self.size = free.shape[1]
        self._index(self.rows, self.columns, nodes)

    @property
    def unknowns(self) -> int:
        """Number of rows of the matrix."""
        return int(self.free.sum())

    @cached_property
    def solver(self) -> DirectSolver:
        """Factorises matrices of this pattern."""
        return DirectSolver(None if self._points is None else lambda: self.elimination)

    @cached_property
    def elimination(self) -> Elimination:
        """The plan of an elimination front by front; ValueError where the places of the nodes are not known."""
        if self._points is None:
            raise ValueError("the places of the nodes are not known")
        columns = np.repeat(np.arange(self.unknowns), np.diff(self._indptr))
        return Elimination(dissect(self._elements, self._points, self.free), self._indices, columns)

    @cached_property
    def batches(self) -> list[Ints]:
        """The elements, by number: batches that share no node, and last those between them."""
        count = len(self._elements)
        if self._points is None or count < _MANY:
            return [np.arange(count)]
        along = self._points[self._elements, 0].mean(axis=1)
        batch = np.empty(count, np.int64)
        batch[np.argsort(along, kind="stable")] = np.arange(count) * _BATCHES // count
        lowest, highest = np.full(len(self.free), _BATCHES), np.zeros(len(self.free), np.int64)
        np.minimum.at(lowest, self._elements, batch[:, None])
        np.maximum.at(highest, self._elements, batch[:, None])
        batch[(lowest < highest)[self._elements].any(axis=1)] = _BATCHES
        return [np.flatnonzero(batch == k) for k in range(_BATCHES + 1)]

    def release(self) -> None:
        """Free the memory of the elimination; it is planned anew where it is needed again."""
        self.__dict__.pop("elimination", None)

    def _index(self, rows: Ints, columns: Ints, nodes: int) -> None:
        """Find, for each entry of the compressed columns, its place in the array of blocks."""
        number = np.where(self.free, np.cumsum(self.free.ravel()).reshape(self.free.shape) - 1, -1)
        by_column = np.argsort(columns, kind="stable")
        entries = int((self.free[rows].sum(axis=1) * self.free[columns].sum(axis=1)).sum())
        self._source, self._indices, self._indptr = _compressed(
            rows[by_column], columns[by_column], by_column, number, self.unknowns, entries
        )

    def matrix(self, blocks: Array) -> sparse.csc_matrix:
        """Return the matrix of the free unknowns for block values (blocks, size, size)."""
        n = self.unknowns
        return sparse.csc_matrix((rows(blocks.ravel(), self._source), self._indices, self._indptr), shape=(n, n))

    def restrict(self, values: Array) -> Array:
        """Return the free entries of nodal values (nodes, size), as a vector."""
        return np.asarray(values[self.free])

    def extend(self, vector: Array) -> Array:
        """Return nodal values (nodes, size) with zeros where the unknowns are fixed."""
        values = np.zeros(self.free.shape)
        values[self.free] = vector
        return values


@kernel
def _compressed(
    rows: Ints, columns: Ints, blocks: Ints, number: Ints, unknowns: int, entries: int
) -> tuple[Ints, Index, Index]:
    """Return source, row and start of the compressed columns for ``blocks`` (k,) in order of column, then row.

    ``number`` (nodes, size) of the unknowns, -1 where there is none.
    """
    size = number.shape[1]
    source = np.empty(entries, np.int64)
    indices = np.empty(entries, np.int32)
    starts = np.zeros(unknowns + 1, np.int32)
    count, first = 0, 0
    while first < len(blocks):
        last = first
        while last < len(blocks) and columns[last] == columns[first]:
            last += 1
        for j in range(size):
            column = number[columns[first], j]
            if column < 0:
                continue
            for k in range(first, last):
                for i in range(size):
                    row = number[rows[k], i]
                    if row >= 0:
                        source[count] = (blocks[k] * size + i) * size + j
                        indices[count] = row
                        count += 1
            starts[column + 1] = count
        first = last
    return source, indices, starts
