"""Work side by side: every piece once, in its place, with its share of the threads, and an error that is not lost."""

from __future__ import annotations

import time
from functools import partial
from threading import Barrier, get_ident

import pytest

from hyperfab.numerics.threads import LIMIT, in_blocks, side_by_side, threads


@pytest.mark.parametrize("most", ["1", "2", "3"])
def test_each_piece_has_its_place(most: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LIMIT, most)

    def piece(number: int) -> tuple[int, list[int]]:
        return number, side_by_side([partial(pow, number, 2), partial(pow, number, 3)])

    found = side_by_side([partial(piece, number) for number in range(5)])
    assert found == [(number, [number**2, number**3]) for number in range(5)]
    assert threads() == int(most)


@pytest.mark.parametrize("last", ["asking", "serving"])
def test_the_last_piece_gets_the_threads_of_those_that_ended(last: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever it is done: the thread that asked for the work waits meanwhile, or serves it."""
    monkeypatch.setenv(LIMIT, "2")
    both, asking = Barrier(2, timeout=30.0), get_ident()
    by: set[int] = set()

    def piece() -> list[int]:
        both.wait()
        seen = [threads()]
        both.wait()
        if (get_ident() == asking) == (last == "asking"):
            until = time.monotonic() + 30.0
            while threads() == 1 and time.monotonic() < until:
                time.sleep(1e-3)
            inner = Barrier(2, timeout=30.0)

            def block(first: int, _: int) -> None:
                inner.wait()
                by.add(get_ident())

            in_blocks(block, 2, 1)
            seen.append(threads())
        return seen

    found = side_by_side([piece, piece])
    assert sorted(found) == [[1], [1, 2]]
    assert len(by) == 2
    assert threads() == 2


def test_an_error_of_a_piece_is_raised_and_threads_are_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LIMIT, "2")
    with pytest.raises(ZeroDivisionError):
        side_by_side([partial(pow, 0, -1), partial(pow, 2, 2)])
    assert threads() == 2
