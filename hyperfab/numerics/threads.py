"""Blocks of independent work on the cores there are.

What is computed for an item must not depend on its block, nor may blocks add to a common sum: then the bits do not
depend on how many threads there are.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from queue import SimpleQueue
from threading import Lock, Thread, local
from typing import TypeVar

#: Environment variable that limits the threads of a process; workers of a study are given one each.
LIMIT = "HYPERFAB_THREADS"

T = TypeVar("T")

#: What is a thread's own: the unfinished pieces of the work it takes part in, and the threads that serve it.
_here = local()

#: Nodes that are worth a thread's while.
NODES = 5_000


def cores() -> int:
    """Return how many cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def threads() -> int:
    """Return how many threads may be used: as many as there are cores, or what ``LIMIT`` says; of a piece of work that
    is done side by side with others its share, which grows as those come to their end."""
    limit = os.environ.get(LIMIT, "")
    most = max(1, int(limit)) if limit.isdecimal() else cores()
    return max(1, most // max(1, len(getattr(_here, "unfinished", ()))))


def in_blocks(work: Callable[[int, int], None], count: int, block: int, most: int | None = None) -> None:
    """Call ``work(first, last)`` for items ``0:count`` in blocks of ``block``, side by side on ``most`` threads.

    Only compiled kernels run side by side. A signal is obeyed between blocks.

    >>> seen = [0] * 5
    >>> in_blocks(lambda first, last: seen.__setitem__(slice(first, last), [1] * (last - first)), 5, 2)
    >>> seen
    [1, 1, 1, 1, 1]
    """
    blocks = [(first, min(first + block, count)) for first in range(0, count, block)]
    others = min(threads() if most is None else most, len(blocks)) - 1
    if others < 1:
        for first, last in blocks:
            work(first, last)
        return
    left = iter(blocks)  # each next block goes to whoever is free: one call a thread, not one a block
    errors: list[BaseException] = []

    def take() -> None:
        for first, last in left:
            work(first, last)

    def beside(ended: Lock) -> None:
        try:
            take()
        except BaseException as error:  # noqa: BLE001 - raised below, in the thread that asked
            errors.append(error)
        finally:
            ended.release()

    waiting = [Lock() for _ in range(others)]
    asked = _crew(others)
    for ended in waiting:
        ended.acquire()
        asked.put(partial(beside, ended))
    try:
        take()
    finally:
        for _ in left:  # after an error or a signal nobody begins another block
            pass
        for ended in waiting:
            ended.acquire()
    if errors:
        raise errors[0]


def side_by_side(work: Sequence[Callable[[], T]]) -> list[T]:
    """Return what each piece of ``work`` returns, done side by side where there are threads.

    For pieces of a second and more that share nothing they change; each has its share of the threads to itself.

    >>> side_by_side([lambda: 1, lambda: 2])
    [1, 2]
    """
    found: list[T | None] = [None] * len(work)
    unfinished = list(range(len(work)))

    def one(number: int) -> None:
        around, _here.unfinished = getattr(_here, "unfinished", ()), unfinished
        try:
            found[number] = work[number]()
        finally:
            unfinished.remove(number)
            _here.unfinished = around

    if min(threads(), len(work)) < 2:
        return [piece() for piece in work]
    in_blocks(lambda first, _: one(first), len(work), 1)
    return found  # type: ignore[return-value]


def in_rows(work: Callable[[int, int], None], rows: int, columns: int) -> None:
    """Call ``work(first, last)`` for the rows of a grid in blocks of some ``NODES`` nodes, side by side.

    Where a node's sum takes from the row before, the block computes that row's part anew: then the order of the
    additions, and with it the bits, do not depend on the blocks either.
    """
    most = for_nodes(rows * columns)
    if most == 1:
        work(0, rows)
    else:
        in_blocks(work, rows, max(1, min(NODES // columns, rows // (4 * most))), most)


def for_nodes(count: int) -> int:
    """Return how many threads so many nodes are worth."""
    return threads() if count >= NODES else 1


def _crew(number: int) -> SimpleQueue[Callable[[], None]]:
    """Threads that stay, and do what is put into the queue: an executor's futures take as long again as a wake-up.

    Each thread that asks has its own, so that none waits for one that waits for it.
    """
    crews = _here.__dict__.setdefault("crews", {})
    if number not in crews:
        asked: SimpleQueue[Callable[[], None]] = SimpleQueue()
        crews[number] = asked

        def serve() -> None:
            while True:
                asked.get()()

        for _ in range(number):
            Thread(target=serve, daemon=True).start()
    found: SimpleQueue[Callable[[], None]] = crews[number]
    return found
