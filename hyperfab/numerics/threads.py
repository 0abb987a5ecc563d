"""Blocks of independent work on the cores there are.

What is computed for an item must not depend on its block, nor may blocks add to a common sum: then the bits do not
depend on how many threads there are.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

#: Environment variable that limits the threads of a process; workers of a study are given one each.
LIMIT = "HYPERFAB_THREADS"


def cores() -> int:
    """Return how many cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def threads() -> int:
    """Return how many threads may be used: as many as there are cores, or what ``LIMIT`` says."""
    limit = os.environ.get(LIMIT, "")
    return max(1, int(limit)) if limit.isdecimal() else cores()


def in_blocks(work: Callable[[int, int], None], count: int, block: int) -> None:
    """Call ``work(first, last)`` for items ``0:count`` in blocks of ``block``, side by side.

    Only compiled kernels run side by side. A signal is obeyed between blocks.

    >>> seen = [0] * 5
    >>> in_blocks(lambda first, last: seen.__setitem__(slice(first, last), [1] * (last - first)), 5, 2)
    >>> seen
    [1, 1, 1, 1, 1]
    """
    blocks = [(first, min(first + block, count)) for first in range(0, count, block)]
    number = min(threads(), len(blocks))
    if number <= 1:
        for first, last in blocks:
            work(first, last)
        return
    with ThreadPoolExecutor(number) as pool:
        waiting = [pool.submit(work, first, last) for first, last in blocks]
        try:
            for one in waiting:
                one.result()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise
