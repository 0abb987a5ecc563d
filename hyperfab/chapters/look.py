"""How measured files were read, how far they went, and what is odd about their curves: said once, with what to do."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from hashlib import sha256

import numpy as np
from numpy.typing import ArrayLike

from hyperfab.chapters.validity import span
from hyperfab.curve import TestCurve
from hyperfab.documents.material import Tested
from hyperfab.errors import InputError, UsageError
from hyperfab.io.csv_tests import TestData
from hyperfab.io.layout import Layout
from hyperfab.io.units import quantity_of
from hyperfab.numerics.doubt import Doubt
from hyperfab.numerics.hygiene import look

#: What a file says of itself and the laws, or nobody, has a use for.
_KNOWN = {
    "test", "direction", "temperature", "room temperature", "rate", "cycle", "branch", "specimen", "thickness", "width",
    "gauge length", "area", "grip distance", "extensometer length", "gauge", "diameter", "source", "date", "time",
    "operator", "machine", "note", "comment", "material", "standard", "preload", "sample", "title", "name", "license",
    "doi", "year", "specimen length", "height",
}  # fmt: skip
#: How warm a room is [degC], and how far from that a test was warmed or cooled.
_ROOM = (23.0, 5.0)
#: So many places are named one by one; the others are counted.
SHOWN = 4
#: Beyond these temperatures [degC] no fabric is tested or used: more often a wrong unit than a wish.
COLDEST, HOTTEST = -60.0, 400.0


def remarks(tests: Sequence[TestData], silent: Collection[str]) -> list[str]:
    """Return one remark a kind of oddity, gravest first, over all ``tests``; kinds in ``silent`` are settled.

    The kinds are those of ``hyperfab.numerics.doubt.Doubt``, and ``twin``: the same readings in two files; first of all
    strips of which nobody knows how they were cut beside others.
    """
    found: dict[str, list[tuple[TestData, Doubt]]] = {}
    for test in tests:
        if test.mode == "volumetric":
            continue
        across = test.stretch2 if test.mode == "biaxial-general" else None
        for doubt in look(
            test.principal,
            test.stress,
            stretch2=across,
            time=test.time_s,
            branch=test.branch,
            cycle=test.cycle,
        ):
            if doubt.kind not in silent:
                found.setdefault(doubt.kind, []).append((test, doubt))
    return [
        *_cut_anyhow(tests),
        *_warm_anyhow(tests),
        *_twins(tests),
        *_odd_warmth(tests),
        *(_said(group) for group in found.values()),
    ]


def per_width(tests: Sequence[TestData], remedy: str) -> bool:
    """Return whether the stresses are forces per width [N/mm]; InputError where those of some tests are in MPa."""
    widths = [test.source for test in tests if test.membrane]
    other = next((test.source for test in tests if not test.membrane), None)
    if widths and other is not None:
        raise InputError(f"is in N/mm of width, {other} in MPa", file=widths[0], remedy=remedy)
    return bool(widths)


def stated_noise(text: str | None, kinds: Sequence[str]) -> tuple[str, float] | None:
    """Return the kind and size of ``--noise``, which states the reading of one of ``kinds``."""
    if text is None:
        return None
    kind, value = quantity_of(text, kinds, option="--noise")
    if value <= 0.0:
        raise UsageError(f"--noise {text}: must be more than zero")
    return kind, value


def _said(group: Sequence[tuple[TestData, Doubt]]) -> str:
    """Return the remark of all tests with one kind of doubt: the worst of them in words."""
    worst = max((doubt for _, doubt in group), key=lambda doubt: doubt.size)
    places = list(dict.fromkeys(f"{test.source}, line {int(test.lines[doubt.rows[0]])}" for test, doubt in group))
    more = f" and {len(places) - SHOWN} more" if len(places) > SHOWN else ""
    most = "at most: " if len(places) > 1 else ""
    where = "; ".join(places[:SHOWN]) + more
    return f"{where}: {most}{worst.text}; {worst.remedy}"


def _cut_anyhow(tests: Sequence[TestData]) -> Iterator[str]:
    """Strips without a direction, or with a word for it that is none, beside others that tell theirs."""
    strips = [test for test in tests if test.mode == "uniaxial"]
    told = next((test for test in strips if test.direction is not None), None)
    unknown: dict[str, list[str]] = {}
    for test in strips if told else ():
        if test.direction is None:
            word = test.metadata.get("direction", "")[:40]
            why = f"direction {word} is not known" if word else "no direction is told"
            label = f", specimen {test.specimen}" if test.specimen else ""
            unknown.setdefault(why, []).append(f"{test.source}{label}")
    for why, names in unknown.items():
        assert told is not None
        yield (
            f"{named(names)}: {why}, beside {told.direction_name} in {told.source}; say how it was cut, as in a line "
            '"# direction: warp" (weft, degrees from the warp), or in the title of its columns'
        )


def _warm_anyhow(tests: Sequence[TestData]) -> Iterator[str]:
    """Tests that tell no temperature beside others of one that is far from a room's: they count for every one."""
    told = {float(np.median(one.temperature_degC)): one for one in tests if one.temperature_degC is not None}
    names = [test.source for test in tests if test.temperature_degC is None]
    farthest = max(told, key=lambda warm: abs(warm - _ROOM[0]), default=_ROOM[0])
    if names and abs(farthest - _ROOM[0]) > _ROOM[1]:
        yield (
            f"{named(names)}: no temperature is told, beside {farthest:g} degC in {told[farthest].source}; say how "
            'warm it was, as in a line "# temperature: 23 degC"'
        )


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


