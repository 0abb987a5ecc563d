"""Conduction on ten-node tetrahedra: this program, NGSolve and CalculiX, same mesh and same backward-Euler steps.

    python benchmarks/heat.py [--sizes 20,100,300] [--steps 100] [--peers PYTHON]

NGSolve (PyPI: ngsolve) runs in the interpreter PYTHON, or in this one where it is installed: its sparse Cholesky
solver on one thread; with a film h(T) it factorises either anew in every Newton step or once ("frozen"). CalculiX is
the program ccx (Debian: calculix-ccx), run at the smallest size and with a constant film, as a film h(T) needs a
compiled routine there. Rows of what is not installed are left out. Where a peer needs more than a few seconds a
step only the first steps are run, and the total is the first step plus so many times the mean of the others: marked
~. Each run is a process of its own; times are its CPU seconds.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from hyperfab.thermal.faces import Faces
from hyperfab.thermal.geometry import Body, Box, Geometry
from hyperfab.thermal.mesh import build_mesh
from hyperfab.thermal.mesher import make_mesh

HERE = Path(__file__).parent / "heat_peers"

#: Edge length [mm] that gives so many thousand unknowns of degree 2.
EDGES = {20: 17.0, 100: 10.4, 300: 7.4}

#: NGSolve's Newton factorises in every step: as many steps as fit into a coffee break.
SHORT = {
    ("newton", 20): 10,
    ("newton", 100): 2,
    ("newton", 300): 1,
    ("frozen", 100): 10,
    ("frozen", 300): 4,
    ("linear", 300): 10,
}
#: CalculiX runs so many steps, at this size [thousands of unknowns].
CALCULIX = {20: 5}


def main() -> None:
    """Run the peers and print one table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="20", help="thousands of unknowns, of 20, 100, 300")
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has NGSolve")
    options = parser.parse_args()
    print(f"{options.steps} backward-Euler steps of 30 s; CPU seconds, one thread")
    print(f"{'unknowns':>9} {'film':7} {'program':16} {'total':>9} {'a step':>8} {'GB':>5}  {'differs by':>10}")
    with tempfile.TemporaryDirectory() as folder:
        for size in (int(text) for text in options.sizes.split(",")):
            mesh = Path(folder) / f"{size}.npz"
            unknowns = write_mesh(mesh, EDGES[size])
            compare(mesh, size, unknowns, options.steps, options.peers)


def compare(mesh: Path, size: int, unknowns: int, steps: int, ngsolve: str) -> None:
    """Print the rows of one mesh."""
    for film, modes in (("linear", ("linear",)), ("h(T)", ("newton", "frozen"))):
        ours = run(sys.executable, "ours.py", mesh, "linear" if film == "linear" else "film", steps)
        assert ours is not None
        show(unknowns, film, "hyperfab", ours, steps, steps, 0.0)
        for mode in modes:
            label = "NGSolve" if mode == "linear" else f"NGSolve {mode}"
            few = min(SHORT.get((mode, size), steps), steps)
            beside(mesh, unknowns, film, ours, (ngsolve, "with_ngsolve.py", mode, label), few, steps)
        if film == "linear" and size in CALCULIX:
            peer = (sys.executable, "with_calculix.py", "linear", "CalculiX")
            beside(mesh, unknowns, film, ours, peer, min(CALCULIX[size], steps), steps)


def beside(
    mesh: Path, unknowns: int, film: str, ours: dict, peer: tuple[str, str, str, str], few: int, steps: int
) -> None:
    """Run a peer (interpreter, script, mode, label) for ``few`` steps and print its row."""
    python, script, mode, label = peer
    theirs = run(python, script, mesh, mode, few)
    if theirs is None:
        return
    same = ours if few == steps else run(sys.executable, "ours.py", mesh, mode, few)
    assert same is not None
    difference = float(np.abs(np.array(same["at"]) - np.array(theirs["at"])).max())
    show(unknowns, film, label, theirs, few, steps, difference)


def show(unknowns: int, film: str, label: str, result: dict, ran: int, steps: int, difference: float) -> None:
    """Print one row; totals of shortened runs are extended by the mean step."""
    total = result["setup"] + result["first"] + (steps - 1) * result["step"]
    mark = " " if ran == steps else "~"
    print(
        f"{unknowns:9d} {film:7} {label:16} {mark}{total:8.1f} {result['step']:8.3f} {result['gigabytes']:5.2f}"
        f"  {difference:9.1e}K",
        flush=True,
    )


def run(python: str, script: str, mesh: Path, mode: str, steps: int) -> dict | None:
    """Run one peer; None where it is not installed."""
    command = [python, str(HERE / script), str(mesh), mode, str(steps)]
    environment = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PATH": os.environ["PATH"]}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode == 77:
        return None
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])


def write_mesh(path: Path, edge: float) -> int:
    """Mesh the original mold's plate and block, straight-sided; return the unknowns of degree 2."""
    plate = Body("plate", (Box((-200.0, -180.0, 0.0), (400.0, 360.0, 50.0)),))
    block = Body("block", (Box((-180.0, -160.0, 50.0), (360.0, 320.0, 85.0)),))
    geometry = Geometry((plate, block))
    raw = make_mesh(geometry, edge)
    mesh = build_mesh(raw.points / 1e3, raw.elements, raw.parts, raw.surface, raw.surface_face)
    bottom = Faces(mesh, geometry).named("plate.z-").mask
    exposed = mesh.facets.outer & ~bottom
    np.savez(
        path,
        points=mesh.points[: mesh.vertices],
        elements=mesh.elements[:, :4],
        bottom=mesh.facet_nodes(bottom)[:, :3],
        exposed=mesh.facet_nodes(exposed)[:, :3],
    )
    return len(mesh.points)


if __name__ == "__main__":
    main()
