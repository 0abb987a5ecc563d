"""The process that meshes: reads one job on standard input, builds the solids with Netgen/OCC, writes one mesh, and
before it the volumes of the solids.

It runs apart because a mesher may crash, hang or print: the parent keeps a watch on it and kills it. Run as
``python -m hyperfab.thermal.netgen_worker``; see mesher.py for the parent's side.
"""

from __future__ import annotations

import io
import json
import os
import struct
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from hyperfab.system import die_with_parent

#: What stands before each answer: its length in bytes.
LENGTH = struct.Struct("<Q")

#: Netgen's order of the ten nodes of a tetrahedron, as places in the order used here (vertices, then edges
#: 01 12 02 03 13 23).
TETRAHEDRON_NODES = [0, 1, 2, 3, 4, 7, 5, 6, 8, 9]

#: Volumes that overlap less than this share of the smaller part only touch.
OVERLAP = 1e-9


class Refused(Exception):
    """The geometry makes no sense; the text says which body."""


def main() -> None:
    """Mesh the job on standard input; answers are npz archives on standard output, each behind its length."""
    die_with_parent()
    answer = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Netgen prints to standard output
    import netgen.occ  # noqa: F401 - while the job is on its way

    given = sys.stdin.buffer.read()
    if not given:
        return
    job = json.loads(given)
    with os.fdopen(answer, "wb") as stream:

        def tell(arrays: dict[str, Any]) -> None:
            buffer = io.BytesIO()
            np.savez(buffer, **arrays)
            stream.write(LENGTH.pack(buffer.tell()) + buffer.getvalue())
            stream.flush()

        try:
            tell(surface(job) if job["task"] == "surface" else mesh(job, tell))
        except Refused as refusal:
            tell({"refused": np.array(str(refusal))})


