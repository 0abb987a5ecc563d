"""Strict JSON in, strict and deterministic JSON out."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from json.encoder import encode_basestring_ascii
from typing import Any, NoReturn

from hyperfab.errors import InputError, placed
from hyperfab.io.text import decode_utf8, position

#: Documents are a few levels deep; a deeper one is a mistake or an attack.
MAX_DEPTH = 64
#: A document is a summary: fields live beside it. Nothing legitimate comes near this.
MAX_BYTES = 64 * 2**20
#: Lines of the written document are no longer than this where a list can be broken.
WIDTH = 110

# The closing quote is optional so that an unterminated string is swallowed once, not once per quote in it.
_BRACKETS = re.compile(r'"(?:[^"\\]++|\\.)*+"?|[\[{]|[\]}]', re.DOTALL)
_TOKENS = re.compile(r'"(?:[^"\\]++|\\.)*+"?|[\[\]{}:,]|[^\s\[\]{}:,"]++', re.DOTALL)


class _Refused(ValueError):
    """A hook of the parser met something JSON allows to be read but not to be meant."""

    def __init__(self, message: str, token: str, remedy: str) -> None:
        super().__init__(message)
        self.token = token
        self.remedy = remedy


def load_json(data: bytes, name: str) -> Any:
    """Read a JSON document (UTF-8, a byte-order mark is allowed).

    Raises InputError, with line and key, for anything but strict JSON: NaN and Infinity, numbers no double can
    hold, duplicate keys, nesting beyond 64 levels, more than 64 MiB.

    >>> load_json(b'{"force_N": 41.5}', "contact.json")
    {'force_N': 41.5}
    >>> load_json(b'{"a": 1, "a": 2}', "contact.json")
    Traceback (most recent call last):
    hyperfab.errors.InputError: contact.json, line 1, key a: stands twice (character 10); keep one of them
    """
    with placed(name):
        value = _read(data)
    return value


def dump_json(document: Mapping[str, Any]) -> bytes:
    """Write a document as UTF-8 JSON: keys in their order, two-space indentation, lists of numbers on full lines.

    numpy scalars and arrays are written as numbers and lists. The same document gives the same bytes; reading them
    gives the same doubles. Raises ValueError naming the key where a number is NaN or infinite: what was not computed
    is left out of a document, not filled in.

    >>> print(dump_json({"depth_mm": [0.0, 20.0], "converged": True}).decode(), end="")
    {
      "depth_mm": [0.0, 20.0],
      "converged": true
    }
    """
    return ("".join(_encode(document, "", 0)) + "\n").encode("ascii")


def _read(data: bytes) -> Any:
    if len(data) > MAX_BYTES:
        raise InputError(f"is larger than {MAX_BYTES // 2**20} MiB", remedy="a document is a summary; check the file")
    text = decode_utf8(data)
    if not text.strip():
        raise InputError("is empty", remedy="a JSON document is expected")
    _check_depth(text)
    try:
        value = json.loads(text, object_pairs_hook=_pairs, parse_float=_float, parse_int=_int, parse_constant=_constant)
        if "\\u" in text:
            _check_surrogates(value)
    except _Refused as error:
        raise _located(error, text) from None
    except json.JSONDecodeError as error:
        if not text[: error.pos].strip():
            raise InputError(
                "is no document",
                remedy="give one that a command wrote (hf fit makes one of a test), or one in TOML named .toml",
            ) from None
        line, character = position(text, error.pos)
        raise InputError(
            f"is not valid JSON: {error.msg} (character {character})",
            line=line,
            remedy="a truncated or hand-edited file? make the document again",
        ) from None
    return value


def _check_depth(text: str) -> None:
    if text.count("[") + text.count("{") <= MAX_DEPTH:
        return
    depth = 0
    for match in _BRACKETS.finditer(text):
        first = match[0][0]
        if first in "[{":
            depth += 1
            if depth > MAX_DEPTH:
                line, character = position(text, match.start())
                raise InputError(
                    f"is nested deeper than {MAX_DEPTH} levels (character {character})",
                    line=line,
                    remedy="no document is; check the file",
                )
        elif first in "]}":
            depth -= 1


def _pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise _Refused("stands twice", "duplicate", "keep one of them")
            seen.add(key)
    return found


def _float(token: str) -> float:
    value = float(token)
    if math.isinf(value):
        raise _Refused(f"{_short(token)} is larger than any double", token, "correct the number")
    return value


def _int(token: str) -> int:
    if len(token) > 300:
        raise _Refused(f"{_short(token)} is an integer of {len(token)} digits", token, "correct the number")
    return int(token)


def _constant(token: str) -> NoReturn:
    raise _Refused(f"{token} is not JSON", token, "leave the key out where there is no value")


def _check_surrogates(value: object) -> None:
    try:
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError:
        raise _Refused("half of a surrogate pair in a string", r"\u", "correct the escape") from None


def _located(error: _Refused, text: str) -> InputError:
    """Find where the refused token stands: the slow way, only once something was refused."""
    for path, offset, token in _walk(text):
        duplicate = error.token == "duplicate" and token == "duplicate"
        surrogate = error.token == r"\u" and re.search(r"\\u[dD][89a-fA-F]", token) is not None
        if duplicate or surrogate or (token == error.token and token != "duplicate"):
            line, character = position(text, offset)
            return InputError(f"{error} (character {character})", line=line, key=path or None, remedy=error.remedy)
    return InputError(str(error), remedy=error.remedy)


def _walk(text: str) -> Iterator[tuple[str, int, str]]:
    """Yield (key path, offset, token) of every scalar, and token "duplicate" at a key that stands twice."""
    stack: list[tuple[set[str] | None, list[str | int]]] = []  # (keys of an object or None for a list, [current])
    expect_key = False
    for match in _TOKENS.finditer(text):
        token = match[0]
        if token == "{":
            stack.append((set(), [""]))
            expect_key = True
        elif token == "[":
            stack.append((None, [0]))
            expect_key = False
        elif token in "]}":
            if stack:
                stack.pop()
            expect_key = False
        elif token == ",":
            if stack and stack[-1][0] is None:
                current = stack[-1][1]
                current[0] = int(current[0]) + 1
            else:
                expect_key = True
        elif token == ":":
            expect_key = False
        elif expect_key and stack and stack[-1][0] is not None:
            try:
                key = str(json.loads(token))
            except json.JSONDecodeError:
                key = token
            keys = stack[-1][0]
            stack[-1][1][0] = key
            if key in keys:
                yield _path(stack), match.start(), "duplicate"
            keys.add(key)
        else:
            yield _path(stack), match.start(), token


def _path(stack: list[tuple[set[str] | None, list[str | int]]]) -> str:
    return ".".join(str(current[0]) for _, current in stack)[:200]


def _short(token: str) -> str:
    return token if len(token) <= 24 else token[:21] + "..."


def _encode(value: Any, path: str, level: int) -> Iterator[str]:
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, Mapping):
        yield from _encode_object(value, path, level)
    elif isinstance(value, (list, tuple)):
        yield from _encode_list(value, path, level)
    else:
        yield _scalar(value, path)


def _encode_object(value: Mapping[str, Any], path: str, level: int) -> Iterator[str]:
    if not value:
        yield "{}"
        return
    pad = "  " * (level + 1)
    separator = "{\n"
    for key, item in value.items():
        if not isinstance(key, str):
            raise ValueError(f"{path or 'document'}: the key {key!r} is not a string")
        yield f"{separator}{pad}{encode_basestring_ascii(key)}: "
        yield from _encode(item, f"{path}.{key}" if path else key, level + 1)
        separator = ",\n"
    yield "\n" + "  " * level + "}"


def _encode_list(value: list[Any] | tuple[Any, ...], path: str, level: int) -> Iterator[str]:
    items = ["".join(_encode(item, f"{path}.{index}", level + 1)) for index, item in enumerate(value)]
    line = f"[{', '.join(items)}]"
    if len(line) + 2 * level <= WIDTH and "\n" not in line and "{" not in line:
        yield line
        return
    pad = "\n" + "  " * (level + 1)
    if any("\n" in item or item.startswith(("[", "{")) for item in items):
        yield f"[{pad}" + f",{pad}".join(items)
    else:
        yield "[" + pad + _filled(items, pad, WIDTH - 2 * level - 2)
    yield "\n" + "  " * level + "]"


def _filled(items: list[str], pad: str, width: int) -> str:
    """Join numbers and words into full lines."""
    lines: list[str] = []
    current: list[str] = []
    used = 0
    for item in items:
        if current and used + len(item) + 2 > width:
            lines.append(", ".join(current))
            current, used = [], 0
        current.append(item)
        used += len(item) + 2
    lines.append(", ".join(current))
    return f",{pad}".join(lines)


def _scalar(value: object, path: str) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return encode_basestring_ascii(value)
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{path or 'document'} is {value}: JSON has no such number, leave the key out")
        return float.__repr__(value + 0.0)  # no -0
    raise ValueError(f"{path or 'document'}: a {type(value).__name__} cannot be written to JSON")
