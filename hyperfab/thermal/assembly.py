"""One sparsity pattern for all matrices of a mesh, and the scatter of element matrices into it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from hyperfab.arrays import Array, Ints
from hyperfab.numerics.kernels import inlined, kernel


class Pattern:
    """The compressed rows that all matrices of a mesh share, so that they add by their data arrays alone.

    ``blocks`` are node lists (m, k): every two nodes of a row are coupled.

    >>> import numpy as np
    >>> p = Pattern(3, [np.array([[0, 1], [1, 2]])])
    >>> p.matrix(p.scatter(np.array([[0, 1], [1, 2]]), np.ones((2, 2, 2)))).toarray()
    array([[1., 1., 0.],
           [1., 2., 1.],
           [0., 1., 1.]])
    """

    def __init__(self, size: int, blocks: Sequence[Ints]) -> None:
        self.size = size
        pieces = []
        for block in blocks:
            m, k = block.shape
            rows = np.repeat(np.arange(m, dtype=np.int32), k)
            ones = np.ones(m * k, dtype=np.int8)
            pieces.append(sparse.csr_matrix((ones, (rows, block.ravel().astype(np.int32))), shape=(m, size)))
        incidence = sparse.vstack(pieces, format="csr").astype(bool)
        found = sparse.csr_matrix(incidence.T @ incidence)
        found.sort_indices()
        self.indptr = found.indptr.astype(np.int32)
        self.indices = found.indices.astype(np.int32)

    @property
    def entries(self) -> int:
        """Number of stored entries."""
        return len(self.indices)

    def scatter(self, nodes: Ints, blocks: Array, out: Array | None = None) -> Array:
        """Add the matrices ``blocks`` (m, k, k) of the node lists (m, k) to a data array (``out``, or zeros)."""
        data = np.zeros(self.entries) if out is None else out
        _scatter(self.indptr, self.indices, nodes.astype(np.int64), np.ascontiguousarray(blocks), data)
        return data

    def places(self, nodes: Ints) -> NDArray[np.int32]:
        """Return where the matrices of node lists (m, k) come to stand (m k k,), for lists scattered often: ``add``."""
        found = np.empty(nodes.size * nodes.shape[1], np.int32)
        _find(self.indptr, self.indices, nodes.astype(np.int64), found)
        return found

    @cached_property
    def _of_diagonal(self) -> Ints:
        rows = np.repeat(np.arange(self.size), np.diff(self.indptr))
        return np.flatnonzero(rows == self.indices)

    def diagonal(self, matrix: sparse.csr_matrix) -> Array:
        """Return the diagonal of a matrix of this pattern: each place is known, none is looked for."""
        return np.asarray(matrix.data[self._of_diagonal])

    def matrix(self, data: Array) -> sparse.csr_matrix:
        """Return the matrix with these entries; pattern and data are shared, not copied."""
        return sparse.csr_matrix((data, self.indices, self.indptr), shape=(self.size, self.size), copy=False)


@inlined
def _place(indices, low, high, column):  # type: ignore[no-untyped-def]
    """Return where ``column`` is in a sorted row from ``low`` to ``high``."""
    while low < high:
        middle = (low + high) // 2
        if indices[middle] < column:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _scatter(indptr, indices, nodes, blocks, data):  # type: ignore[no-untyped-def]
    m, k = nodes.shape
    for e in range(m):
        for i in range(k):
            row = nodes[e, i]
            for j in range(k):
                data[_place(indices, indptr[row], indptr[row + 1] - 1, nodes[e, j])] += blocks[e, i, j]


@kernel
def _find(indptr, indices, nodes, places):  # type: ignore[no-untyped-def]
    m, k = nodes.shape
    for e in range(m):
        for i in range(k):
            row = nodes[e, i]
            for j in range(k):
                found = _place(indices, indptr[row], indptr[row + 1] - 1, nodes[e, j])
                places[(e * k + i) * k + j] = found


@kernel
def add(places: NDArray[np.int32], entries: Array, data: Array) -> None:
    """Add entries (p,) to a data array at their ``Pattern.places`` (p,)."""
    for i in range(len(places)):
        data[places[i]] += entries[i]
