"""What is odd about measured curves, said once: by file and line, with what to do."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from hashlib import sha256

import numpy as np

from hyperfab.io.csv_tests import TestData
from hyperfab.numerics.hygiene import Doubt, look

#: So many places are named one by one; the others are counted.
SHOWN = 4


def remarks(tests: Sequence[TestData], silent: Collection[str] = ()) -> list[str]:
    """Return one remark a kind of oddity, gravest first, over all ``tests``; kinds in ``silent`` are settled.

    The kinds are those of ``hyperfab.numerics.hygiene.Doubt``, and ``twin``: the same readings in two files.
    """
    found: dict[str, list[tuple[TestData, Doubt]]] = {}
    for test in tests:
        if test.test == "volumetric":
            continue
        across = test.stretch2 if test.test == "biaxial-general" else None
        for doubt in look(
            test.stretch,
            test.stress,
            stretch2=across,
            time=test.time_s,
            branch=test.branch,
            cycle=test.cycle,
        ):
            if doubt.kind not in silent:
                found.setdefault(doubt.kind, []).append((test, doubt))
    return [*_twins(tests), *(_said(group) for group in found.values())]


def _said(group: Sequence[tuple[TestData, Doubt]]) -> str:
    """Return the remark of all tests with one kind of doubt: the worst of them in words."""
    worst = max((doubt for _, doubt in group), key=lambda doubt: doubt.size)
    places = list(dict.fromkeys(_place(test, doubt) for test, doubt in group))
    more = f" and {len(places) - SHOWN} more" if len(places) > SHOWN else ""
    most = "at most: " if len(places) > 1 else ""
    where = "; ".join(places[:SHOWN]) + more
    return f"{where}: {most}{worst.text}; {worst.remedy}"


def _place(test: TestData, doubt: Doubt) -> str:
    return f"{test.source}, line {int(test.lines[doubt.rows[0]])}"


def _twins(tests: Sequence[TestData]) -> Iterator[str]:
    """The same readings under two names count double, and pass for replicates without scatter."""
    seen: dict[bytes, TestData] = {}
    for test in tests:
        columns = [test.stretch, test.stress]
        if len(test.stretch) < 6 or not np.any(test.stress):
            continue
        print_of = sha256(b"".join(column.tobytes() for column in columns)).digest()
        other = seen.setdefault(print_of, test)
        if other is not test:
            here = (test.source, int(test.lines[0]))
            there = (other.source, int(other.lines[0]))
            name = f"line {there[1]}" if here[0] == there[0] else f"{there[0]}, line {there[1]}"
            yield (
                f"{here[0]}, line {here[1]}: the {len(test.stretch)} readings are those of {name}, to the digit; "
                "leave one of them out, or they count double"
            )
