"""Tests that stand side by side in one table, told apart by titles repeated, numbered or stated above them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from hyperfab.io.cells import plain_values
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import Meaning, axis_of, plain, reading, word_for
from hyperfab.io.headings import Heading, heading, meaning, suffixed
from hyperfab.io.layout import Choice, Layout, named
from hyperfab.io.named_tests import kind_named
from hyperfab.io.roles import (
    SPECIMEN,
    STRESSES,
    STRETCHES,
    Label,
    by_unit,
    fits,
    label_of,
    read,
    state_of,
)
from hyperfab.io.settings import Entry


def specimens(sheet: CsvSheet, one_axis: bool = False, ways: Sequence[str] = STRETCHES) -> list[CsvSheet]:
    """Return the tables of the specimens that stand side by side, each with the columns all share; else the sheet.

    They are told by their titles, whatever the command line says that these hold: equal to the letter and repeated,
    by ``Probe 1``, ``Specimen 2`` before a title, by ``.1``, ``.2`` behind it, as pandas writes copies, or by ``_1``,
    ``_2``, ``_3`` and letters; two numbers are the axes of a general biaxial test, unless the test is known to have
    ``one_axis``. ``ways`` are what a stress or a force may be read along.
    """
    if ways is STRETCHES and (titled := _under_titles(sheet, one_axis)) is not None:
        return titled
    chosen = {head.index: one for head in sheet.headings if (one := sheet.layout.choice(head, sheet.headings))}
    if any(one.name.endswith(" 2") or one.is_number for one in chosen.values()):
        return [sheet]
    own = [_plainly(one, chosen[one.index]) if one.index in chosen else one for one in sheet.headings]
    groups, shared, stated = _grouped(own, one_axis, ways)
    if chosen:
        sheet = replace(sheet, layout=_for_all_alike(sheet.layout, groups, chosen))
        groups = {key: _as_chosen(sheet.layout, heads) for key, heads in groups.items()}
    told = {key: {name for one in heads if (name := _held(one, meaning(one), ways))} for key, heads in groups.items()}
    if chosen:  # whose readings the command line sets aside is no specimen
        groups = {key: heads for key, heads in groups.items() if told[key] & set(STRESSES)}
    shared = [one for one in sheet.headings if one.index in {head.index for head in shared}]
    one_load = {_held(one, meaning(one), ways) for one in shared} & {*STRESSES}
    if len(groups) < 2 or not all(
        told[key] & {*STRESSES} or (one_load and _lengthen(sheet, heads)) for key, heads in groups.items()
    ):
        return [sheet]
    of_all = {_held(one, meaning(one), ways) for one in shared} & {*ways} if ways is not STRETCHES else ()
    if not (of_all or all(told[key] & set(ways) for key in groups) or fits([*shared, *next(iter(groups.values()))])):
        return [sheet]
    found = []
    for key, heads in groups.items():
        metadata = dict(sheet.metadata)
        if key in stated:
            setting, value = stated[key].setting, stated[key].value
            metadata[setting] = [Entry(value, sheet.header_line, sure=setting == "test")]
        found.append(_part(sheet, heads, shared, f"{sheet.label} {key}".strip(), metadata))
    return found


def _lengthen(sheet: CsvSheet, heads: Sequence[Heading]) -> bool:
    """Whether columns go up farther than down from where they begin: a strip's own, no width that is drawn in."""
    every = [plain_values(sheet.columns[one.index]) for one in heads]
    return all(max(values, default=0.0) + min(values, default=0.0) > 2.0 * sum(values[:1]) for values in every)


def _held(head: Heading, found: Meaning | None, ways: Sequence[str]) -> str | None:
    """Return what a column holds: one of the ``ways`` by its name, or by the words for readings; else as ``found``."""
    own = next((one for one in (head.name, suffixed(head).name, reading(suffixed(head).label)) if one in ways), None)
    return own or (None if found is None else found.name)


def _plainly(head: Heading, choice: Choice) -> Heading:
    """Return a column as its title reads; one that only says which (``Warp``) in the unit of the command line."""
    plainly = heading(head.title, head.index)
    bare = plainly.unit is None and state_of(head.title) is not None
    return replace(plainly, unit=choice.unit) if bare else plainly


