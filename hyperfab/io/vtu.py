"""Fields on meshes as VTK unstructured grids (.vtu), and time series of them (.pvd), for ParaView."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hyperfab.arrays import Ints
from hyperfab.errors import OutputError

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

    Raises ValueError naming the array whose shape does not fit, or points that are not finite; OutputError where
    there is no room for a temporary file.

    >>> data = unstructured([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}, {"height_mm": [0, 1, 2]})
    >>> data.startswith(b"<?xml"), b'Name="height_mm"' in data
    (True, True)
    """
    # Imported where it is needed: bad input is refused without it.
    import meshio

    place = np.asarray(points, dtype=np.float64)
    if place.ndim != 2 or place.shape[1] not in (2, 3) or not np.isfinite(place).all():
        raise ValueError("points must be a finite array (n, 3) or (n, 2)")
    place = np.pad(place, ((0, 0), (0, 3 - place.shape[1])))
    blocks = _cells(cells, len(place))
    counts = [len(nodes) for _, nodes in blocks]
    mesh = meshio.Mesh(
        place,
        blocks,
        point_data=_fields(point_data or {}, len(place)),
        cell_data={
            name: np.split(values, np.cumsum(counts)[:-1])
            for name, values in _fields(cell_data or {}, sum(counts)).items()
        },
    )
    try:
        # meshio writes to a path only.
        with TemporaryDirectory(prefix="hf-") as folder:
            path = Path(folder, "grid.vtu")
            meshio.vtu.write(path, mesh, binary=True, compression="zlib", header_type="UInt64")
            return path.read_bytes()
    except OSError as error:
        raise OutputError(f"the folder for temporary files: {error.strerror}; free some space in it") from error


def refilled(grid: bytes, name: str, values: ArrayLike) -> bytes:
    """Return the bytes of a .vtu file with other values in one of its point fields: ``values`` (n,).

    What ``unstructured`` would return, in a fraction of the time: the mesh, nine tenths of it, is not packed again.

    >>> triangle = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}
    >>> cold, hot = (unstructured(*triangle, {"heat": heat}) for heat in ([1, 2, 3], [7, 8, 9]))
    >>> refilled(cold, "heat", [7, 8, 9]) == hot
    True
    """
    field = np.asarray(values)
    alone = unstructured(np.zeros((len(field), 3)), {"vertex": [[0]]}, {name: field})
    (begin, end), (first, last) = _place(grid, name), _place(alone, name)
    return grid[:begin] + alone[first:last] + grid[end:]


def _place(grid: bytes, name: str) -> tuple[int, int]:
    """Return where the array of a point field begins and ends in a file."""
    begin = grid.index(b"<DataArray", grid.index(b"<PointData"))
    while f'Name="{escape(name)}"'.encode() not in grid[begin : grid.index(b">", begin)]:
        begin = grid.index(b"<DataArray", begin + 1)
    return begin, grid.index(b"</DataArray>", begin)


def collection(times_s: Sequence[float], files: Sequence[str]) -> bytes:
    """Return the bytes of a .pvd file that plays ``files`` (names relative to it) at ``times_s``.

    >>> print(collection([0.0, 60.0], ["heat.0.vtu", "heat.1.vtu"]).decode().splitlines()[3])
    <DataSet timestep="0.0" part="0" file="heat.0.vtu"/>
    """
    sets = [
        f'<DataSet timestep="{float(time)!r}" part="0" file="{escape(file)}"/>'
        for time, file in zip(times_s, files, strict=True)
    ]
    head = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "<Collection>"]
    return "\n".join([*head, *sets, "</Collection>", "</VTKFile>", ""]).encode("utf-8")


def _cells(cells: Mapping[str, ArrayLike], points: int) -> list[tuple[str, Ints]]:
    blocks = []
    for kind, given in cells.items():
        if kind not in CELL_TYPES:
            raise ValueError(f"no cell type {kind}; the types are {', '.join(CELL_TYPES)}")
        width = CELL_TYPES[kind][1]
        nodes = np.asarray(given, dtype=np.int64)
        if nodes.ndim != 2 or nodes.shape[1] != width:
            raise ValueError(f"cells {kind} must be an array (m, {width})")
        if nodes.size and (nodes.min() < 0 or nodes.max() >= points):
            raise ValueError(f"cells {kind} name points that do not exist")
        blocks.append((kind, nodes))
    if not blocks:
        raise ValueError("a grid needs cells")
    return blocks


def _fields(fields: Mapping[str, ArrayLike], count: int) -> dict[str, NDArray]:
    found = {}
    for name, given in fields.items():
        values = np.asarray(given)
        if values.ndim not in (1, 2) or len(values) != count:
            raise ValueError(f"{name} has the shape {values.shape}, {count} values were expected")
        found[name] = _storable(values, name)
    return found


def _storable(values: NDArray, name: str) -> NDArray:
    """Return numbers of a type the file knows; truth values become 0 and 1."""
    if values.dtype.kind == "b" or values.dtype == np.uint8:
        return values.astype(np.uint8)
    if values.dtype.kind in "iu":
        return values.astype(np.int64)
    if values.dtype.kind == "f":
        return values.astype(np.float64)
    raise ValueError(f"{name} is no array of numbers")
