"""The door to the mesher: a geometry goes in, conforming ten-node tetrahedra come out, or a reason why not.

Netgen (LGPL) with its OpenCASCADE kernel was chosen for exact booleans of boxes, cylinders and ellipsoids, for
conforming interfaces and for the quality of its tetrahedra. It runs in a process of its own under a watchdog: a
mesher that crashes or never returns ends with a message, Ctrl-C works at once, and no child is left behind.
"""

from __future__ import annotations

import contextlib
import io
import json
import queue
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import IO, Any

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError, NotConverged, UsageError
from hyperfab.thermal import netgen_process
from hyperfab.thermal.geometry import Body, Box, Cylinder, Ellipsoid, Geometry, Shape, Stl
from hyperfab.thermal.netgen_worker import LENGTH

#: Seconds a mesh may take: a base, and so much per tetrahedron expected (Netgen makes some 15 000 a second).
PATIENCE_BASE = 120.0
PATIENCE_PER_TETRAHEDRON = 1e-3

#: A tetrahedron of edge h in a Netgen mesh has about this share of h cubed.
TETRAHEDRON_SHARE = 0.12

#: Memory of the mesher and the solver together, per tetrahedron.
BYTES_PER_TETRAHEDRON = 6e3

#: Nodes of degree 2 per tetrahedron.
NODES_PER_TETRAHEDRON = 1.45

#: How fast elements may grow away from small features; 0.3 is Netgen's moderate setting.
GRADING = 0.3

_KINDS: dict[type, str] = {Box: "box", Cylinder: "cylinder", Ellipsoid: "ellipsoid", Stl: "stl"}


@dataclass(frozen=True)
class RawMesh:
    """What the mesher made, lengths in mm.

    ``points`` (n, 3); ``elements`` (m, 10): four vertices, then the middles of edges 01 12 02 03 13 23; ``parts``
    (m,) the part of each element; ``surface`` (s, 3) vertices of the facets on faces and interfaces, with
    ``surface_face`` (s,) the number of the face each lies on; ``volumes`` the exact volume of each part [mm^3].
    """

    points: Array
    elements: Ints
    parts: Ints
    surface: Ints
    surface_face: Ints
    volumes: Array


def expected_tetrahedra(geometry: Geometry, mesh_size: float) -> float:
    """Estimate the number of tetrahedra from the bounding boxes, from above."""
    count = 0.0
    for part in geometry.parts:
        low, high = part.bounds
        size = min(mesh_size, part.mesh_size or mesh_size)
        count += float(np.prod(high - low)) / (TETRAHEDRON_SHARE * size**3)
    return count


def expected_bytes(tetrahedra: float) -> float:
    """Estimate the memory that a mesh and its solution take at their peak, from what was measured on large ones."""
    return 2e8 + BYTES_PER_TETRAHEDRON * tetrahedra


def make_mesh(
    geometry: Geometry,
    mesh_size: float,
    *,
    patience: float | None = None,
    waiting: Callable[[float], None] = lambda seconds: None,
    built: Callable[[Array], None] = lambda volumes: None,
) -> RawMesh:
    """Mesh the parts with tetrahedra of edge ``mesh_size`` [mm], smaller at small features.

    ``waiting`` is called some times a second with the seconds gone by; ``built`` once the solids stand, before they
    are meshed, with the exact volume of each part [mm^3]. Raises InputError where the geometry makes
    no sense (parts that overlap, a cavity outside the parts), NotConverged where the mesher fails or takes longer
    than ``patience`` seconds.
    """
    limit = patience
    if limit is None:
        limit = PATIENCE_BASE + PATIENCE_PER_TETRAHEDRON * expected_tetrahedra(geometry, mesh_size)
    return RawMesh(**_ask(mesh_job(geometry, mesh_size), limit, waiting, built))


def begin_mesh(geometry: Geometry, mesh_size: float) -> None:
    """Let the mesher begin on what ``make_mesh`` will be asked for; ``netgen_process.end`` ends it where it is not."""
    netgen_process.begin(mesh_job(geometry, mesh_size))


def mesh_job(geometry: Geometry, mesh_size: float) -> bytes:
    """Return what the mesher is asked for: the same of the same bodies."""
    job = {
        "task": "mesh",
        "parts": [_body(part) for part in geometry.parts],
        "cavities": [_body(cavity) for cavity in geometry.cavities],
        "patches": [{"part": patch.part, "box": _shape(patch.box)} for patch in geometry.patches],
        "mesh_size": mesh_size,
        "grading": GRADING,
    }
    return json.dumps(job).encode()


