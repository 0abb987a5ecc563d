"""The sphere on the disc by CalculiX (ccx): C3D8I hexahedra, one thin layer on a quarter of the disc, node to surface.

    python with_calculix.py CELLS

The sheet is a quarter as thick and four times as stiff as the one meant, so that bending and the height of the face
that touches count for little; much thinner ones do not start, because a flat sheet resists the sphere by bending alone.
The sphere is a cap of hexahedra, each of whose nodes is moved by the depth. On 40 CELLS it goes all the way; on coarser
meshes, or with finer faces on the sphere, it often breaks off. Prints one line of JSON.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np

THICKNESS, C10, RADIUS, SPHERE, DEPTH = 0.25, 0.8, 100.0, 40.0, 60.0
#: Bulk over shear modulus.
BULK = 250.0
#: Stiffness [N/mm per mm²], largest tension [MPa] and reach (relative to the root of the area) of a contact spring.
SPRING = "20., 1e-5, 0.5"
#: First, whole, least and largest step in load.
STEPS = "0.002, 1., 1e-6, 0.125"
#: Cells along a side of the sphere's cap, and its half angle.
CAP_CELLS, CAP_ANGLE = 32, np.radians(81.0)


def rounded(cells: int, low: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a square grid from ``low`` to 1 drawn out to the circle: radius, angle and quadrilaterals."""
    line = np.linspace(low, 1.0, cells + 1)
    x, y = (values.ravel() for values in np.meshgrid(line, line, indexing="ij"))
    reach = np.maximum(np.abs(x), np.abs(y))
    safe = np.where(reach > 0, reach, 1.0)
    u, v = np.pi / 4 * x / safe, np.pi / 4 * y / safe
    beside = np.where(x >= 0, v, np.pi - v)
    angle = np.where(np.abs(x) >= np.abs(y), beside, np.where(y >= 0, np.pi / 2 - u, u - np.pi / 2))
    step = np.arange(cells)
    corner = (step[:, None] * (cells + 1) + step).ravel()
    quads = np.column_stack([corner, corner + cells + 1, corner + cells + 2, corner + 1])
    return reach, angle, quads


def deck(cells: int) -> tuple[str, int]:
    """Return CalculiX's input and the number of the sheet's unknowns."""
    reach, angle, quads = rounded(cells, 0.0)
    plane = RADIUS * reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    flat = np.column_stack([np.where(np.abs(plane) < 1e-9, 0.0, plane), 0 * reach])
    sheet = np.concatenate([flat, flat + np.array([0.0, 0.0, THICKNESS])])
    far = np.hypot(sheet[:, 0], sheet[:, 1])
    rim = far > RADIUS * (1 - 1e-9)
    onx, ony = (sheet[:, 0] == 0) & ~rim, (sheet[:, 1] == 0) & ~rim
    below = (np.arange(len(sheet)) < len(flat)) & (far < 1.25 * SPHERE)

    slope, around, cap = rounded(CAP_CELLS, -1.0)
    slope = CAP_ANGLE * slope
    out = np.column_stack([np.sin(slope) * np.cos(around), np.sin(slope) * np.sin(around), np.cos(slope)])
    ball = np.concatenate([0.8 * SPHERE * out, SPHERE * out]) - [0.0, 0.0, SPHERE]

    nodes = np.concatenate([sheet, ball])
    lines = ["*NODE", *(f"{n}, {x:.10g}, {y:.10g}, {z:.10g}" for n, (x, y, z) in enumerate(nodes, 1))]
    lines += elements("C3D8I", "SHEET", quads, len(flat), 1, 1)
    lines += elements("C3D8", "BALL", cap, len(out), len(sheet) + 1, len(quads) + 1)
    number = np.arange(1, len(sheet) + 1)
    for name, marked in (("RIM", rim), ("ONX", onx), ("ONY", ony), ("BELOW", below)):
        lines += listed(name, number[marked])
    lines += listed("BALLNODES", len(sheet) + 1 + np.arange(len(ball)))
    lines += f"""
*MATERIAL, NAME=RUBBER
*HYPERELASTIC, NEO HOOKE
{C10}, {1.0 / (BULK * C10):.6g}
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*SOLID SECTION, ELSET=SHEET, MATERIAL=RUBBER
*SOLID SECTION, ELSET=BALL, MATERIAL=STEEL
*SURFACE, NAME=UNDER, TYPE=NODE
BELOW
*SURFACE, NAME=OUTSIDE, TYPE=ELEMENT
BALL, S2
*SURFACE INTERACTION, NAME=TOUCH
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{SPRING}
*CONTACT PAIR, INTERACTION=TOUCH, TYPE=NODE TO SURFACE
UNDER, OUTSIDE
*BOUNDARY
RIM, 1, 3
ONX, 1, 1
ONY, 2, 2
BALLNODES, 1, 2
*STEP, NLGEOM, INC=5000
*STATIC, SOLVER=SPOOLES
{STEPS}
*BOUNDARY
BALLNODES, 3, 3, {DEPTH}
*NODE PRINT, NSET=RIM, TOTALS=ONLY
RF
*END STEP
""".strip().splitlines()
    return "\n".join(lines) + "\n", int(3 * len(sheet) - 3 * rim.sum() - onx.sum() - ony.sum())


def elements(kind: str, name: str, quads: np.ndarray, layer: int, node: int, first: int) -> Iterable[str]:
    """Return lines for hexahedra on ``quads``, whose upper nodes follow ``layer`` nodes after the lower ones."""
    yield f"*ELEMENT, TYPE={kind}, ELSET={name}"
    for number, corners in enumerate(np.hstack([quads, quads + layer]) + node, first):
        yield f"{number}, " + ", ".join(map(str, corners))


def listed(name: str, numbers: np.ndarray) -> Iterable[str]:
    """Return lines for a set of nodes."""
    yield f"*NSET, NSET={name}"
    yield from (", ".join(map(str, numbers[k : k + 10])) for k in range(0, len(numbers), 10))


def main() -> None:
    """Push the sphere in and print what came out."""
    program = shutil.which("ccx")
    if program is None:
        sys.exit("CalculiX (ccx) is not installed")
    text, unknowns = deck(int(sys.argv[1]))
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "press.inp").write_text(text)
        subprocess.run([program, "press"], cwd=folder, stdout=subprocess.DEVNULL, check=False)
        found = (Path(folder) / "press.dat").read_text()
        steps = (Path(folder) / "press.sta").read_text().splitlines()
    reactions = re.findall(r"set RIM and time +(\S+)\s+\S+\s+\S+\s+(\S+)", found)
    time, force = (float(value) for value in (reactions or [(0.0, 0.0)])[-1])
    if time < 1.0:
        sys.exit(f"CalculiX broke off at {DEPTH * time:.1f} mm")
    done = [line.split() for line in steps if line.split()[:1] == ["1"]]
    print(
        json.dumps(
            {
                "force_N": 4 * abs(force),
                "unknowns": unknowns,
                "iterations": sum(int(words[3]) for words in done),
            }
        )
    )


if __name__ == "__main__":
    main()
