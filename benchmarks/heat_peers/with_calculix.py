"""The benchmark's steps with CalculiX: python with_calculix.py MESH.npz linear STEPS; 77: ccx is not installed.

Ten-node tetrahedra DC3D10, increments of fixed length, its own sparse solver (SPOOLES) on one thread. Run in the
interpreter that has this program: the mesh and the probes are read with it.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from ours import PROBES, STEP, degree_two

from hyperfab.thermal.locate import Locator
from hyperfab.thermal.mesh import FACETS

#: CalculiX numbers the faces of a tetrahedron 1-2-3, 1-4-2, 2-4-3, 3-4-1: by the corners, from 0.
FACES = [{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}]


def deck(mesh, data, steps: int) -> str:
    """Return the input deck."""
    lines = ["*NODE, NSET=ALL"]  # numbers of at most 20 characters are read
    lines += [f"{i},{x:.11g},{y:.11g},{z:.11g}" for i, (x, y, z) in enumerate(mesh.points.tolist(), 1)]
    lines.append("*ELEMENT, TYPE=DC3D10, ELSET=MOLD")
    lines += [",".join(map(str, [i, *(n + 1 for n in nodes)])) for i, nodes in enumerate(mesh.elements.tolist(), 1)]
    lines += ["*MATERIAL, NAME=AL", "*CONDUCTIVITY", "237.", "*DENSITY", "2702.", "*SPECIFIC HEAT", "903."]
    lines += ["*SOLID SECTION, ELSET=MOLD, MATERIAL=AL", "*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL,25."]
    lines += [f"*STEP, INC={10 * steps}", "*HEAT TRANSFER, DIRECT", f"{STEP},{STEP * steps}"]
    places, areas = {}, {}
    outer = mesh.facets.outer
    local = [FACES.index(set(FACETS[i][:3].tolist())) + 1 for i in range(4)]
    corners = np.sort(mesh.facet_nodes(outer)[:, :3], axis=1)
    for name in ("bottom", "exposed"):
        wanted = {tuple(row) for row in np.sort(data[name], axis=1).tolist()}
        chosen = np.array([tuple(row) in wanted for row in corners.tolist()])
        a, b, c = (mesh.points[corners[chosen][:, i]] for i in range(3))
        areas[name] = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        elements, faces = mesh.facets.element[outer][chosen], mesh.facets.local[outer][chosen]
        places[name] = [(e + 1, local[f]) for e, f in zip(elements.tolist(), faces.tolist(), strict=True)]
    lines.append("*DFLUX")
    lines += [f"{e},S{f},{3000.0 / areas['bottom']:.11g}" for e, f in places["bottom"]]
    lines.append("*FILM")
    lines += [f"{e},F{f},25.,10." for e, f in places["exposed"]]
    lines += [f"*NODE PRINT, NSET=ALL, FREQUENCY={steps}", "NT", "*END STEP"]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the steps and print one line of JSON."""
    if shutil.which("ccx") is None:
        raise SystemExit(77)
    data, steps = np.load(sys.argv[1]), int(sys.argv[3])
    mesh = degree_two(data["points"], data["elements"])
    spent = []
    with tempfile.TemporaryDirectory() as folder:
        for count in (1, steps):  # the difference is what the steps after the first take
            Path(folder, "mold.inp").write_text(deck(mesh, data, count))
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                ["ccx", "mold"],
                cwd=folder,
                check=True,
                capture_output=True,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        rows = [line.split() for line in Path(folder, "mold.dat").read_text().splitlines()]
    found = np.array([[float(v) for v in row] for row in rows if len(row) == 2 and row[0].isdigit()])
    temperature = np.empty(len(mesh.points))
    temperature[found[:, 0].astype(int) - 1] = found[:, 1]
    locator = Locator(mesh.points, mesh.elements)
    at = [float(locator.sensor(np.array(place)) @ temperature) for place in PROBES]
    step = (spent[1] - spent[0]) / max(steps - 1, 1)
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6
    print(json.dumps({"setup": 0.0, "first": spent[0], "step": step, "gigabytes": memory, "at": at}))


if __name__ == "__main__":
    main()
