"""Triangles, quadrilaterals or lines from the mesh files that meshio reads."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError

#: Kinds of files that are understood without further programs.
SUFFIXES = (".vtu", ".vtk", ".msh", ".obj", ".ply", ".off", ".inp", ".bdf", ".nas", ".mesh", ".su2")
_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
_LINES = ("line", "line3")


@dataclass(frozen=True)
class MeshFile:
    """``points`` (n, 3) in the file's unit, and ``edges`` (k, 2): those of one face alone, or else its lines."""

    points: Array
    edges: Ints


def read_mesh_file(data: bytes, name: str) -> MeshFile:
    """Read the edge of a surface, or lines, from a mesh file; its name's ending says of what kind it is.

    Raises InputError naming the file where it cannot be read, or has neither faces nor lines.
    """
    import meshio

    suffix = os.path.splitext(name)[1].lower()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, f"mesh{suffix}")
        with open(path, "wb") as file:
            file.write(data)
        try:
            # meshio reports on standard output and leaves the program where no reader understands a file.
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                found = meshio.read(path)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a reader fails in its own way on each file
            reason = " ".join(str(error).replace(path, name).split())[:160]
            raise InputError(
                f"cannot be read as a {suffix[1:]} mesh" + (f": {reason}" if reason not in ("", "1") else ""),
                file=name,
                remedy="export it again, or as STL or CSV",
            ) from None
    points = np.zeros((len(found.points), 3))
    points[:, : found.points.shape[1]] = found.points[:, :3]
    edges = _edges(found.cells)
    if not len(edges):
        raise InputError("has neither faces nor lines", file=name, remedy="a flat surface or a closed line is meant")
    if not np.isfinite(points).all():
        raise InputError("has a point that is not finite", file=name, remedy="export it again")
    return MeshFile(points, edges)


def _edges(cells: list) -> Ints:
    """Return the edges (k, 2) of exactly one face; where there are no faces the lines."""
    sides = []
    for block in cells:
        corners = _CORNERS.get(block.type)
        if corners:
            face = np.asarray(block.data, np.int64)[:, :corners]
            sides += [face[:, [k, (k + 1) % corners]] for k in range(corners)]
    if sides:
        return lonely(np.concatenate(sides))
    lines = [np.asarray(block.data, np.int64)[:, :2] for block in cells if block.type in _LINES]
    return np.concatenate(lines) if lines else np.empty((0, 2), np.int64)


def lonely(sides: Ints) -> Ints:
    """Return the sides (k, 2) of faces that are those of exactly one."""
    _, inverse, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    return np.asarray(sides[count[inverse.ravel()] == 1])
