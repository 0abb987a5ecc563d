"""Reading of the unstructured grids that hf writes (.vtu, VTK's XML form with compressed inline arrays)."""

from __future__ import annotations

import base64
import binascii
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.io.vtu import CELL_TYPES

_TYPES = {"Float64": "<f8", "Float32": "<f4", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}
#: No array of a grid is larger: a small file must not unpack into all of the memory.
_MAX_BYTES = 2**31


@dataclass(frozen=True)
class Grid:
    """``points`` (n, 3), ``cells`` by type (m, nodes), and the named arrays of points and cells."""

    points: Array
    cells: dict[str, Ints]
    point_data: dict[str, NDArray]
    cell_data: dict[str, NDArray]


def field_among(files: Sequence[str]) -> str | None:
    """Return which of the files beside a document is its field: of a series the last, which bears no number.

    >>> field_among(["heat.csv", "heat.000.vtu", "heat.vtu"])
    'heat.vtu'
    """
    return min((name for name in files if name.endswith(".vtu")), key=len, default=None)


def read_vtu(data: bytes, name: str) -> Grid:
    """Read a grid that hf wrote; InputError naming the file and what is wrong.

    >>> from hyperfab.io.vtu import unstructured
    >>> data = unstructured(np.eye(3), {"triangle": [[0, 1, 2]]}, {"h_mm": [0, 1, 2]})
    >>> grid = read_vtu(data, "a.vtu")
    >>> grid.cells["triangle"].tolist(), grid.point_data["h_mm"].tolist()
    ([[0, 1, 2]], [0, 1, 2])
    """
    try:
        if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
            raise ValueError("a document type has no place in a .vtu file")
        piece = ElementTree.fromstring(data).find("UnstructuredGrid/Piece")
        if piece is None:
            raise ValueError("it holds no unstructured grid")
        points = _array(piece.find("Points/DataArray")).reshape(-1, 3).astype(float)
        named = {item.get("Name"): _array(item) for item in piece.iterfind("Cells/DataArray")}
        cells = _cells(named["connectivity"], named["offsets"], named["types"], len(points))
        point_data, cell_data = _fields(piece, "PointData"), _fields(piece, "CellData")
        _check_lengths(point_data, len(points))
        _check_lengths(cell_data, len(named["types"]))
    except (ElementTree.ParseError, ValueError, KeyError, zlib.error, binascii.Error) as error:
        raise InputError(
            f"is no grid as hf writes it: {error}", file=name, remedy="make the document and its .vtu again"
        ) from None
    return Grid(points, cells, point_data, cell_data)


def _array(element: ElementTree.Element | None) -> NDArray:
    if element is None:
        raise ValueError("an array is missing")
    if element.get("format") != "binary" or not element.text:
        raise ValueError(f"the array {element.get('Name')} is not stored inline")
    text = element.text.strip().encode("ascii")
    # Number of blocks, block size, size of the last block, then the compressed size of each.
    head = np.frombuffer(base64.b64decode(text[:32], validate=True), dtype="<u8", count=3)
    blocks = int(head[0])
    if blocks * int(head[1]) > _MAX_BYTES + int(head[1]):
        raise ValueError("an array is too large")
    width = 4 * -(-(3 + blocks) * 8 // 3)
    sizes = np.frombuffer(base64.b64decode(text[:width], validate=True), dtype="<u8")[3 : 3 + blocks]
    packed = base64.b64decode(text[width:], validate=True)
    ends = np.cumsum(sizes)
    if len(sizes) != blocks or (blocks and int(ends[-1]) != len(packed)):
        raise ValueError("an array is cut off")
    unpacked = []
    for start, end in zip(ends - sizes, ends, strict=True):
        stream = zlib.decompressobj()
        unpacked.append(stream.decompress(packed[int(start) : int(end)], int(head[1])))
        if not stream.eof:
            raise ValueError("an array is damaged")
    values = np.frombuffer(b"".join(unpacked), dtype=_TYPES[element.get("type", "")])
    components = int(element.get("NumberOfComponents", "1"))
    return values if components == 1 else values.reshape(-1, components)


def _cells(connectivity: NDArray, offsets: NDArray, types: NDArray, points: int) -> dict[str, Ints]:
    names = {number: (name, width) for name, (number, width) in CELL_TYPES.items()}
    if len(offsets) != len(types) or (connectivity.size and not 0 <= connectivity.min() <= connectivity.max() < points):
        raise ValueError("its cells do not fit its points")
    begin = np.concatenate([[0], offsets[:-1]])
    cells = {}
    for number in np.unique(types):
        kind, width = names[int(number)]
        chosen = types == number
        if not (offsets[chosen] - begin[chosen] == width).all():
            raise ValueError(f"a {kind} has not {width} nodes")
        cells[kind] = connectivity[begin[chosen][:, None] + np.arange(width)].astype(np.int64)
    return cells


def _fields(piece: ElementTree.Element, tag: str) -> dict[str, NDArray]:
    return {str(item.get("Name")): _array(item) for item in piece.iterfind(f"{tag}/DataArray")}


def _check_lengths(fields: dict[str, NDArray], count: int) -> None:
    for name, values in fields.items():
        if len(values) != count:
            raise ValueError(f"{name} has {len(values)} values, {count} were expected")
