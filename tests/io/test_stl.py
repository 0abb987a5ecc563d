"""STL surfaces are read as they are: what a header claims, a truncated file hides or a count promises is checked."""

from __future__ import annotations

import struct
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from hyperfab.errors import InputError, UsageError
from hyperfab.io.stl import SurfaceMesh, read_stl
from hyperfab.io.stl_write import stl_bytes

#: A cube of side 20 mm, wound outward.
CORNERS = 20.0 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
FACES = np.array([face for a, b, c, d in QUADS for face in ((a, b, c), (a, c, d))])
CUBE = stl_bytes(CORNERS, FACES)


def text(mesh: SurfaceMesh, name: bytes = b"cube") -> bytes:
    """The mesh as ASCII STL, with every digit of its coordinates."""
    lines = [b"solid " + name]
    for face in mesh.faces:
        lines += [b"facet normal 0 0 0", b"  outer loop"]
        lines += [b"    vertex %s %s %s" % tuple(repr(float(x)).encode() for x in mesh.vertices[node]) for node in face]
        lines += [b"  endloop", b"endfacet"]
    return b"\n".join([*lines, b"endsolid " + name, b""])


def volume(mesh: SurfaceMesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_a_cube_is_read_with_each_corner_once_and_its_winding() -> None:
    mesh = read_stl(CUBE, "cube.stl")
    assert mesh.vertices.shape == (8, 3)
    assert mesh.faces.shape == (12, 3)
    assert volume(mesh) == pytest.approx(8000.0, rel=1e-15)
    assert mesh.questions == ()
    assert np.array_equal(mesh.vertices[mesh.faces], CORNERS[FACES])


@pytest.mark.parametrize("ends", [b"\n", b"\r\n", b"\r", b" \t\n"])
@pytest.mark.parametrize("case", [bytes.lower, bytes.upper])
def test_text_and_binary_give_the_same_surface(ends: bytes, case: object) -> None:
    mesh = read_stl(CUBE, "cube.stl")
    found = read_stl(case(text(mesh)).replace(b"\n", ends), "cube.stl")  # type: ignore[operator]
    assert np.array_equal(found.vertices, mesh.vertices)
    assert np.array_equal(found.faces, mesh.faces)


def test_a_text_may_begin_with_a_byte_order_mark() -> None:
    mesh = read_stl(CUBE, "cube.stl")
    found = read_stl(b"\xef\xbb\xbf" + text(mesh), "cube.stl")
    assert np.array_equal(found.vertices, mesh.vertices)


def test_a_text_of_two_solids_is_one_surface() -> None:
    mesh = read_stl(CUBE, "cube.stl")
    both = read_stl(text(mesh, b"one") + text(mesh, b"facet normal two"), "two.stl")
    assert (len(both.vertices), len(both.faces)) == (8, 24)


def test_a_binary_header_may_lie() -> None:
    for header in (b"solid cube", b"solid\nfacet normal", b"\xff" * 80):
        mesh = read_stl(header[:80].ljust(80) + CUBE[80:], "cube.stl")
        assert volume(mesh) == pytest.approx(8000.0)


def test_units_scale_and_odd_sizes_are_questioned() -> None:
    assert volume(read_stl(CUBE, "cube.stl", unit="cm")) == pytest.approx(8.0e6)
    assert read_stl(CUBE, "cube.stl", unit="inch").vertices.max() == 508.0
    [question] = read_stl(CUBE, "cube.stl", unit="m").questions
    assert question == (
        "cube.stl: measures 2e+04 x 2e+04 x 2e+04 mm when read in m; "
        "if that is not so, say --stl-unit (mm, cm, m, inch)"
    )
    [question] = read_stl(CUBE, "cube.stl", unit="um").questions
    assert "0.02 x 0.02 x 0.02 mm" in question
    with pytest.raises(UsageError, match="--stl-unit spoon"):
        read_stl(CUBE, "cube.stl", unit="spoon")


def test_facets_without_an_area_are_left_out_and_counted() -> None:
    faces = np.vstack([FACES, [[0, 0, 1], [2, 2, 2]]])
    mesh = read_stl(stl_bytes(CORNERS, faces), "cube.stl")
    assert (len(mesh.faces), mesh.facets) == (12, 14)
    assert mesh.facet_of_face.tolist() == list(range(12))
    assert mesh.questions == ("cube.stl: 2 of 14 facets have two corners in one place and were left out",)


def test_bytes_behind_the_last_facet_are_told() -> None:
    assert "3 bytes behind the last facet" in read_stl(CUBE + b"end", "cube.stl").questions[0]


def test_zero_and_minus_zero_are_one_place() -> None:
    data = CUBE.replace(struct.pack("<f", 0.0), struct.pack("<f", -0.0), 5)
    assert len(read_stl(data, "cube.stl").vertices) == 8


def facet(*corners: float) -> bytes:
    return struct.pack("<12fH", 0, 0, 0, *corners, 0)


def binary(count: int, *facets: bytes) -> bytes:
    return bytes(80) + struct.pack("<I", count) + b"".join(facets)


GOOD = facet(0, 0, 0, 9, 0, 0, 0, 9, 0)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "is empty"),
        (b"   \n", "is empty"),
        (b"hello", "is no STL file"),
        (bytes(84), "has no facets"),
        (b"solid a\nendsolid a\n", "has no facets"),
        (binary(2**31, GOOD), "facet 2: claims 2147483648 facets and has room for 1"),
        (binary(2**32 - 1, GOOD), "claims 4294967295"),
        (CUBE[:-1], "facet 12: claims 12 facets and has room for 11"),
        (CUBE[:90], "facet 1: claims 12 facets and has room for 0"),
        (binary(1, facet(0, 0, 0, 9, 0, float("nan"), 0, 9, 0)), "facet 1: a corner is not finite"),
        (binary(2, GOOD, facet(0, 0, 0, 9, 0, 0, float("inf"), 9, 0)), "facet 2: a corner is not finite"),
        (binary(1, facet(1, 1, 1, 1, 1, 1, 2, 2, 2)), "none has an area"),
        (b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", "line 2"),
        (text(read_stl(CUBE, "c"))[:-20], "line 79: facet 12 is not complete"),
        (
            text(read_stl(CUBE, "c")).replace(b"vertex", b"vertx", 4).replace(b"vertx", b"vertex", 3),
            "facet 2 is not",
        ),
        (text(read_stl(CUBE, "c")).replace(b"20.0", b"2O.0", 1), "facet 1: 2O.0 is no coordinate"),
        (text(read_stl(CUBE, "c")).replace(b"20.0", b"nan", 1), "facet 1: a corner is not finite"),
        (b"solid " + b"x" * 10**6, "expected a line that starts with solid"),
        (b"solid a\n" + b" " * 10**6 + b"facet", "line 2"),
        (b"solid a\nfacet normal " + b"1 " * 10**6, "line 2"),
    ],
)
def test_what_is_no_surface_is_refused_with_its_place(data: bytes, said: str) -> None:
    start = time.process_time()
    with pytest.raises(InputError, match=said) as caught:
        read_stl(data, "a.stl")
    assert str(caught.value).startswith("a.stl")
    assert caught.value.remedy
    assert time.process_time() - start < 0.5