def _grouped(
    heads: Sequence[Heading], one_axis: bool, ways: Sequence[str]
) -> tuple[dict[str, list[Heading]], list[Heading], dict[str, Label]]:
    """Return the headings of each specimen by its key, those that all share, and what keys state, if no specimen."""
    groups: dict[str, list[Heading]] = {}
    shared: list[Heading] = []
    titles = [plain(head.title) for head in heads]
    repeated = {title for title in titles if title and titles.count(title) > 1}
    names = {_held(head, read(head), ways) for head in heads if plain(head.title) in repeated}
    both = bool(names & {*ways, *STRETCHES}) and bool(names & set(STRESSES))
    copies = {title.rpartition(".")[0] for head in heads if re.fullmatch(r".+\.\d", title := head.title)}
    seen: dict[str, int] = {}
    for head, title in zip(heads, titles, strict=True):
        match = SPECIMEN.fullmatch(plain(head.label))
        copy = re.fullmatch(r"(.+)\.(\d)", head.title)
        if match and (match[2] or by_unit(head)):
            made = replace(head, label=match[2] or str(by_unit(head)))
            groups.setdefault(match[1], []).append(made)
        elif title in repeated and both:
            seen[title] = seen.get(title, 0) + 1
            groups.setdefault(str(seen[title]), []).append(head)
        elif copy and copy[1] in {one.title for one in heads}:
            groups.setdefault(str(int(copy[2]) + 1), []).append(replace(heading(copy[1], head.index), title=head.title))
        elif head.title in copies:
            groups.setdefault("1", []).append(head)
        else:
            shared.append(head)
    if groups:
        return groups, shared, {}
    labelled, shared = _labelled(heads, one_axis)
    stated = {label.key: label for label in labelled if label.setting != "specimen"}
    return {label.key: own for label, own in labelled.items()}, shared, stated


def _for_all_alike(layout: Layout, groups: Mapping[str, Sequence[Heading]], chosen: Mapping[int, Choice]) -> Layout:
    """Return what the command line says with that for the columns alike of the other specimens.

    Alike are what titles say beside the specimen; a column whose title is its own may be set aside alone.
    """
    every = [one for heads in groups.values() for one in heads]
    told = [(one, chosen[one.index]) for one in every if one.index in chosen]
    more = {
        head.title: replace(choice, title=head.title)
        for one, choice in reversed(told)
        for head in every
        if head.index not in chosen and choice.name != "aside" and plain(one.label) == plain(head.label)
    }
    return replace(layout, columns=(*layout.columns, *more.values()))


def _as_chosen(layout: Layout, heads: Sequence[Heading]) -> list[Heading]:
    """Return a specimen's columns as the command line names them, without those that it sets aside."""
    made = [(head, layout.choice(head, heads)) for head in heads]
    return [
        head if choice is None else named(choice, head)
        for head, choice in made
        if choice is None or choice.name != "aside"
    ]


def _part(
    sheet: CsvSheet,
    heads: Sequence[Heading],
    shared: Sequence[Heading],
    label: str,
    metadata: Mapping[str, list[Entry]],
) -> CsvSheet:
    """Return the table of some columns and those that all share, with the rows that have any of its own."""
    own = [one.index for one in heads]
    rows = [row for row in range(len(sheet.lines)) if any(sheet.columns[index][row] for index in own)]
    headings = tuple(sorted([*shared, *heads], key=lambda one: one.index))
    return replace(sheet.of_rows(rows), metadata=metadata, headings=headings, label=label)


