"""Which rows below the head of a table are readings."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile

from hyperfab.errors import InputError
from hyperfab.io.cells import NO_READING, is_number
from hyperfab.io.dictionary import Meaning, is_closing, plain, setting
from hyperfab.io.headings import NUMBER_LIKE, Heading, heading, meaning, suffixed
from hyperfab.io.rows import CELL, MAX_COLUMNS, SEPARATORS, Row, are_types
from hyperfab.io.setting_words import SETTINGS
from hyperfab.io.settings import settings
from hyperfab.io.tables import Block, is_units, of_specimens

#: More words than these in a column beside the readings are said of them, and state nothing of the file.
_STATED = 60


def keep_readings(block: Block, separator: str) -> None:
    """Leave the block with rows that are readings, all of one width.

    Rows of means and other words are left out and counted, blank ones too. A row that is neither a reading nor such a
    word is refused with its line.
    """
    _stated_beside(block)
    width = len(block.headings)
    kept: list[Row] = []
    waiting: list[Row] = []
    foot: list[Row] = []
    properties = _properties(block.rows)
    if properties:
        block.left_out["property of the channels, no reading"] += properties
        block.words += [cells[0][:40] for _, cells in block.rows[:properties]]
        block.rows = block.rows[properties:]
    named = of_specimens(block.rows)
    reading = [k for k, (_, cells) in enumerate(block.rows) if _reads(cells, block.headings, k in named)]
    while len(reading) > 2 and _is_remark([block.rows[k][1] for k in reading]):
        reading.pop()
    last = reading[-1] if reading else -1
    # What the first row alone goes on to is of the specimen; writers leave off the empty cells behind a row.
    filled = max(len(block.rows[k][1]) for k in reading[1:]) if len(reading) > 2 else width
    for place, (line, cells) in enumerate(block.rows):
        if not any(cells):
            block.left_out["blank row"] += 1
        elif place <= last and _reads(cells, block.headings, place in named):
            waiting = _settled(waiting, block)
            kept.append((line, _fitted(cells, width, block.headings[:filled], line, separator)))
        elif place > last or is_closing(next(cell for cell in cells if cell)):
            block.left_out["closing row, no reading"] += 1
            block.words.append(next(cell for cell in cells if cell)[:40])
            foot.append((line, cells))
        else:
            waiting.append((line, cells))
    block.rows = kept
    _stated_in(foot, block)


def _stated_in(rows: Sequence[Row], block: Block) -> bool:
    """Add what rows below or beside the readings state of the specimen and the test, each told once; whether any do."""
    told = {key: own for key, own in settings(rows).items() if key in SETTINGS and len(own) == 1}
    for key, own in told.items():
        block.metadata.setdefault(key, []).extend(own)
    return bool(told)


def _stated_beside(block: Block) -> None:
    """Take words and values to the right of the readings, each told once, for what the file states."""
    known = [one.index for one in block.headings if meaning(suffixed(one)) not in (None, Meaning("aside"))]
    rows = [*block.head, *block.rows]
    for place in range(max(known, default=MAX_COLUMNS) + 1, max((len(cells) for _, cells in rows), default=0)):
        words = [cell for _, cells in rows for cell in cells[place : place + 1] if cell]
        if len(words) > _STATED or any(map(is_number, words)):
            continue
        if not any(setting(heading(word.partition(":")[0], 0).label) in SETTINGS for word in words):
            continue
        if _stated_in([(line, cells[place:]) for line, cells in rows], block):
            block.headings = block.headings[:place]
            cut = [(line, cells[:place], cells[place:]) for line, cells in block.rows]
            block.rows = [(line, own) for line, own, beside in cut if any(own) or not any(beside)]
        return


def _properties(rows: Sequence[Row]) -> int:
    """How many rows below the head tell of the channels (sensor, calibration) and are named in a column of their own.

    Below them that column is empty, and at least one says in words what stands in numbers there. Or
    they tell the type of each.
    """
    if typed := sum(1 for _ in takewhile(are_types, (cells for _, cells in rows))):
        return typed
    count = next((k for k, (_, cells) in enumerate(rows) if not cells[0]), 0)
    if not 0 < count < len(rows) or any(cells[0] for _, cells in rows[count:]):
        return 0
    below = rows[count][1]
    words = any(
        cell[:1].isalpha() and NO_READING.fullmatch(cell) is None and is_number(number)
        for _, cells in rows[:count]
        for cell, number in zip(cells, below, strict=False)
    )
    return count if words and all(cells[0][0].isalpha() for _, cells in rows[:count]) else 0


def _is_remark(rows: Sequence[Sequence[str]]) -> bool:
    """Whether the last of the rows begins with a word where all others have a number: a mean, in any language."""
    word = rows[-1][0]
    return (
        word[:2].isalpha()
        and NO_READING.fullmatch(word) is None
        and all(cells[0] and is_number(cells[0]) for cells in rows[: len(rows) // 2 + 1])
    )


def _settled(waiting: list[Row], block: Block) -> list[Row]:
    """Judge words between readings: nothing may be lost there that nobody understands."""
    for line, cells in waiting:
        titles = [one.title for one in block.headings]
        if [plain(cell) for cell in cells[: len(titles)]] == [plain(title) for title in titles] or is_units(cells):
            block.left_out["head repeated"] += 1
            continue
        cell = next(cell for cell in cells if cell)
        raise InputError(
            f"{cell[:40]} is no number",
            line=line,
            column=block.headings[0].title,
            remedy="correct the row or delete it",
        )
    return []


def _reads(cells: Sequence[str], heads: Sequence[Heading], named: bool) -> bool:
    """Whether a row has at least one number under the headings, and is none of means."""
    if not any(NUMBER_LIKE.match(cell) or NO_READING.fullmatch(cell) for cell in cells[: len(heads)] if cell):
        return False
    return named or not is_closing(next(cell for cell in cells if cell))


def _fitted(cells: list[str], width: int, heads: Sequence[Heading], line: int, separator: str) -> list[str]:
    """Return a row as wide as the head; InputError where cells that ``heads`` need lack, or are too many."""
    if len(cells) == width:
        return cells
    if len(cells) > width and not any(cells[width:]):
        return cells[:width]
    if len(cells) < width:
        needed = [one.index for one in heads if (m := meaning(one)) is not None and m.name != "aside"]
        # A workbook stores no empty cells behind the last one of a row.
        if separator == CELL or (needed and len(cells) > max(needed)):
            return [*cells, *[""] * (width - len(cells))]
    raise InputError(
        f"has {len(cells)} cells, the header has {width}",
        line=line,
        remedy=_ragged_remedy(len(cells), width, separator),
    )


def _ragged_remedy(count: int, width: int, separator: str) -> str:
    if separator == "," and width < count <= 2 * width:
        return "decimal commas between separating commas? export with semicolons as separator"
    return f"complete the row (the separator is a {SEPARATORS.get(separator, separator)})"
