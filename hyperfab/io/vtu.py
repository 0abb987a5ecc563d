"""Fields on meshes as VTK unstructured grids (.vtu), and time series of them (.pvd), for ParaView."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: VTK's number of a cell type, and its corners and mid-edge nodes. Nodes come in VTK's order.
CELL_TYPES = {
    "vertex": (1, 1),
    "line": (3, 2),
    "triangle": (5, 3),
    "quad": (9, 4),
    "tetra": (10, 4),
    "hexahedron": (12, 8),
    "line3": (21, 3),
    "triangle6": (22, 6),
    "quad8": (23, 8),
    "tetra10": (24, 10),
}
_VTK_TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}
_BLOCK = 2**20


def unstructured(
    points: ArrayLike,
    cells: Mapping[str, ArrayLike],
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
) -> bytes:
    """Return the bytes of a .vtu file; the same arrays give the same bytes.

    ``points`` is (n, 3) or (n, 2) [mm]. ``cells`` maps a cell type (see CELL_TYPES) to node numbers (m, nodes).
    ``point_data`` arrays are (n,) or (n, components); ``cell_data`` arrays count the cells of all types in their
    order. Names carry the unit, as ``stress_warp_MPa``. Truth values become 0 and 1.

    Raises ValueError naming the array whose shape does not fit, or points that are not finite.

    >>> data = unstructured([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}, {"height_mm": [0, 1, 2]})
    >>> data.startswith(b'<?xml version="1.0"?>'), b'Name="height_mm"' in data
    (True, True)
    """
    place = np.asarray(points, dtype=np.float64)
    if place.ndim != 2 or place.shape[1] not in (2, 3) or not np.isfinite(place).all():
        raise ValueError("points must be a finite array (n, 3) or (n, 2)")
    place = np.pad(place, ((0, 0), (0, 3 - place.shape[1])))
    connectivity, offsets, types = _cells(cells, len(place))
    body = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64"'
        ' compressor="vtkZLibDataCompressor">',
        "<UnstructuredGrid>",
        f'<Piece NumberOfPoints="{len(place)}" NumberOfCells="{len(types)}">',
        "<Points>",
        _array("Points", place),
        "</Points>",
        "<Cells>",
        _array("connectivity", connectivity),
        _array("offsets", offsets),
        _array("types", types),
        "</Cells>",
        *_fields("PointData", point_data or {}, len(place)),
        *_fields("CellData", cell_data or {}, len(types)),
        "</Piece>",
        "</UnstructuredGrid>",
        "</VTKFile>",
        "",
    ]
    return "\n".join(body).encode("ascii")


def collection(times_s: Sequence[float], files: Sequence[str]) -> bytes:
    """Return the bytes of a .pvd file that plays ``files`` (names relative to it) at ``times_s``.

    >>> print(collection([0.0, 60.0], ["heat.0.vtu", "heat.1.vtu"]).decode().splitlines()[3])
    <DataSet timestep="0.0" part="0" file="heat.0.vtu"/>
    """
    sets = [
        f'<DataSet timestep="{float(time)!r}" part="0" file={quoteattr(file)}/>'
        for time, file in zip(times_s, files, strict=True)
    ]
    head = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "<Collection>"]
    return "\n".join([*head, *sets, "</Collection>", "</VTKFile>", ""]).encode("utf-8")


def _cells(
    cells: Mapping[str, ArrayLike], points: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]:
    nodes, sizes, types = [], [], []
    for kind, given in cells.items():
        if kind not in CELL_TYPES:
            raise ValueError(f"no cell type {kind}; the types are {', '.join(CELL_TYPES)}")
        number, width = CELL_TYPES[kind]
        block = np.asarray(given, dtype=np.int64)
        if block.ndim != 2 or block.shape[1] != width:
            raise ValueError(f"cells {kind} must be an array (m, {width})")
        if block.size and (block.min() < 0 or block.max() >= points):
            raise ValueError(f"cells {kind} name points that do not exist")
        nodes.append(block.ravel())
        sizes.append(np.full(len(block), width, dtype=np.int64))
        types.append(np.full(len(block), number, dtype=np.uint8))
    if not nodes:
        raise ValueError("a grid needs cells")
    return np.concatenate(nodes), np.cumsum(np.concatenate(sizes)), np.concatenate(types)


def _fields(tag: str, fields: Mapping[str, ArrayLike], count: int) -> list[str]:
    lines = [f"<{tag}>"]
    for name, given in fields.items():
        values = np.asarray(given)
        if values.ndim not in (1, 2) or len(values) != count:
            raise ValueError(f"{name} has the shape {values.shape}, {count} values were expected")
        lines.append(_array(name, values))
    return [*lines, f"</{tag}>"]


def _array(name: str, values: NDArray) -> str:
    values = _storable(values, name)
    components = "" if values.ndim == 1 else f' NumberOfComponents="{values.shape[1]}"'
    kind = _VTK_TYPES[values.dtype.str[1:]]
    data = _compressed(values.tobytes())
    return f'<DataArray type="{kind}" Name={quoteattr(name)}{components} format="binary">{data}</DataArray>'


def _storable(values: NDArray, name: str) -> NDArray:
    if values.dtype.kind == "b":
        values = values.astype(np.uint8)
    elif values.dtype.kind in "iu" and values.dtype.itemsize < 8 and values.dtype != np.uint8:
        values = values.astype(np.int32)
    elif values.dtype.kind in "iu" and values.dtype != np.uint8:
        values = values.astype(np.int64)
    elif values.dtype.kind == "f" and values.dtype.itemsize not in (4, 8):
        values = values.astype(np.float64)
    if values.dtype.kind not in "iuf":
        raise ValueError(f"{name} is no array of numbers")
    return np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))


def _compressed(data: bytes) -> str:
    """VTK's compressed form: number of blocks, block size, size of the last one, compressed sizes, blocks."""
    blocks = [zlib.compress(data[start : start + _BLOCK], 6) for start in range(0, len(data), _BLOCK)]
    last = len(data) % _BLOCK
    header = np.array([len(blocks), _BLOCK, last, *map(len, blocks)], dtype="<u8")
    return (base64.b64encode(header.tobytes()) + base64.b64encode(b"".join(blocks))).decode("ascii")
