"""Documents are strict JSON, in and out, and the same document gives the same bytes."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hyperfab.errors import InputError
from hyperfab.io.json_io import dump_json, load_json

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**40), 10**40)
    | st.floats(allow_nan=False, allow_infinity=False).map(lambda number: number + 0.0)  # no -0 is written
    | st.text(st.characters(exclude_categories=("Cs",)), max_size=12),
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(max_size=6), inner, max_size=6),
    max_leaves=40,
)


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ('{"a": 1,\n "b": {"c": 1, "c": 2}}', "line 2, key b.c", "stands twice"),
        ('{"a": [1, 2,\n NaN]}', "line 2, key a.2", "NaN"),
        ('{"a": -Infinity}', "line 1, key a", "-Infinity"),
        ('{"a": {"b": 1e999}}', "line 1, key a.b", "larger than any double"),
        ('{"a": ' + "7" * 5000 + "}", "line 1, key a", "5000 digits"),
        ('{"a": "\\ud800"}', "line 1, key a", "surrogate"),
        ('{"a": 1,\n', "line 2", "not valid JSON"),
        ('{"a": 1}\n{}', "line 2", "Extra data"),
        ("{'a': 1}", "line 1", "not valid JSON"),
        ("", "a.json", "is empty"),
        (" \n", "a.json", "is empty"),
    ],
)
def test_what_is_not_strict_json_is_refused_with_its_place(text: str, place: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        load_json(text.encode(), "a.json")
    assert place in str(caught.value)
    assert said in str(caught.value)
    assert caught.value.remedy


@pytest.mark.parametrize("opening", [b"[", b'{"a":', b'[{"a":[', b'["' + b'\\"' * 50])
def test_deep_nesting_and_endless_strings_are_refused_at_once(opening: bytes) -> None:
    start = time.process_time()
    with pytest.raises(InputError):
        load_json(opening * 100_000, "deep.json")
    assert time.process_time() - start < 1.0


def test_brackets_in_strings_are_no_nesting() -> None:
    text = json.dumps({"a": "[" * 500 + '"\\' + "{" * 500})
    assert load_json(text.encode(), "a.json")["a"].count("[") == 500


def test_nesting_as_deep_as_allowed_is_read() -> None:
    assert load_json(b"[" * 64 + b"]" * 64, "a.json")
    with pytest.raises(InputError, match="deeper than 64"):
        load_json(b"[" * 65 + b"]" * 65, "a.json")


def test_byte_order_mark_is_read_and_other_encodings_are_refused_by_line() -> None:
    assert load_json(b"\xef\xbb\xbf{}", "a.json") == {}
    with pytest.raises(InputError, match=r"line 2: is not UTF-8 text \(byte 0xB0\)"):
        load_json(b'{"a":\n"25 \xb0C"}', "a.json")


@given(st.dictionaries(st.text(st.characters(exclude_categories=("Cs",)), max_size=6), VALUES, max_size=6))
def test_what_is_written_is_read_back_bit_for_bit(document: dict) -> None:
    data = dump_json(document)
    assert repr(load_json(data, "a.json")) == repr(document)
    assert data == dump_json(json.loads(data))


def test_numbers_that_are_none_are_refused_naming_the_key() -> None:
    for value in (float("nan"), float("inf"), np.float64("nan"), np.array([1.0, np.nan])):
        with pytest.raises(ValueError, match=r"fit\.tests"):
            dump_json({"fit": {"tests": value}})
    with pytest.raises(ValueError, match=r"a\.1"):
        dump_json({"a": [1, {1, 2}]})


def test_numpy_values_are_written_as_the_numbers_they_are() -> None:
    document = {"a": np.float64(0.1), "b": np.arange(3), "c": np.bool_(True), "d": np.zeros((2, 2))}
    assert json.loads(dump_json(document)) == {
        "a": 0.1,
        "b": [0, 1, 2],
        "c": True,
        "d": [[0.0, 0.0], [0.0, 0.0]],
    }


def test_long_lists_fill_their_lines_and_none_is_overlong() -> None:
    data = dump_json({"curve": [[float(i), i / 7] for i in range(50)], "long": [i / 7 for i in range(500)]}).decode()
    assert max(map(len, data.splitlines())) <= 112
    assert len(data.splitlines()) < 150
    assert json.loads(data)["long"][3] == 3 / 7


def test_large_documents_are_read_in_time() -> None:
    data = dump_json({"curve": [[float(i), i / 7.0] for i in range(100_000)]})
    start = time.process_time()
    load_json(data, "a.json")
    assert time.process_time() - start < 2.0
