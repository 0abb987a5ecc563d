"""Triangle surfaces from STL files, ASCII and binary, read as they are and not as their headers claim."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError, UsageError, placed
from hyperfab.io.unit_table import UnitError
from hyperfab.io.units import column_factor

#: More than any mold needs; beyond, memory and not the file decides.
MAX_FACETS = 4_000_000
#: A mold is larger than this and smaller than that [mm]; otherwise the unit is in doubt.
SIZE_RANGE = (1.0, 10_000.0)

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
_NUMBERS = rb"\s+(\S+)\s+(\S+)\s+(\S+)"
_FACET = re.compile(
    rb"\s*facet\s+normal\s+\S+\s+\S+\s+\S+\s+outer\s+loop\s+vertex" + _NUMBERS + rb"\s+vertex" + _NUMBERS
    + rb"\s+vertex" + _NUMBERS + rb"\s+endloop\s+endfacet(?=\s)",
    re.IGNORECASE,
)  # fmt: skip
_SOLID = re.compile(rb"\s*solid(?=\s)[^\n]*\n", re.IGNORECASE)
_ENDSOLID = re.compile(rb"\s*endsolid(?:[ \t][^\n]*)?(?:\n|\Z)", re.IGNORECASE)


#: How other surfaces begin, and what they are.
_OTHERS = (
    (re.compile(rb"(?:\s|#[^\n]*\n|(?:mtllib|usemtl|o|g|s)\s[^\n]*\n)*v\s+[-+.\d]"), "OBJ (Wavefront)"),
    (re.compile(rb"ply\s"), "PLY"),
    (re.compile(rb"OFF\s"), "OFF"),
    (re.compile(rb"\s*ISO-10303"), "STEP"),
    (re.compile(rb"PK\x03\x04"), "3MF or another ZIP archive"),
)


@dataclass(frozen=True)
class SurfaceMesh:
    """A triangle surface: ``vertices`` (n, 3) [mm], each place once, and ``faces`` (m, 3), corners in file order.

    ``facets`` is the number in the file, ``facet_of_face`` the place of each face in it: facets two of whose corners
    are one place have no face. ``questions`` are doubts the user should hear.
    """

    vertices: Array
    faces: Ints
    facets: int
    facet_of_face: Ints
    questions: tuple[str, ...]


def read_stl(data: bytes, name: str, unit: str = "mm") -> SurfaceMesh:
    """Read an STL file; ``unit`` is the unit of its numbers (STL states none).

    Corners with the same coordinates become one vertex: exactly equal, nothing is snapped. Stored normals are
    ignored, the winding counts.

    Raises InputError, naming the facet or line, for a file that is truncated, claims another number of facets than
    it has, holds NaN or infinite coordinates, or no facet with an area; UsageError for a unit that is no length.

    >>> from hyperfab.io.stl_write import stl_bytes
    >>> mesh = read_stl(stl_bytes(20.0 * np.eye(3), np.array([[0, 1, 2]])), "corner.stl", unit="cm")
    >>> mesh.vertices.max(), mesh.faces
    (np.float64(200.0), array([[0, 1, 2]]))
    """
    factor = _unit(unit)
    with placed(name):
        corners, questions = _corners(data, name)
        _check_finite(corners)
        vertices, faces = _merge(corners)
        whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        facets = len(faces)
        if not whole.any():
            raise InputError(f"has {facets} facets, and none has an area", remedy="export the surface again")
    if not whole.all():
        collapsed = facets - int(whole.sum())
        questions.append(f"{name}: {collapsed} of {facets} facets have two corners in one place and were left out")
    vertices = vertices.astype(np.float64) * float(factor)
    questions += _size_questions(vertices, name, unit)
    return SurfaceMesh(vertices, faces[whole], facets, np.flatnonzero(whole), tuple(questions))


def _unit(unit: str) -> Fraction:
    try:
        factor, _ = column_factor(unit, "length")
    except UnitError:
        raise UsageError(f"--stl-unit {unit[:40]}: is no length; write mm, cm, m or inch") from None
    return factor


def _corners(data: bytes, name: str) -> tuple[NDArray, list[str]]:
    """Return the corners (m, 3, 3) in the file's own precision; the length of the file decides what it is."""
    if not data.strip():
        raise InputError("is empty", remedy="an STL surface is expected")
    data = data.removeprefix(codecs.BOM_UTF8)
    claimed = int.from_bytes(data[80:84], "little") if len(data) >= _HEADER else -1
    size = _HEADER + 50 * claimed
    text = b"\x00" not in data[:2048]
    looks_ascii = text and data[:512].lstrip()[:5].lower() == b"solid"
    if claimed >= 0 and len(data) == size:
        return _binary(data, claimed), []
    for start, what in _OTHERS:
        if start.match(data[:65536]):
            raise InputError(f"is {what}, no STL", remedy="export the surface as STL")
    if looks_ascii:
        return _ascii(data), []
    if claimed < 0:
        raise InputError("is no STL file: it has neither the text nor the header of one", remedy="export it as STL")
    room = (len(data) - _HEADER) // 50
    if claimed > room and text:
        raise InputError("is text, no STL", remedy="give the surface, exported as STL")
    if claimed > room:
        raise InputError(
            f"claims {claimed} facets and has room for {room}",
            facet=room + 1,
            remedy="the file is truncated or no STL; export or copy it again",
        )
    return _binary(data, claimed), [f"{name}: {len(data) - size} bytes behind the last facet were ignored"]


