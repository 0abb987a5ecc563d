"""Any bytes give a value or an InputError, in bounded time: each reader against what nobody would write."""

from __future__ import annotations

import contextlib
import json
import struct
import time
from collections.abc import Callable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hyperfab.errors import InputError
from hyperfab.io.csv_table import read_table
from hyperfab.io.csv_tests import read_tests
from hyperfab.io.json_io import load_json
from hyperfab.io.stl import read_stl
from hyperfab.io.toml_io import load_toml

GARBAGE = st.binary(max_size=300)
LINE_ENDS = st.sampled_from(["\n", "\r\n", "\r", "\n\n", ""])
CELLS = st.one_of(
    st.sampled_from(
        [
            "",
            "1.1",
            "1,2",
            "0,125",
            "1.234",
            "1.234,5",
            "nan",
            "-inf",
            "1e999",
            "−1.5",
            '"1.2"',
            '"',
            "-",
            "%",
            "x",
            "1_0",
        ]
    ),
    st.sampled_from(
        ["load", "unload", "warp", "weft", "45", "uniaxial", "shear", "[MPa]", "MPa", "(N)", "mm", "1 234,5"]
    ),
    st.floats(-1e3, 1e3).map(repr),
    st.text(max_size=5),
)
HEADINGS = st.sampled_from(
    [
        "stretch",
        "strain [%]",
        "stress [MPa]",
        "stress (kPa)",
        "true stress [psi]",
        "membrane stress [N/mm]",
        "force [N]",
        "extension [mm]",
        "stretch 2",
        "stress 2 [MPa]",
        "time [s]",
        "temperature [degC]",
        "rate [1/s]",
        "direction",
        "cycle",
        "branch",
        "specimen",
        "test",
        "stress sd [MPa]",
        "stress_MPa",
        "stress",
        "",
        "x [furlong]",
        "volume ratio",
    ]
)
COMMENTS = st.sampled_from(
    [
        "# test: shear",
        "# test: volumetric",
        "# thickness: 1 mm",
        "# width: 25",
        "# gauge length [in]: 2",
        "#",
        "# a: b: c",
        "sep=;",
    ]
)


@st.composite
def tables(draw: st.DrawFn) -> bytes:
    separator = draw(st.sampled_from([",", ";", "\t"]))
    width = draw(st.integers(1, 5))
    lines = draw(st.lists(COMMENTS, max_size=3))
    lines.append(separator.join(draw(st.lists(HEADINGS, min_size=width, max_size=width))))
    for _ in range(draw(st.integers(0, 4))):
        extra = draw(st.sampled_from([0, 0, 0, 0, 1, -1]))
        lines.append(
            separator.join(draw(st.lists(CELLS, min_size=max(width + extra, 0), max_size=max(width + extra, 0))))
        )
    text = draw(LINE_ENDS).join(lines) if len(lines) == 1 else draw(st.sampled_from(["\n", "\r\n", "\r"])).join(lines)
    return text.encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"])), "replace")


@st.composite
def surfaces(draw: st.DrawFn) -> bytes:
    numbers = st.sampled_from([0.0, 1.0, 20.0, -5.5, 1e30, float("nan"), float("inf"), -0.0])
    rows = draw(st.lists(st.lists(numbers, min_size=9, max_size=9), max_size=4))
    if draw(st.booleans()):
        count = draw(st.sampled_from([len(rows), len(rows) + 1, 0, 2**31, 2**32 - 1]))
        header = draw(st.sampled_from([b"", b"solid x\n", b"\x00"])).ljust(80)
        data = header + struct.pack("<I", count) + b"".join(struct.pack("<12fH", 0, 0, 1, *row, 0) for row in rows)
    else:
        word = draw(st.sampled_from(["vertex", "VERTEX", "vertx", ""]))
        body = "".join(
            f"facet normal 0 0 1\nouter loop\n{word} {a} {b} {c}\n"
            f"vertex {d} {e} {f}\nvertex {g} {h} {i}\nendloop\nendfacet\n"
            for a, b, c, d, e, f, g, h, i in rows
        )
        data = f"solid a\n{body}endsolid a\n".encode()
    cut = draw(st.sampled_from([len(data), len(data), len(data) - 1, len(data) // 2]))
    return data[:cut] + draw(st.sampled_from([b"", b"", b"\n", b"garbage"]))


JSON_LIKE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=4), inner, max_size=4)),
    max_leaves=12,
).map(lambda value: json.dumps(value).encode())
TOML_LIKE = st.lists(
    st.sampled_from(
        [
            "[run]",
            "[[part]]",
            "[a.b.c]",
            "x = 1",
            'until = "3600 s"',
            "y = nan",
            "z = 1e999",
            "d = 1979-05-27T07:32:00Z",
            "a.b = {c = [1, 2]}",
            "s = '''",
            'm = """',
            "x = 0x_1",
            "# comment",
            "[part",
            "= 1",
            "k = inf # c",
            "h = [[[]]]",
        ]
    ),
    max_size=8,
).map(lambda lines: "\n".join(lines).encode())


def damaged(strategy: st.SearchStrategy[bytes]) -> st.SearchStrategy[bytes]:
    """Sound data with a byte changed, or cut short, or pure garbage."""

    def spoil(data: bytes, place: int, byte: int, cut: bool) -> bytes:
        if not data:
            return data
        place %= len(data)
        return data[:place] if cut else data[:place] + bytes([byte]) + data[place + 1 :]

    return strategy | GARBAGE | st.builds(spoil, strategy, st.integers(0, 10**6), st.integers(0, 255), st.booleans())


@contextlib.contextmanager
def within(seconds: float) -> Iterator[None]:
    start = time.process_time()
    with contextlib.suppress(InputError):
        yield
    assert time.process_time() - start < seconds


@given(
    damaged(tables()),
    st.sampled_from(["uniaxial", "shear", "biaxial", "biaxial-general", "volumetric", None]),
)
def test_fabric_tests(data: bytes, test: str | None) -> None:
    with within(1.0):
        for found in read_tests(data, "a.csv", test=test):
            assert len(found.stretch) == len(found.stress) == len(found.lines)
            assert all(abs(value) < float("inf") for value in (*found.stretch, *found.stress))


@given(damaged(tables()))
def test_tables(data: bytes) -> None:
    columns = {"time": "time"}
    with within(1.0):
        read_table(data, "a.csv", columns, optional={"force": "force"}, rest="temperature", increasing="time")


@given(damaged(surfaces()))
def test_surfaces(data: bytes) -> None:
    with within(1.0):
        mesh = read_stl(data, "a.stl")
        assert len(mesh.faces) > 0
        assert mesh.faces.max() == len(mesh.vertices) - 1


@given(damaged(JSON_LIKE))
def test_json_documents(data: bytes) -> None:
    with within(1.0):
        load_json(data, "a.json")


@given(damaged(TOML_LIKE))
def test_toml_documents(data: bytes) -> None:
    with within(1.0):
        load_toml(data, "a.toml")


@pytest.mark.parametrize("read", [read_tests, read_stl, load_json, load_toml], ids=lambda read: read.__name__)
def test_every_single_byte_and_every_pair(read: Callable[[bytes, str], object]) -> None:
    for first in range(256):
        for rest in (b"", b"\x00", b"\n", b'"', b"\xff", b"#", b",", b"1"):
            with contextlib.suppress(InputError):
                read(bytes([first]) + rest, "a")
