"""Sweeps in which a node waits for those before it, on the cores there are and with the bits of one.

A node takes from its neighbours in the row before, up to the next column, and from the node before it in its own row.
Bands of rows are handed out in their order, and each is swept piece by piece, behind the band before it: every node
finds what it would find in a sweep of one thread. A kernel that sweeps does::

    first = next_band(done)
    while first < rows:
        for start in range(0, columns + BAND, PIECE):
            follow(done, first, start + PIECE, columns)
            # rows first to first + BAND; columns start to start + PIECE, a column less for each further row
            tell(done, first, start + PIECE)
        first = next_band(done)

A band waits for one that a thread is at already, so that any number of threads comes to the end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from hyperfab.arrays import Ints
from hyperfab.numerics.kernels import inlined
from hyperfab.numerics.threads import for_nodes, in_blocks

#: Rows of a band, and columns that are swept at once; BAND is at most PIECE.
BAND, PIECE = 8, 32

# What one thread writes another reads: as memory that is shared, in its order.
# https://llvm.org/docs/Atomics.html


def _add_one(typing: Any, array: Any, index: Any) -> Any:
    """Add one to a place of an array, and return what was there."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        one = context.get_constant(types.int64, 1)
        place = builder.gep(context.make_array(sig.args[0])(context, builder, args[0]).data, [args[1]])
        return builder.atomic_rmw("add", place, one, "acq_rel")

    return types.int64(array, types.intp), code


def _read(typing: Any, array: Any, index: Any) -> Any:
    """Return what is at a place of an array: all that was written before it was, is seen too."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.gep(context.make_array(sig.args[0])(context, builder, args[0]).data, [args[1]])
        return builder.load_atomic(place, "acquire", 8)

    return types.int64(array, types.intp), code


def _write(typing: Any, array: Any, index: Any, value: Any) -> Any:
    """Write to a place of an array, after all that was written before."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.gep(context.make_array(sig.args[0])(context, builder, args[0]).data, [args[1]])
        builder.store_atomic(args[2], place, "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), code


add_one: Any = intrinsic(_add_one)
read: Any = intrinsic(_read)
write: Any = intrinsic(_write)


@inlined
def next_band(done: Ints) -> Any:
    """Return the first row of a band that nobody has begun."""
    return add_one(done, 0) * BAND


@inlined
def follow(done: Ints, first: int, end: int, columns: int) -> None:
    """Wait until the band before that of row ``first`` is past column ``end`` in its last row."""
    if first > 0:
        while read(done, first // BAND) < min(end, columns) + BAND:
            pass


@inlined
def tell(done: Ints, first: int, end: int) -> None:
    """Say that the band of row ``first`` is swept up to column ``end`` in its first row."""
    write(done, first // BAND + 1, end)


def in_bands(sweep: Callable[[Ints], None], rows: int, columns: int) -> None:
    """Call ``sweep(done)`` on the cores there are, for a grid; ``done`` keeps account of its bands."""
    done = np.zeros(2 + rows // BAND, np.int64)
    most = for_nodes(rows * columns)
    in_blocks(lambda *_: sweep(done), most, 1, most)
