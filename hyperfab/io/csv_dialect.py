"""What a table is written in: encoding, separator, metadata, head, units row. Numbers come later."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from hyperfab.errors import InputError, placed
from hyperfab.io.cells import NO_READING, is_clock, is_number
from hyperfab.io.csv_sheet import CsvSheet
from hyperfab.io.dictionary import is_closing
from hyperfab.io.encoding import decode
from hyperfab.io.headings import Heading, heading
from hyperfab.io.layout import PLAIN, Layout, headless
from hyperfab.io.named_tests import kind_named
from hyperfab.io.pages import one_of_pages
from hyperfab.io.rows import (
    CELL,
    MAX_CELLS,
    MAX_COLUMNS,
    SEPARATORS,
    Row,
    are_types,
    lines_of,
    split,
    titles_by_gaps,
    uniform,
)
from hyperfab.io.settings import Entry, entry_of, in_sentences, settings, sizes
from hyperfab.io.table_readings import keep_readings
from hyperfab.io.tables import (
    Block,
    Fits,
    best,
    find,
    headings,
    is_data,
    is_label,
    is_units,
    refuse_grid,
    transposed,
    understood,
    with_units,
    with_units_above,
)
from hyperfab.io.unit_cells import units_of_cells
from hyperfab.io.xlsx import NOT_COMPUTED, is_workbook, split_sheet, worksheets

#: How comments begin that other programs write above a table; of a row of units no word follows.
_COMMENT = re.compile(r"^(?:%|//)+(?=[ \t]*[^\W\d_]{2,})")
#: Where LabVIEW ends what it writes above its readings: of the file, then of their channels.
_END_OF_HEADER = "***End_of_Header***"
#: A comment of so few words may name the test.
_WORDS = 4
#: Rows from which the head of a long file is told.
_WINDOW = 400


def open_sheets(
    data: bytes, name: str, fits: Fits, layout: Layout = PLAIN, sought: Sequence[str] = ()
) -> list[CsvSheet]:
    """Split a file into its tables whose headings ``fits``: several where specimens stand one under another.

    ``sought`` are the headings of a table that is no test, as it may be asked for where a file has none.

    Comma, semicolon, tab, bar or white space; UTF-8, UTF-16, Windows and other code pages, any line ends;
    ``# key: value`` lines, and whatever machines write above a table; units beside the names or in a row of their own;
    workbooks (``FILE.xlsx:SHEET``).

    Raises InputError naming the line where the rows do not fit the header, no table fits, the file is no text, or too
    large.

    >>> [sheet] = open_sheets(b"# test: shear\\nstretch;stress [MPa]\\n1,1;0,2\\n", "shear.csv", lambda heads: True)
    >>> sheet.separator, sheet.columns, sheet.meta("test").value, sheet.headings[1].unit
    (';', (['1,1'], ['0,2']), 'shear', 'MPa')
    """
    with placed(name):
        if is_workbook(data):
            found = _of_workbook(data, name, fits, layout)
        else:
            found = _of_text(data, name, fits, layout, sought)
    return found


def _of_text(data: bytes, name: str, fits: Fits, layout: Layout, sought: Sequence[str]) -> list[CsvSheet]:
    lines = lines_of(decode(data, layout.titles))
    ends = [number for number, line in enumerate(lines[:_WINDOW], 1) if line.startswith(_END_OF_HEADER)]
    if not ends or layout.skip_rows is not None:
        return _of_lines(lines, name, fits, layout, sought)
    found = _of_lines(lines, name, fits, replace(layout, skip_rows=ends[-1]), sought)
    above = [split(line, found[0].separator, number) for number, line in enumerate(lines[: ends[-1]], 1)]
    return [replace(one, headings=with_units_above(one.headings, above)) for one in found]


def _of_lines(lines: list[str], name: str, fits: Fits, layout: Layout, sought: Sequence[str]) -> list[CsvSheet]:
    metadata, body, separator = _comments(lines, layout)
    if not body:
        raise InputError("has no header and no rows", remedy="a table with a header line is expected")
    given = separator
    separator = separator or _separator([text for _, text in body[:21]])
    first = _first_table(body, separator, fits, layout)
    if first is not None:
        return [_sheet(block, name, separator, metadata, layout) for block in first]
    marks = [given] if given else list(SEPARATORS)
    if len(body) > 2 * _WINDOW:
        told = best((mark, find(_rows(body[:_WINDOW], mark), fits, layout)) for mark in marks)
        if told is not None:
            marks, long = [told[0]], _long(body, *told)
            if long is not None:
                return [_sheet(long, name, told[0], metadata, layout)]
    chosen = best((mark, find(_rows(body, mark), fits, layout)) for mark in marks)
    if chosen is None:
        # Rows for columns: a quantity a line.
        chosen = best((mark, find(transposed(_rows(body, mark)), fits, layout)) for mark in SEPARATORS)
    if chosen is None:
        separator, block = _plain(body, separator, layout, sought)
        return [_sheet(block, name, separator, metadata, layout)]
    separator, blocks = chosen
    if layout.skip_rows is not None:
        blocks = blocks[:1]
    return [_sheet(block, name, separator, metadata, layout) for block in understood(one_of_pages(blocks))]


def the_one(sheets: Sequence[CsvSheet], name: str) -> CsvSheet:
    """Return the table that is all there is in a file called ``name``; InputError where there are several."""
    if len(sheets) > 1:
        raise InputError(
            f"has {len(sheets)} tables, in lines {sheets[0].header_line}, {sheets[1].header_line}, …",
            file=name,
            remedy=f"take the last with --skip-rows {sheets[-1].header_line - 1}, or part the file",
        )
    return sheets[0]


def _of_workbook(data: bytes, name: str, fits: Fits, layout: Layout) -> list[CsvSheet]:
    found: list[CsvSheet] = []
    book, picked = split_sheet(name)
    with placed(book):
        titles = worksheets(data, picked)
    skip = layout.skip_rows or 0
    filled = {title: [row for row in rows if row[0] > skip and any(row[1])] for title, rows in titles}
    tables = {title: find(rows, fits, layout) for title, rows in filled.items()}
    beside = sizes([row for title, rows in filled.items() if not tables[title] for row in rows])

    def sheets(title: str, blocks: Sequence[Block]) -> list[CsvSheet]:
        there = name if picked else f"{name}:{title}"
        with placed(there):
            blocks = blocks[:1] if layout.skip_rows is not None else understood(one_of_pages(blocks))
            for block in blocks:
                block.metadata = {**beside, **block.metadata}
            made = [replace(_sheet(block, there, CELL, {}, layout), label=title) for block in blocks]
        return made

    for title, blocks in tables.items():
        found += sheets(title, blocks)
    if not found:  # the only table there is: its columns are then named in the message
        every = {title: find(rows, lambda heads: len(heads) > 1, layout) for title, rows in filled.items()}
        if sum(map(len, every.values())) == 1:
            return [one for title, blocks in every.items() if blocks for one in sheets(title, blocks)]
        for title, rows in titles:
            number = next((number for number, cells in rows if NOT_COMPUTED in cells), None)
            if number is not None:
                raise InputError(
                    "has a formula whose value the file does not hold, and no table can be read",
                    file=f"{book}:{title}",
                    line=number,
                    remedy="open the workbook in a spreadsheet program and save it again",
                )
    if len({tuple(one.title for one in part.headings) for part in found}) != 1:
        names = [title for title, _ in titles]
        raise InputError(
            "has tables of different columns on its sheets"
            if found
            else f"no sheet has a table that can be read ({', '.join(names[:6])})",
            remedy=f'name one, as in "{name}:{found[0].label}"'
            if found
            else 'say what its columns are with --columns "Title=force [N],…"',
        )
    return found


def _comments(lines: list[str], layout: Layout) -> tuple[dict[str, list[Entry]], list[tuple[int, str]], str | None]:
    """Take out metadata, comments and empty lines; what is left is head and rows with their line numbers."""
    metadata: dict[str, list[Entry]] = {}
    body: list[tuple[int, str]] = []
    comment: tuple[int, str] | None = None
    titles: list[Entry] = []
    separator = None
    skip = layout.skip_rows or 0
    for number, line in enumerate(lines, 1):
        stripped = line.strip()
        if not stripped:
            continue
        if not body:
            stripped = _COMMENT.sub("#", stripped)
        if stripped.startswith(("#", '"#')) and not (body and _no_reading(stripped)):
            key, colon, value = stripped.strip(";,\t").strip('"').lstrip("#").partition(":")
            if colon and not body and not re.search("[\t;]", key.strip()):  # a head may tell the time of day
                one = heading(key.strip(), 0)  # also "# width [mm]: 25"
                stated = f"{value.strip()} {one.unit}" if one.unit else value.strip()
                name, entry = entry_of(one.label, stated, number, own=True)
                metadata.setdefault(name, []).append(entry)
            elif not body:
                comment = (number, stripped.lstrip("#"))
                title = Entry(comment[1].strip(), number, sure=False)
                titles.append(title)
                if len(title.value.split()) <= _WORDS and kind_named(title.value) is not None:
                    metadata.setdefault("test", []).append(title)
        elif number <= skip:
            for known, entries in settings([(number, split(line, _separator([line]), number))]).items():
                metadata.setdefault(known, []).extend(entries)
        elif not body and re.fullmatch(r'"?sep=[;,\t|]"?', stripped or line):
            separator = line.strip(' "\r\n')[4:5]
        else:
            body.append((number, line))
    if comment is not None and body and any(is_data(split(body[0][1], mark, body[0][0])) for mark in SEPARATORS):
        body.insert(0, comment)  # a table whose head is a comment, as numpy writes it
        titles = titles[:-1]
    if titles:
        metadata.setdefault("title", []).extend(titles)
    told = in_sentences([(entry.line, entry.value) for entry in titles])
    return {**told, **metadata}, body, separator


def _no_reading(line: str) -> bool:
    """Whether a row that begins with # is one of errors of a spreadsheet (#DIV/0!) and no comment."""
    return NO_READING.fullmatch(re.split(r"[;,\t|]", line)[0].strip(' "')) is not None