def grid(n: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    x, y = np.meshgrid(np.linspace(0, 100, n), np.linspace(0, 100, n), indexing="ij")
    node = np.arange(n * n).reshape(n, n)
    a, b, c, d = node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]
    faces = np.concatenate([np.stack(corner, -1).reshape(-1, 3) for corner in ((a, b, c), (a, c, d))])
    return np.stack([x.ravel(), y.ravel(), np.sin(x / 10).ravel()], axis=1), faces


def test_a_million_facets_are_read_in_seconds() -> None:
    data = stl_bytes(*grid(708))
    start = time.process_time()
    mesh = read_stl(data, "large.stl")
    assert time.process_time() - start < 3.0  # 0.7 s on one free core
    assert len(mesh.vertices) == 708**2


@given(st.lists(st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, 2.5, 1e-30, -3e38])] * 9), min_size=1, max_size=12))
def test_merging_changes_no_coordinate_and_leaves_no_place_twice(corners: list[tuple[float, ...]]) -> None:
    data = binary(len(corners), *(facet(*row) for row in corners))
    given_corners = np.array(corners, dtype=np.float32).astype(float).reshape(-1, 3, 3)
    try:
        mesh = read_stl(data, "a.stl")
    except InputError:
        assert all(len({row[i : i + 3] for i in (0, 3, 6)}) < 3 for row in (tuple(x + 0.0 for x in r) for r in corners))
        return
    assert np.array_equal(mesh.vertices[mesh.faces], given_corners[mesh.facet_of_face])
    assert len({tuple(vertex) for vertex in mesh.vertices.tolist()}) == len(mesh.vertices)


def test_a_facet_is_left_out_whichever_two_of_its_corners_are_one() -> None:
    a, b, c = (0.0, 0.0, 0.0), (50.0, 0.0, 0.0), (0.0, 50.0, 0.0)
    data = binary(4, facet(*a, *b, *c), facet(*a, *a, *b), facet(*a, *b, *b), facet(*a, *b, *a))
    found = read_stl(data, "four.stl", "mm")
    assert found.faces.shape == (1, 3)
    assert any("3 of 4 facets have two corners in one place" in line for line in found.questions)
    assert found.facet_of_face.tolist() == [0]