def _under_titles(sheet: CsvSheet, one_axis: bool) -> list[CsvSheet] | None:
    """Return the tables that stand side by side under titles of their own, which say what each is: a test, a state.

    Directions are said of specimens where the test has ``one_axis``, else of its axes. None where there are no such
    titles, or not all have a stretch and a stress.
    """
    if sheet.over is None:
        return None
    line, cells = sheet.over
    groups: list[tuple[str, list[Heading]]] = []
    for head in sheet.headings:
        title = cells[head.index].strip() if head.index < len(cells) else ""
        # A title may stand over each of its columns, as pandas writes it.
        again = bool(groups) and title == groups[-1][0] and not fits(groups[-1][1])
        if not groups or (title and not again):
            groups.append((title, []))
        if head.title.strip():
            alike = next(one for one in sheet.headings if plain(one.title) == plain(head.title))
            choice = sheet.layout.choice(alike, sheet.headings)
            groups[-1][1].append(head if choice is None else named(choice, head))
    if all(read(head) is None for head in groups[0][1]):  # the numbers of the rows
        groups = groups[1:]
    one_axis = one_axis or len(groups) > 2
    axes = [_axis(title) for title, _ in groups]
    if not one_axis and axes in (["1", "2"], ["2", "1"]):
        along = [
            replace(head, title=f"{head.title} {title}", label=f"{head.label} {axis}")
            for (title, heads), axis in zip(groups, axes, strict=True)
            for head in heads
        ]
        return [replace(sheet, headings=tuple(along))]
    told = [_told(title, one_axis) for title, _ in groups]
    if len(groups) < 2 or not all(title and fits(heads) for title, heads in groups):
        return None
    if not any(told) and not sheet.layout.columns:
        return None
    return [
        _part(
            sheet,
            heads,
            (),
            title,
            {**sheet.metadata, **{key: [Entry(value, line, key == "test")] for key, value in one.items()}},
        )
        for (title, heads), one in zip(groups, told, strict=True)
    ]


def _axis(title: str) -> str:
    """Return the axis that a title names: ``Axis 1``, ``X``, ``Warp``; nothing where it names none."""
    *before, last = plain(title).split() or [""]
    return axis_of(last if before in ([], ["axis"], ["direction"], ["achse"], ["eje"], ["axe"]) else title)


def _told(title: str, one_axis: bool) -> dict[str, str]:
    """Return what a title says of columns below it: test, temperature, rate, direction where it has ``one_axis``."""
    kind = kind_named(title)
    along = one_axis or kind == "uniaxial"
    found: dict[str, str] = {}
    words = title.split()
    for count in (2, 1):
        for k in range(len(words) + 1 - count):
            label = state_of(" ".join(words[k : k + count]).strip("(),;"))
            if label is not None and (along or label.setting != "direction"):
                found.setdefault(label.setting, label.value)
    return found if kind is None else {**found, "test": kind}


def _labelled(heads: Sequence[Heading], one_axis: bool) -> tuple[dict[Label, list[Heading]], list[Heading]]:
    """Return the headings of each specimen by the label in its titles, and the others.

    Nothing where the same columns do not stand there for each, a stress among them, or where two axes could be meant.
    """
    groups: dict[Label, list[Heading]] = {}
    shared: list[Heading] = []
    for head in heads:
        found = label_of(head)
        if found is None:
            shared.append(head)
        else:
            groups.setdefault(found[1], []).append(found[0])
    kinds = [{one.name for head in own if (one := read(head)) is not None} for own in groups.values()]
    keys = {label.key for label in groups}
    axes = keys <= {"x", "y"} or (
        not one_axis and (keys <= {"1", "2"} or any(label.setting == "direction" for label in groups))
    )
    one_kind = len(settings := {label.setting for label in groups}) == 1
    # Of strips of several directions under the same loads each has a stretch of its own.
    one_load = settings == {"direction"} and any((one := read(head)) and one.name in STRESSES for head in shared)
    due = {*STRESSES, *STRETCHES} if one_load else {*STRESSES}
    alike = len(kinds) > 1 and all(one == kinds[0] for one in kinds) and kinds[0] & due
    # Two forces over one extension may be two load cells, if nothing but a number tells them apart.
    cells = {"force"} if "specimen" in settings else set()
    own = kinds and (kinds[0] & set(STRETCHES) or kinds[0] & set(STRESSES) - cells)
    return (groups, shared) if alike and own and one_kind and not axes else ({}, list(heads))


def may_be_specimens(sheet: CsvSheet) -> bool:
    """Whether columns are those of specimens cut in several directions, if the test has one axis, else of its axes."""
    own = [heading(one.title, one.index) if sheet.layout.columns else one for one in sheet.headings]
    labels = _labelled(own, one_axis=True)[0]
    above = [] if sheet.over is None else sheet.over[1]
    return any(label.setting == "direction" for label in labels) or any(
        word_for(title, "DIRECTIONS") for title in above
    )
