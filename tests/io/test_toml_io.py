"""TOML documents are read strictly, and refused with the line."""

from __future__ import annotations

import time

import pytest

from hyperfab.errors import InputError
from hyperfab.io.toml_io import load_toml


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ("[run]\nuntil = 3600 s\n", "line 2", "quantities stand in quotes"),
        ("[run]\na = 1\na = 2\n", "line 3", "overwrite"),
        ("[run]\n[run]\n", "line 2", "declare"),
        ("x = 1\n\ny = nan\n", "line 3", "nan is not a number"),
        ("x = [1.0,\n -inf]\n", "line 2", "-inf is not a number"),
        ("x = 1e999\n", "line 1", "1e999"),
        ('s = "nan" # inf\nx = inf\n', "line 2", "inf"),
        ("x = 99999999999999999999\n", "key x", "64 bits"),
        ("a = [{ b = 99999999999999999999 }]\n", "key a.0.b", "64 bits"),
        ("x = " + "9" * 5000 + "\n", "mold.toml", "not valid TOML"),
        ('s = "unclosed\n', "line 1", "illegal character"),
        ('[run]\nuntil = "3600 s', "mold.toml", "at its end"),
        ("", "mold.toml", "is empty"),
        ("when = 2020-13-45\n", "mold.toml", "not valid TOML"),
    ],
)
def test_what_is_not_sound_is_refused_with_its_place(text: str, place: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        load_toml(text.encode(), "mold.toml")
    assert place in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 100_000,
        "x = " + "{a=" * 100_000,
        ".".join("a" * 100_000) + " = 1",
        "[" + ".".join("a" * 50_000) + "]",
        "[" * 100_000,
        "\n".join(f"[t{i}]\nx={i}" for i in range(20_000)) + "\ny = [",
    ],
)
def test_hostile_nesting_is_refused_at_once(text: str) -> None:
    start = time.process_time()
    with pytest.raises(InputError):
        load_toml(text.encode(), "mold.toml")
    assert time.process_time() - start < 1.5


def test_byte_order_mark_and_line_ends_are_read() -> None:
    assert load_toml(b'\xef\xbb\xbf[run]\r\nuntil = "1 h"\r\n', "mold.toml") == {"run": {"until": "1 h"}}
