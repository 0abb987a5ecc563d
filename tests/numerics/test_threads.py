"""Work side by side: every piece once, in its place, with a thread to itself, and an error that is not lost."""

from __future__ import annotations

from functools import partial

import pytest

from hyperfab.numerics.threads import LIMIT, side_by_side, threads


@pytest.mark.parametrize("most", ["1", "2", "3"])
def test_each_piece_has_its_place_and_one_thread(most: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LIMIT, most)

    def piece(number: int) -> tuple[int, int, list[int]]:
        return number, threads(), side_by_side([partial(pow, number, 2), partial(pow, number, 3)])

    found = side_by_side([partial(piece, number) for number in range(5)])
    alone = int(most) if most == "1" else 1
    assert found == [(number, alone, [number**2, number**3]) for number in range(5)]
    assert threads() == int(most)


def test_an_error_of_a_piece_is_raised_and_threads_are_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LIMIT, "2")
    with pytest.raises(ZeroDivisionError):
        side_by_side([partial(pow, 0, -1), partial(pow, 2, 2)])
    assert threads() == 2
