"""What a cell by itself looks like."""

from __future__ import annotations

import re

_NUMBER = re.compile(r"[+-]?(?:\d[\d.,' \u00a0\u202f]*|[.,]\d+)(?:[eE][+-]?\d+)?\s?%?")
_CLOCK = re.compile(
    r"(?:\d{1,4}[-./]\d{1,2}[-./]\d{1,4})?[T ]*(?:\d{1,3}:\d{2}(?::\d{2}(?:[.,]\d+)?)?)?\s?(?:[AaPp]\.?[Mm]\.?)?"
)
#: What spreadsheets and machines write where there is no reading.
NO_READING = re.compile(
    r"#?(?:n/?a|nv|div/0!?|¡?div/0!|value!?|valor!|wert!|valeur!|valore!|ref!|num!|zahl!|null!|name\?|n\.a\.|n\.d\.|nd|k\.a\.)|-{1,4}|\*+|#+|[–—]|ovl|overload|nan|none|null|inf",
    re.IGNORECASE,
)


def is_number(cell: str) -> bool:
    """Whether a cell looks like a number in any country's writing."""
    return _NUMBER.fullmatch(cell) is not None


def is_clock(cell: str) -> bool:
    """Whether a cell is a date, a time of day, or both."""
    return (
        len(cell) > 3
        and (":" in cell or cell.count(".") == 2 or cell.count("-") == 2 or cell.count("/") == 2)
        and (_CLOCK.fullmatch(cell) is not None)
    )