def mesh(job: dict[str, Any], tell: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """Build the solids of ``job`` and ``tell`` their volumes, mesh them, return the mesh's arrays (lengths in mm)."""
    import netgen.meshing as nm
    import netgen.occ as occ

    names = [part["name"] for part in job["parts"]]
    solids = [_union(occ, part["shapes"]) for part in job["parts"]]
    _refuse_overlap(names, solids)
    for cavity in job["cavities"]:
        tool = _union(occ, cavity["shapes"])
        cut = [solid - tool for solid in solids]
        removed = sum(before.mass - after.mass for before, after in zip(solids, cut, strict=True))
        if removed <= OVERLAP * tool.mass:
            raise Refused(f"cavity {cavity['name']!r} cuts nothing out of the parts; move it into one")
        solids = cut
    patches = []
    for patch in job["patches"]:
        box = _shape(occ, patch["box"])
        faces = [face * box for face in solids[names.index(patch["part"])].faces]
        patches += [face for face in faces if len(face.faces)]
    sizes = [part["mesh_size"] for part in job["parts"]]
    for name, solid, size in zip(names, solids, sizes, strict=True):
        if solid.mass <= 0 or len(solid.solids) == 0:
            raise Refused(f"part {name!r} has no volume left; check its shapes and the cavities")
        for piece in solid.solids:
            piece.mat(name)
            if size is not None:
                piece.maxh = size
    volumes = {name: solid.mass for name, solid in zip(names, solids, strict=True)}
    tell({"built": np.array(list(volumes.values()))})
    glued = occ.Glue([*solids, *patches]) if len(solids) + len(patches) > 1 else solids[0]
    whole = occ.Glue(list(glued.solids)) if patches else glued
    geometry = occ.OCCGeometry(whole)
    found = geometry.GenerateMesh(**_parameters(job))
    found.SecondOrder()
    return _arrays(nm, found, names, volumes)


def surface(job: dict[str, Any]) -> dict[str, Any]:
    """Mesh a closed STL surface anew with triangles of edge ``mesh_size``; sharp edges are kept."""
    import netgen.meshing as nm
    import netgen.stl as stl

    corners = np.array(job["vertices"])[np.array(job["triangles"])]
    record = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("tail", "<u2")])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    record["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    record["corners"] = corners
    folder = Path(job["folder"])
    binary = bytes(80) + np.uint32(len(record)).tobytes() + record.tobytes()
    geometry = stl.STLGeometry(_as_file(binary, folder / "surface.stl"))
    parameters = _parameters(job)
    if job["sizes"]:
        lines = [
            str(len(job["sizes"])),
            *(" ".join(f"{value:.9g}" for value in row) for row in job["sizes"]),
            "0",
            "",
        ]
        parameters["meshsizefilename"] = _as_file("\n".join(lines).encode(), folder / "sizes.msz")
    step = nm.MeshingStep.MESHSURFACE
    found = geometry.GenerateMesh(**parameters, perfstepsend=step)
    triangles = found.Elements2D().NumPy()["nodes"][:, :3].astype(np.int64) - 1
    return {"vertices": np.array(found.Coordinates(), dtype=np.float64), "triangles": triangles}


def _parameters(job: dict[str, Any]) -> dict[str, Any]:
    # Netgen's four threads wait for each other in loops that do not sleep: of a small mesh beside one other busy
    # process a second in place of a hundredth, of a large one half as much again. The mesh is the same to the bit.
    return {"maxh": job["mesh_size"], "grading": job["grading"], "parallel_meshing": False}


def _as_file(data: bytes, path: Path) -> str:
    """Write ``data`` to ``path`` and return its name: Netgen reads files only."""
    path.write_bytes(data)
    return str(path)


def _refuse_overlap(names: list[str], solids: list[Any]) -> None:
    for i, first in enumerate(solids):
        for j in range(i):
            common = (first * solids[j]).mass
            if common > OVERLAP * min(first.mass, solids[j].mass):
                raise Refused(
                    f"parts {names[j]!r} and {names[i]!r} overlap in {common / 1e3:.4g} cm^3; "
                    "parts may touch, not overlap: change one, or make them shapes of one part"
                )


def _union(occ: Any, shapes: list[dict[str, Any]]) -> Any:
    whole = _shape(occ, shapes[0])
    for shape in shapes[1:]:
        whole = whole + _shape(occ, shape)
    return whole


def _shape(occ: Any, shape: dict[str, Any]) -> Any:
    return {"box": _box, "cylinder": _cylinder, "ellipsoid": _ellipsoid, "stl": _stl}[shape["kind"]](occ, shape)


def _box(occ: Any, shape: dict[str, Any]) -> Any:
    low = np.array(shape["origin"], dtype=float)
    return occ.Box(occ.Pnt(*low), occ.Pnt(*(low + np.array(shape["size"]))))


def _cylinder(occ: Any, shape: dict[str, Any]) -> Any:
    k = "xyz".index(shape["axis"])
    unit = np.eye(3)
    axis, first, second = unit[k], unit[(k + 1) % 3], unit[(k + 2) % 3]
    a, b = shape["semi_axes"]
    if a == b:
        return occ.Cylinder(occ.Pnt(*shape["origin"]), occ.Dir(*axis), r=a, h=shape["length"])
    if a < b:  # OCC wants the major semi-axis first
        a, b, first = b, a, second
    plane = occ.Axes(occ.Pnt(*shape["origin"]), n=occ.Dir(*axis), h=occ.Dir(*first))
    return occ.WorkPlane(plane).Ellipse(a, b).Face().Extrude(shape["length"])


def _ellipsoid(occ: Any, shape: dict[str, Any]) -> Any:
    # Made and cut about the origin, then moved: elsewhere the cut of an ellipsoid may miss its seam by rounding.
    made = _about_the_origin(occ, *shape["semi_axes"], *(shape["half"] or ()))
    return made.Move(occ.Vec(*shape["centre"]))


@cache
def _about_the_origin(occ: Any, a: float, b: float, c: float, axis: str = "", side: str = "") -> Any:
    """Return an ellipsoid, or its half on one ``side`` of an ``axis``; molds have many alike, each cut takes 0.05 s."""
    if a == b == c:
        whole = occ.Sphere(occ.Pnt(0, 0, 0), a)
    else:  # Netgen takes the semi-axes along n, h and n x h
        axes = occ.Axes(occ.Pnt(0, 0, 0), n=occ.Dir(0, 0, 1), h=occ.Dir(1, 0, 0))
        whole = occ.Ellipsoid(axes, c, a, b)
    if not axis:
        return whole
    high = np.full(3, 2.0 * max(a, b, c))
    low = -high
    (low if side == "+" else high)["xyz".index(axis)] = 0.0
    return whole * occ.Box(occ.Pnt(*low), occ.Pnt(*high))


def _stl(occ: Any, shape: dict[str, Any]) -> Any:
    """Sew the triangles into a solid; neighbours in one plane become one face."""
    corners = np.array(shape["vertices"])[np.array(shape["triangles"])]
    faces = []
    for triangle in corners:
        points = [occ.Pnt(*corner) for corner in triangle]
        wire = occ.Wire([occ.Segment(points[i], points[(i + 1) % 3]) for i in range(3)])
        faces.append(occ.Face(wire))
    sewn = occ.Sew(faces)
    solid = occ.Solid(sewn)
    if solid.mass < 0:
        solid = solid.Reversed()
    return solid.UnifySameDomain()


def _arrays(nm: Any, found: Any, names: list[str], volumes: dict[str, float]) -> dict[str, Any]:
    points = np.ascontiguousarray(found.Coordinates(), dtype=np.float64)
    volume, surface = found.Elements3D().NumPy(), found.Elements2D().NumPy()
    if len(volume) == 0:
        raise Refused("the mesher made no tetrahedra; check that the parts are closed")
    domains = [names.index(found.GetMaterial(i + 1)) for i in range(int(volume["index"].max()))]
    return {
        "points": points,
        "elements": volume["nodes"][:, TETRAHEDRON_NODES].astype(np.int64) - 1,
        "parts": np.array(domains, dtype=np.int64)[volume["index"] - 1],
        "surface": surface["nodes"][:, :3].astype(np.int64) - 1,
        "surface_face": surface["index"].astype(np.int64) - 1,
        "volumes": np.array([volumes[name] for name in names]),
    }


if __name__ == "__main__":
    main()
