"""Bytes to text, where in a text something stands, and the texts of plain data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hyperfab.errors import InputError


def decode_utf8(data: bytes) -> str:
    """Return the text of a UTF-8 file, without its byte-order mark; InputError naming the line where it is not UTF-8.

    >>> decode_utf8(bytes([0xEF, 0xBB, 0xBF]) + b"{}")
    '{}'
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"is not UTF-8 text (byte 0x{data[error.start]:02X})", line=line, remedy="save it as UTF-8"
        ) from None


def position(text: str, offset: int) -> tuple[int, int]:
    """Return the line and the character in the line of ``offset``, both counted from 1.

    >>> position("ab\\ncd", 4)
    (2, 2)
    """
    return text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset)


def number_of_rows(count: int) -> str:
    """Return a number of rows in words.

    >>> number_of_rows(1), number_of_rows(240)
    ('1 row', '240 rows')
    """
    return f"{count} row{'' if count == 1 else 's'}"


def map_texts(value: Any, change: Callable[[str], str]) -> Any:
    """Return plain data with every text in it changed; keys stay.

    >>> map_texts({"a": ["x", 1]}, str.upper)
    {'a': ['X', 1]}
    """
    if isinstance(value, str):
        return change(value)
    if isinstance(value, dict):
        return {key: map_texts(item, change) for key, item in value.items()}
    if isinstance(value, list):
        return [map_texts(item, change) for item in value]
    return value
