"""Strict TOML in: the documents that people write."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from typing import Any

import tomli_w

from hyperfab.errors import InputError, placed
from hyperfab.io.text import decode_utf8

#: Levels of tables and arrays; the documents need six.
MAX_DEPTH = 32
#: People write these files; a megabyte is a mistake, and the parser's work grows faster than the file.
MAX_BYTES = 2**20

_DEEP_KEY = re.compile(rf"(?:[^.\s=\"'#]+\s*\.\s*){{{MAX_DEPTH}}}")
_NOT_FINITE = re.compile(r"(?<![\w.\"'])[+-]?(?:nan|inf)(?![\w.])")


class _NotFinite(ValueError):
    """A number that is no finite double."""


def load_toml(data: bytes, name: str) -> dict[str, Any]:
    """Read a TOML document (UTF-8).

    Raises InputError with the line for a syntax error, a key that stands twice, nan or inf, numbers no double can
    hold, nesting beyond 32 levels, more than 1 MiB.

    >>> load_toml(b'[run]\\nuntil = "3600 s"', "mold.toml")
    {'run': {'until': '3600 s'}}
    >>> load_toml(b'[run]\\nuntil = 3600 s', "mold.toml")
    Traceback (most recent call last):
    hyperfab.errors.InputError: mold.toml, line 2: is not valid TOML: expected newline or end of document after a \
statement (character 14); quantities stand in quotes: "60 mm"
    """
    with placed(name):
        value = _read(data)
    return value


def dump_toml(document: Mapping[str, Any]) -> bytes:
    """Write a document as TOML, UTF-8; the same document gives the same bytes.

    >>> print(dump_toml({"thickness": "5 mm", "fabric": {"above": "0.5 mm"}}).decode(), end="")
    thickness = "5 mm"
    <BLANKLINE>
    [fabric]
    above = "0.5 mm"
    """
    return tomli_w.dumps(document).encode("utf-8")


def _read(data: bytes) -> dict[str, Any]:
    if len(data) > MAX_BYTES:
        raise InputError(f"is larger than {MAX_BYTES // 2**20} MiB", remedy="check that it is the right file")
    text = decode_utf8(data)
    if not text.strip():
        raise InputError("is empty", remedy="a TOML document is expected")
    _refuse_deep_keys(text)
    try:
        value = tomllib.loads(text, parse_float=_float)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(error) from None
    except _NotFinite as error:
        raise InputError(
            f"{error} is not a number a document can hold", line=_line_of(text, str(error)), remedy="correct it"
        ) from None
    except RecursionError:
        raise InputError(f"is nested deeper than {MAX_DEPTH} levels", remedy="no document is") from None
    except ValueError as error:  # dates that are none, integers of thousands of digits
        raise InputError(f"is not valid TOML: {error}", remedy="correct the value") from None
    _check_values(value)
    return value


def _float(token: str) -> float:
    value = float(token)
    if not math.isfinite(value):
        raise _NotFinite(token if len(token) <= 24 else token[:21] + "...")
    return value


def _refuse_deep_keys(text: str) -> None:
    """Refuse a.b.c... without end before parsing: the parser's time grows with the square of such a key."""
    for number, line in enumerate(text.splitlines(), 1):
        if line.count(".") >= MAX_DEPTH and _DEEP_KEY.match(line.lstrip(" \t[")):
            raise InputError(f"a key is nested deeper than {MAX_DEPTH} levels", line=number, remedy="no document is")


def _check_values(root: dict[str, Any]) -> None:
    """Walk without recursion: depth, and integers that no double can hold."""
    todo: list[tuple[Any, str, int]] = [(root, "", 0)]
    while todo:
        value, path, depth = todo.pop()
        if depth > MAX_DEPTH:
            raise InputError(f"is nested deeper than {MAX_DEPTH} levels", key=path[:80], remedy="no document is")
        if isinstance(value, dict):
            todo += [(item, f"{path}.{key}" if path else key, depth + 1) for key, item in value.items()]
        elif isinstance(value, list):
            todo += [(item, f"{path}.{index}", depth + 1) for index, item in enumerate(value)]
        elif isinstance(value, int) and abs(value) >= 2**63:
            raise InputError("is an integer beyond 64 bits", key=path, remedy="correct the number")


def _syntax_error(error: tomllib.TOMLDecodeError) -> InputError:
    text = str(error)
    place = re.search(r" \(at line (\d+), column (\d+)\)$", text)
    message = text[: place.start()] if place else text.removesuffix(" (at end of document)")
    message = message[:1].lower() + message[1:]
    hint = 'quantities stand in quotes: "60 mm"' if "after a statement" in message else "correct the line"
    twice = re.search(r"cannot declare \('(\w+)',\) twice", message)
    if twice:
        hint = f"write it once, or each under [[{twice[1]}]], in two brackets, where several may stand"
    if place is None:
        return InputError(f"is not valid TOML: {message} (at its end)", remedy="is the file whole?")
    return InputError(f"is not valid TOML: {message} (character {place[2]})", line=int(place[1]), remedy=hint)


def _line_of(text: str, token: str) -> int | None:
    """Find the line of a refused number; comments and strings are stepped over as far as a line shows them."""
    for number, line in enumerate(text.splitlines(), 1):
        code = re.sub(r"\"[^\"]*\"|'[^']*'|#.*", "", line)
        if (token in code and not token.lstrip("+-").isalpha()) or _NOT_FINITE.search(code):
            return number
    return None