def _separator(sample: list[str]) -> str:
    """Choose the separator of the header that also cuts the first rows into as many cells."""
    header = re.sub(r'"[^"]*"|\[[^\]]*\]|\([^)]*\)', "", sample[0])
    candidates = [mark for mark in "\t;|," if mark in header]
    for mark in candidates:
        count = _count(sample[0], mark)
        if all(_count(line, mark) == count for line in sample[1:]):
            return mark
    return candidates[0] if candidates else ","


def _count(line: str, mark: str) -> int:
    return re.sub(r'"[^"]*"', "", line).count(mark)


def _rows(body: list[tuple[int, str]], separator: str) -> list[Row]:
    """Return the rows of all lines; where white space parts them, titles are cut into as many as there are columns."""
    rows = [(number, split(text, separator, number)) for number, text in body]
    if separator != " ":
        return rows
    data = [is_data(cells) for _, cells in rows]
    reads = [one and 2 * sum(map(_reads, cells)) >= len(cells) for one, (_, cells) in zip(data, rows, strict=True)]
    reads = reads if any(reads) else data  # others are sentences
    widths = Counter(len(cells) for (_, cells), one in zip(rows, reads, strict=True) if one)
    if not widths:
        return rows
    count = widths.most_common(1)[0][0]
    return [
        row if one else (number, titles_by_gaps(text, count) or [text.strip()])
        for row, one, (number, text) in zip(rows, reads, body, strict=True)
    ]