def mesh_surface(
    surface: Stl,
    mesh_size: float,
    sizes: Array,
    *,
    patience: float,
    waiting: Callable[[float], None],
) -> tuple[Array, Ints]:
    """Mesh a closed surface with triangles of edge ``mesh_size`` [mm], smaller near the points of ``sizes``.

    ``sizes`` (s, 4): x, y, z, edge length [mm]. Returns vertices and triangles. Raises as ``make_mesh`` does.
    """
    job = {
        "task": "surface",
        "vertices": surface.vertices.tolist(),
        "triangles": surface.triangles.tolist(),
        "mesh_size": mesh_size,
        "grading": GRADING,
        "sizes": sizes.tolist(),
    }
    with tempfile.TemporaryDirectory(prefix="hf-mesh-") as folder:  # here: a worker that is killed leaves nothing
        arrays = _ask(json.dumps({**job, "folder": folder}).encode(), patience, waiting)
    return arrays["vertices"], arrays["triangles"]


def _ask(
    job: bytes, limit: float, waiting: Callable[[float], None], built: Callable[[Array], None] = lambda volumes: None
) -> dict[str, Any]:
    """Give the worker a job and return its arrays."""
    if not netgen_process.present():
        raise UsageError(
            "meshing a mold needs netgen-mesher, which has no wheel for this machine; "
            "run hf mold-heat on another one (x86-64, or an Apple one): its files are read here"
        )
    answer: dict[str, Any] = {}

    def take(frame: bytes) -> None:
        with np.load(io.BytesIO(frame), allow_pickle=False) as archive:
            arrays = dict(archive)
        if "built" in arrays:
            built(arrays["built"])
        else:
            answer.update(arrays)

    status = _run(job, limit, waiting, take)
    if status is None:
        raise NotConverged(
            f"the mesher did not come back within {limit:.0f} s and was stopped",
            remedy="take a coarser mesh_size, or simplify the geometry where faces nearly touch",
        )
    if status != 0 or not answer:
        raise NotConverged(
            "the mesher failed on this geometry",
            remedy="avoid faces that nearly coincide, or change mesh_size a little",
        )
    if "refused" in answer:
        raise InputError(str(answer["refused"]))
    return answer


def _run(job: bytes, limit: float, waiting: Callable[[float], None], take: Callable[[bytes], None]) -> int | None:
    """Run the worker, ``take`` each of its answers as it comes, and return its status.

    The status is None where it had to be stopped: after ``limit`` s of its own processor time, which a busy machine
    does not use up, or ten times that on the clock.
    """
    import psutil

    start = time.monotonic()
    with netgen_process.taken(job) as process:
        try:
            worker = psutil.Process(process.pid)
            assert process.stdout is not None
            frames: queue.SimpleQueue[bytes] = queue.SimpleQueue()
            threading.Thread(target=_read, args=(process.stdout, frames), daemon=True).start()
            while True:
                try:
                    frame = frames.get(timeout=0.2)
                    if not frame:
                        with contextlib.suppress(subprocess.TimeoutExpired):
                            return process.wait(limit)
                        return None
                    take(frame)
                except queue.Empty:
                    gone = time.monotonic() - start
                    with contextlib.suppress(psutil.Error):  # it has just ended
                        used = worker.cpu_times()
                        if used.user + used.system > limit or gone > 10.0 * limit:
                            return None
                    waiting(gone)
        finally:
            process.kill()
            process.wait()  # also on Ctrl-C: no dead child is left to others


def _read(stream: IO[bytes], frames: queue.SimpleQueue[bytes]) -> None:
    """Hand on the answers of the worker, each behind its length, and nothing at its end."""
    # What is no length comes from no worker of ours, which then finds its pipe closed.
    with contextlib.suppress(MemoryError, OverflowError), stream:
        while len(head := stream.read(LENGTH.size)) == LENGTH.size:
            frames.put(stream.read(*LENGTH.unpack(head)))
    frames.put(b"")


def _body(body: Body) -> dict[str, Any]:
    return {
        "name": body.name,
        "mesh_size": body.mesh_size,
        "shapes": [_shape(shape) for shape in body.shapes],
    }


def _shape(shape: Shape) -> dict[str, Any]:
    if isinstance(shape, Stl):
        return {"kind": "stl", "vertices": shape.vertices.tolist(), "triangles": shape.triangles.tolist()}
    return {"kind": _KINDS[type(shape)], **asdict(shape)}