def _odd_warmth(tests: Sequence[TestData]) -> Iterator[str]:
    """Temperatures that no fabric is tested at."""
    odd: dict[float, list[str]] = {}
    for test in tests:
        for warm in () if test.temperature_degC is None else test.temperature_degC:
            if not COLDEST <= warm <= HOTTEST:
                odd.setdefault(float(warm), []).append(test.source)
    if odd:
        worst = max(odd, key=lambda warm: max(COLDEST - warm, warm - HOTTEST))
        sources = [name for names in odd.values() for name in names]
        yield (
            f"{named(sources)}: {worst:.4g} degC is no temperature of a fabric ({COLDEST:g} to {HOTTEST:g} degC); is "
            "the unit right?"
        )


def states(test: TestData) -> dict[str, float]:
    """Return what a file says of itself in numbers that no law knows: humidity, a batch, an age."""
    found = {}
    for key, text in test.metadata.items():
        number = re.match(r"\s*[-+]?[0-9]+(?:[.,][0-9]+)?", text)
        if number and key.casefold() not in _KNOWN:
            found[key] = float(number[0].replace(",", "."))
    return found


def understood(tests: Sequence[TestData], aside: bool = True) -> list[str]:
    """Return how the files were read, files read alike in one line; what was set aside in them in further lines.

    ``aside``: a number that a file states and no law knows is told too, as one of no use.
    """
    alike: dict[str, list[TestData]] = {}
    notes: dict[str, dict[str, None]] = {}
    for test in tests:
        alike.setdefault(test.understood, []).append(test)
        for note in test.notes:
            notes.setdefault(note, {})[test.source] = None
        if aside and (stated := list(states(test))[:12]):
            notes.setdefault(f"stated and not used: {', '.join(stated)}", {})[test.source] = None
    found = [f"{named([test.source for test in group])}: {how}; {_what(group)}" for how, group in alike.items()]
    return found + [f"{named(list(sources))}: {note}" for note, sources in notes.items()]


def unused_columns(columns: Layout, tests: Sequence[TestData]) -> None:
    """UsageError where an entry of ``--columns`` names no column of any file."""
    for choice in columns.columns:
        if not any(choice in test.chosen for test in tests):
            raise UsageError(f"--columns: no file has a column {choice.title}")


def named(names: Sequence[str]) -> str:
    """Return the files' names, or how many they are and the first of them."""
    names = list(dict.fromkeys(names))
    if len(names) <= 3:
        return ", ".join(names)
    return f"{len(names)} files ({names[0]} to {names[-1]})"


def _what(tests: Sequence[TestData]) -> str:
    """Return kinds, directions, sizes, temperatures, cycles and branches of tests in a few words."""
    parts = [", ".join(dict.fromkeys(test.mode for test in tests))]
    directions = dict.fromkeys(test.direction_name for test in tests if test.direction_name)
    parts += [", ".join(directions)] if directions else []
    specimens = {(test.source, test.specimen) for test in tests}
    parts += [f"{len(specimens)} specimens"] if len(specimens) > 1 else []
    for name, unit, sizes in (
        ("gauge length", "mm", {test.gauge_length_mm for test in tests}),
        ("width", "mm", {test.width_mm for test in tests}),
        ("thickness", "mm", {test.thickness_mm for test in tests}),
        ("diameter", "mm", {test.diameter_mm for test in tests}),
        ("area", "mm2", {test.area_mm2 for test in tests}),
    ):
        known = sorted(size for size in sizes if size is not None)
        parts += [f"{name} {span(known[0], known[-1], unit=unit)}"] if known else []
    warm = [one for test in tests if (one := test.temperature_degC) is not None]
    if warm:
        parts.append(f"{span(min(float(one.min()) for one in warm), max(float(one.max()) for one in warm))} degC")
    cycles = {int(number) for test in tests if test.cycle is not None for number in np.unique(test.cycle)}
    if cycles:
        parts.append(f"cycle{'s' if len(cycles) > 1 else ''} {span(min(cycles), max(cycles))}")
    sides = {int(side) for test in tests if test.branch is not None for side in np.unique(test.branch)}
    parts += [word for word, side in (("loading", 1), ("unloading", -1)) if side in sides]
    return "; ".join(parts)


def tested_by(curves: Iterable[TestCurve]) -> dict[str, Tested] | None:
    """Return the range of stretch and temperature of each kind of test, None where there is no curve.

    In simple shear the stretch is the principal one along the load, below 1 where a test is sheared back.

    >>> curves = [TestCurve("shear", np.array([1.1, end]), np.zeros(2)) for end in (1.5, 1.4)]
    >>> tested_by(curves)["shear"].stretch
    (1.0, 1.5)
    """
    stretches: dict[str, list[float]] = {}
    warmths: dict[str, list[float]] = {}
    for curve in curves:
        along = curve.principal
        across = curve.stretch2 if curve.mode == "biaxial-general" else None
        # Every test passes through rest, whether or not its first reading is taken there.
        stretches.setdefault(curve.mode, [1.0]).extend([*_finite(along), *_finite(across)])
        warmths.setdefault(curve.mode, []).extend(met_degC(curve))
    return {
        test: Tested(
            stretch=(min(found), max(found)),
            temperature_degC=(min(warmths[test]), max(warmths[test])) if warmths[test] else None,
        )
        for test, found in stretches.items()
    } or None


def met_degC(curve: TestCurve) -> list[float]:
    """Return the temperatures [degC] that a test states; none where it says nothing."""
    return _finite(curve.warmth if curve.warmth is not None else curve.temperature_degC)


def _finite(values: ArrayLike | None) -> list[float]:
    if values is None:
        return []
    found = np.ravel(np.asarray(values, dtype=np.float64))
    return [float(value) for value in found[np.isfinite(found)]]