def _reads(cell: str) -> bool:
    return is_number(cell) or is_clock(cell) or NO_READING.fullmatch(cell) is not None


def _long(body: list[tuple[int, str]], separator: str, blocks: list[Block]) -> Block | None:
    """Return the table that a long file is below its head, where it is plain from there to its end; else None."""
    if len(blocks) != 1:
        return None
    block, first = blocks[0], blocks[0].rows[0][0]
    rest = [(number, text) for number, text in body if number >= first]
    return block if _fill(block, rest, separator) else None


def _fill(block: Block, rows: list[tuple[int, str]], separator: str) -> bool:
    """Give a block the columns of its rows where they are plain throughout, and return whether they are."""
    if len(rows) * len(block.headings) > MAX_CELLS:
        raise InputError(f"has more than {MAX_CELLS} cells", remedy="thin it out or export fewer channels")
    columns = uniform([text for _, text in rows], separator, len(block.headings)) if len(rows) > _WINDOW else None
    if columns is None or not all(map(_plain_column, columns)):
        return False
    block.columns, block.lines = columns, [number for number, _ in rows]
    return True


def _first_table(body: list[tuple[int, str]], separator: str, fits: Fits, layout: Layout) -> list[Block] | None:
    """Return the table whose head is the first line, or None where that is none or other tables follow it."""
    line, text = body[0]
    titles = split(text, separator, line)
    if len(titles) > MAX_COLUMNS:
        raise InputError(f"has {len(titles)} columns", line=line, remedy="export fewer channels")
    second = split(body[1][1], separator, body[1][0]) if len(body) > 1 else []
    if all(is_number(cell) for cell in titles if cell) or are_types(second):
        return None  # types, perhaps above units
    heads = headings(titles, layout)
    start = 1
    if is_units(second):
        heads, start = with_units(heads, second, body[1][0]), 2
    if not fits(heads):
        return None
    block = Block(line, heads, head=[(line, titles)])
    rest = body[start:]
    if not rest:
        raise InputError("has a header but no rows", line=line, remedy="export the readings too")
    if _fill(block, rest, separator):
        return [block]
    block.rows = [(number, split(one, separator, number)) for number, one in rest]
    for row, (_, cells) in enumerate(block.rows):
        # Words in mid-table that are a head of their own: another specimen follows.
        if is_label(cells) or (row and not is_data(cells) and any(cells) and fits(headings(cells, layout))):
            return None
    return [block]


