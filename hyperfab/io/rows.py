"""Lines of a text to rows of cells: separators, quotes, white space; long plain tables in one go."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

from hyperfab.errors import InputError

MAX_ROWS = 400_000
MAX_COLUMNS = 256
MAX_LINE = 32_768
MAX_CELLS = 4_000_000

#: A row: the number of its line, and its cells.
Row = tuple[int, list[str]]

#: What parts the cells of a workbook, and of a text.
CELL = "cell"
SEPARATORS = {"\t": "tab", ";": "semicolon", "|": "bar", ",": "comma", " ": "white space"}
#: A cell that a line leaves open, the end of one, and a number that is kept from being a date: ="0.5".
_OPENED = re.compile(r'(?:^|[,;\t|])\s*"[^"]*$')
_CLOSED = re.compile(r'[^"]*"\s*(?:[,;\t|]|$)')
_FORMULA = re.compile(r'(^|[,;\t|])="([^"]*)"')
#: A number as Fortran writes doubles: 1.25D-01.
_FORTRAN = re.compile(r"(?<!\w)([+-]?\d*[.,]\d*)[dD]([+-]\d{1,3})\b")
#: A sign set apart from its number, as recorders pad it: +    26.5.
_APART = re.compile(r"(^|[,;\t])( *[+-]) +(?=\d)")
_WIDE_GAP = re.compile(r" *\t[\t ]*| {2,}")


def lines_of(text: str) -> list[str]:
    """Return the lines of a text; InputError where it has too many or too long ones."""
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\x0b", "\n").replace("\x0c", "\n")
    if text.count("\n") > MAX_ROWS + 1000:
        raise InputError(f"has more than {MAX_ROWS} rows", remedy="thin the recording out")
    lines = text.split("\n")
    if "D+" in text or "D-" in text or "d+" in text or "d-" in text:
        lines = [_FORTRAN.sub(r"\1E\2", line) if len(line) <= MAX_LINE else line for line in lines]
    if "+ " in text:
        lines = [_APART.sub(r"\1\2", line) if len(line) <= MAX_LINE else line for line in lines]
    if '"' in text:
        lines = _whole([_FORMULA.sub(r'\1"\2"', line) for line in lines] if '="' in text else lines)
    if max(map(len, lines)) > MAX_LINE:
        long = next(number for number, line in enumerate(lines, 1) if len(line) > MAX_LINE)
        raise InputError(f"is longer than {MAX_LINE} characters", line=long, remedy="is this a table with line ends?")
    return lines


def _whole(lines: list[str]) -> list[str]:
    """Return lines in which no quoted cell is broken, as offices break long titles; their numbers stay."""
    for place, line in enumerate(lines):
        if line.count('"') % 2 == 0 or not _OPENED.search(line):
            continue
        end = next((k for k in range(place + 1, min(place + 5, len(lines))) if '"' in lines[k]), None)
        if end is not None and _CLOSED.match(lines[end]):
            lines[end] = " ".join(lines[place : end + 1])  # goes on there, where it may break again
            lines[place:end] = [""] * (end - place)
    return lines


def split(line: str, separator: str, number: int) -> list[str]:
    """Return the cells of a line; InputError where a quote is not closed.

    >>> split('"1,5"; 2 ;', ";", 1), split("  1.5   2", " ", 1)
    (['1,5', '2', ''], ['1.5', '2'])
    """
    if separator == " ":
        return line.split() if '"' not in line else [part or word for part, word in _WORDS.findall(line)]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    try:
        cells = next(csv.reader([line], delimiter=separator, strict=True, skipinitialspace=True))
    except csv.Error as error:
        if '";' in line or '",' in line or line.count('"') % 2 == 0:
            cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))  # 5" gauge
        else:
            raise InputError(
                f"a quoted cell is not closed in its line ({error})", line=number, remedy="mend the quotes"
            ) from None
    return [cell.strip() for cell in cells]


def are_types(cells: Sequence[str]) -> bool:
    """Whether a row tells the type of each column, as DIAdem does; below other words may stand what is no reading.

    >>> are_types(["DT_DATE", "DT_DOUBLE", ""]), are_types(["Float", "Float"])
    (True, False)
    """
    return any(cells) and all(re.fullmatch(r"DT_[A-Z]\w*", cell) for cell in cells if cell)


_WORDS = re.compile(r'"([^"]*)"|(\S+)')


def titles_by_gaps(line: str, count: int) -> list[str] | None:
    """Return ``count`` titles of a head whose columns white space parts, or None where that cannot be told.

    Two blanks or a tab part titles; else every word is one, but a unit in brackets belongs to the word before it.

    >>> titles_by_gaps("Tensile strain [%]   Load [N]", 2), titles_by_gaps("time (s) force (N)", 2)
    (['Tensile strain [%]', 'Load [N]'], ['time (s)', 'force (N)'])
    """
    line = line.strip()
    wide = [part.strip(' "') for part in _WIDE_GAP.split(line)]
    if len(wide) == count:
        return wide
    merged = [part.strip(' "') for part in re.split(r"\s+(?![\[({<])", line)]
    if len(merged) == count:
        return merged
    quoted = [part or word for part, word in _WORDS.findall(line)]
    return quoted if len(quoted) == count else None


def uniform(lines: Sequence[str], separator: str, width: int) -> list[list[str]] | None:
    """Return the columns of lines that all have ``width`` plain cells, or None where one has not.

    The long way round, line by line, takes a second for a table of 300 000 rows; this one a tenth.
    """
    text = "\n".join(lines)
    if '"' in text or not text:
        return None
    if separator == " ":
        rows = [line.split() for line in lines]
        return [list(cells) for cells in zip(*rows, strict=True)] if {len(row) for row in rows} == {width} else None
    if text.count(separator) != (width - 1) * len(lines):
        return None
    if width > 1 and any(line.count(separator) != width - 1 for line in lines):
        return None
    cells = text.replace("\n", separator).split(separator)
    if " " in text or ("\t" in text and separator != "\t") or "\u00a0" in text:
        cells = [cell.strip() for cell in cells]
    return [cells[place::width] for place in range(width)]