def _binary(data: bytes, count: int) -> NDArray[np.float32]:
    _check_count(count)
    return np.frombuffer(data, dtype=_RECORD, count=count, offset=_HEADER)["corners"]


def _check_count(count: int) -> None:
    if count == 0:
        raise InputError("has no facets", remedy="export the surface again")
    if count > MAX_FACETS:
        raise InputError(f"has {count} facets, more than {MAX_FACETS}", remedy="export it coarser")


def _ascii(data: bytes) -> Array:
    found: list[tuple[bytes, ...]] = []
    place = 0
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    end = len(data.rstrip())
    while place < end:
        start = _SOLID.match(data, place)
        if start is None:
            raise _bad_text("expected a line that starts with solid", data, place)
        place = start.end()
        while facet := _FACET.match(data, place):
            found.append(facet.groups())
            place = facet.end()
            if len(found) > MAX_FACETS:
                _check_count(len(found))
        stop = _ENDSOLID.match(data, place)
        if stop is None:
            what = "the file ends in the middle" if place >= end else f"facet {len(found) + 1} is not complete"
            raise _bad_text(f"{what}: neither a whole facet nor endsolid", data, place)
        place = stop.end()
    _check_count(len(found))
    flat = [token for facet in found for token in facet]
    try:
        return np.array(list(map(float, flat))).reshape(-1, 3, 3)
    except ValueError:
        bad = next(index for index, token in enumerate(flat) if not _is_float(token))
        shown = flat[bad][:40].decode("ascii", "replace")
        raise InputError(f"{shown} is no coordinate", facet=bad // 9 + 1, remedy="export the surface again") from None


def _is_float(token: bytes) -> bool:
    try:
        float(token)
    except ValueError:
        return False
    return True


def _bad_text(message: str, data: bytes, place: int) -> InputError:
    place += len(data[place : place + 4096]) - len(data[place : place + 4096].lstrip())
    line = data.count(b"\n", 0, place) + 1
    return InputError(message, line=line, remedy="the file is truncated or damaged; export it again")


def _check_finite(corners: NDArray) -> None:
    bad = np.flatnonzero(~np.isfinite(corners).reshape(len(corners), 9).all(axis=1))
    if bad.size:
        raise InputError(
            f"a corner is not finite ({bad.size} such facets)",
            facet=int(bad[0]) + 1,
            remedy="export or repair the surface",
        )


def _merge(corners: NDArray) -> tuple[NDArray, Ints]:
    """Return each place once, in the order of first use, and the corners' indices.

    Places are grouped by a hash of their bits (one sort of integers), and the groups checked; should two places
    share a hash, all three coordinates are sorted.
    """
    points = np.ascontiguousarray(corners.reshape(-1, 3)) + corners.dtype.type(0.0)  # -0 becomes 0
    bits = points.view(np.uint32 if points.dtype.itemsize == 4 else np.uint64).astype(np.uint64)
    mixed = bits[:, 0] * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(29)) ^ bits[:, 1]) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(32)) ^ bits[:, 2]) * np.uint64(0x94D049BB133111EB)
    _, first, inverse = np.unique(mixed, return_index=True, return_inverse=True)
    if not np.array_equal(points[first][inverse], points):
        _, first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
        inverse = inverse.reshape(-1)
    order = np.argsort(first, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return points[first[order]], rank[inverse].reshape(-1, 3)


def _size_questions(vertices: Array, name: str, unit: str) -> list[str]:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    extent = high - low
    if SIZE_RANGE[0] <= extent.max() <= SIZE_RANGE[1]:
        return []
    sides = " x ".join(f"{side:.3g}" for side in extent)
    return [f"{name}: measures {sides} mm when read in {unit}; if that is not so, say --stl-unit (mm, cm, m, inch)"]