_LETTERS = re.compile(r"[^\d\s.,;:+\-eE%/]")


def _plain_column(cells: Sequence[str]) -> bool:
    """Whether a column holds readings, or words that repeat, from end to end: nothing to leave out."""
    if not _LETTERS.search("\n".join(cells)) and "" not in cells:
        return True
    kinds = set(cells)
    return (
        len(kinds) <= 64
        and not any(is_closing(cell) or "#" in cell for cell in kinds)
        and not any(is_number(cell) for cell in kinds)
    )


def _plain(body: list[tuple[int, str]], separator: str, layout: Layout, sought: Sequence[str]) -> tuple[str, Block]:
    """Return what a file most likely is where no head fits, with its separator: its columns are then named in the
    message, or found by what they hold, as a clock is."""

    def wide(heads: Sequence[Heading]) -> bool:
        return len(heads) > 1

    window = body[:_WINDOW]
    options = [(mark, _rows(window, mark)) for mark in SEPARATORS]
    for _, rows in options if sought else ():
        refuse_grid(rows, sought)
    chosen = best((mark, find(rows, wide, layout)) for mark, rows in options)
    if chosen is not None:
        mark, blocks = chosen
        if len(body) > _WINDOW and _long(body, *chosen) is None:
            blocks = find(_rows(body, mark), wide, layout)
        return mark, max(blocks, key=lambda one: len(one.lines or one.rows))
    _, rows = max(options, key=lambda option: sum(is_data(cells) for _, cells in option[1]))
    if is_data(rows[0][1]):
        raise headless(rows, sought)
    rows = _rows(body, separator)
    return separator, Block(rows[0][0], headings(rows[0][1], layout), rows[1:])


def _sheet(block: Block, name: str, separator: str, metadata: Mapping[str, list[Entry]], layout: Layout) -> CsvSheet:
    """Return a block as a sheet, its rows judged one by one."""
    if block.columns is None:
        keep_readings(block, separator)
    everything: dict[str, list[Entry]] = {key: list(entries) for key, entries in metadata.items()}
    for key, entries in block.metadata.items():
        everything.setdefault(key, []).extend(entries)
    if block.columns is None and not block.rows:
        raise InputError("has a header but no rows", line=block.head_line, remedy="export the readings too")
    columns = (
        block.columns
        if block.columns is not None
        else [list(cells) for cells in zip(*(cells for _, cells in block.rows), strict=True)]
    )
    heads = list(block.headings)
    lines = block.lines or [line for line, _ in block.rows]
    units_of_cells(heads, columns, lines)
    # A column of a workbook may hold numbers as text, with a comma.
    comma = any("," in cell and is_number(cell) for cells in columns for cell in cells[:50])
    return CsvSheet(
        name, separator, tuple(heads), block.head_line, tuple(columns[: len(block.headings)]), lines, everything,
        dict(block.left_out), tuple(dict.fromkeys(block.words)), layout,
        mark="." if separator == CELL and not comma else None, over=block.over,
    )  # fmt: skip
