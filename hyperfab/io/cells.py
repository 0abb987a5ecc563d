"""What a cell by itself looks like, and a column of them."""

from __future__ import annotations

import re
from collections.abc import Sequence

_NUMBER = re.compile(r"[+-]?(?:\d[\d.,' \u00a0\u202f]*|[.,]\d+)(?:[eE][+-]?\d+)?\s?%?")
#: A day, a time of day or both, with the zone: 4.5.2026 9:30, 2026-05-04T09:30:00.5+02:00, 9:30 a. m.; what stands in
#: two parts may have a fraction, and some loggers part that by a colon.
MOMENT = re.compile(
    r"(?P<date>\d{1,4}[-./]\d{1,2}[-./]\d{1,4})?[T ]*"
    r"(?:(?P<h>\d{1,4}):(?P<m>\d{2})(?::(?P<s>\d{2}))?(?P<part>[.,:]\d+)?)?"
    r"\s?(?P<half>[AaPp]\.?\s?[Mm]\.?)?(?:Z|(?P<zone>[+-]\d{2}:?\d{2}))?"
)
#: The same in letters: 9h58m41s, 2 m 10.5 s.
SPELLED = re.compile(
    r"(?:(?P<h>\d{1,4})\s?h\s?)?(?P<m>\d{1,4})\s?m(?:in)?\s?(?P<s>\d{1,2})(?P<part>[.,]\d+)?\s?s(?:ec)?"
)
_PLAIN = re.compile(r"[-+]?\d*[.,]?\d+(?:[eE][-+]?\d+)?")
#: What spreadsheets and machines write where there is no reading, or one beyond the range of the instrument.
NO_READING = re.compile(
    r"#?(?:n/?a|nv|div/0!?|¡?div/0!|value!?|valor!|wert!|valeur!|valore!|ref!|num!|zahl!|null!|name\?|n\.a\.|n\.d\.|nd|k\.a\.)"
    r"|-+|\*+|#+|[–—]|ovl|ol|(?:over|under)(?:load|flow| ?range)?|open|burn[ -]?out|err(?:or)?|nan|none|null|inf"
    r"|> ?\d[\d.,]*",
    re.IGNORECASE,
)

#: What to write in place of cells that say something, and no number.
INSTEAD = (
    (re.compile(r"yes|no|ja|nein|oui|non|s[ií]|n[aã]o|sim|true|false", re.IGNORECASE), "write 1 for yes and 0 for no"),
    (re.compile(r"[<≤] ?[\d.,]+"), "write 0 where less is there than the instrument shows"),
)


def is_number(cell: str) -> bool:
    """Whether a cell looks like a number in any country's writing."""
    return _NUMBER.fullmatch(cell) is not None


def is_clock(cell: str) -> bool:
    """Whether a cell is a date, a time of day, or both."""
    dated = ":" in cell or cell.count(".") == 2 or cell.count("-") == 2 or cell.count("/") == 2
    return len(cell) > 3 and ((dated and MOMENT.fullmatch(cell) is not None) or SPELLED.fullmatch(cell) is not None)


def shape(cells: Sequence[str], title: str = "", stress: Sequence[str] = ()) -> str:
    """Return the name that the first readings of a column of stretches suggest, and those of the ``stress`` beside.

    What is called a stretch and begins at nothing is a strain, as a share however large. What is one where the stress
    is least, and nowhere nothing, is a stretch that a compression began.
    """
    values = plain_values(cells)
    if values and max(values) < 20.0 and (values[0] >= 0.9 or is_one_at_rest(cells, stress)):
        return "stretch"
    percent = max(values, default=0.0) > 3.0 and "stretch" not in title.casefold()
    return "strain [%]" if percent else "strain [-]"


def is_one_at_rest(cells: Sequence[str], stress: Sequence[str]) -> bool:
    """Return whether a column is above nothing throughout, and near one where the stress beside it is least."""
    pairs = [
        (abs(other), value)
        for one, two in zip(cells, stress, strict=False)
        for value, other in zip(plain_values([one]), plain_values([two]), strict=False)
    ]
    return bool(pairs) and min(value for _, value in pairs) > 0.0 and abs(min(pairs)[1] - 1.0) < 0.1


def is_length(cells: Sequence[str]) -> bool:
    """Whether a column begins with more than it changes by: a length itself, no change of one."""
    values = plain_values(cells)
    return bool(values) and values[0] > max(values) - min(values) > 0.0


def plain_values(cells: Sequence[str]) -> list[float]:
    """Return the numbers of a column that have no thousands separator, whichever their decimal mark."""
    return [float(cell.replace(",", ".")) for cell in cells if _PLAIN.fullmatch(cell)]
