"""Three sheets over one ball: net and membrane of ``hf drape`` beside the finite elements of ``hf fabric-contact``.

    python benchmarks/sheets.py > docs/drape-sheets.md

A square of 200 mm and a disc of that diameter, 1 mm thick, clamped all round, over a ball of radius 40 mm pushed up 20
to 80 mm, for three laws; a net has no disc.
``hf fabric-contact`` has a discretisation of its own: curved triangles of six nodes, and an exact sphere.
"""

from __future__ import annotations

import csv
import json
import math
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import trimesh

from hyperfab.cloth import Mold, Sheet, answers, drape, mold_of, raised
from hyperfab.cloth.law import Pulled, spring_law
from hyperfab.cloth.membrane import MembraneLaw
from hyperfab.materials import bind
from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import Along
from hyperfab.membrane.relaxed import RelaxedSheet
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.surface import Surface

SIDE, RADIUS, DEPTHS = 200.0, 40.0, (20.0, 40.0, 60.0, 80.0)
SHAPES = ("square", "disc")
GRIDS = (51, 101, 201)  # each halves the spacing of the one before
LAWS = {
    "neo-hookean": {"C10_MPa": 0.2},
    "yeoh-3": {"C10_MPa": 0.2, "C20_MPa": -0.002, "C30_MPa": 0.0003},
    "orthotropic": {
        "C10_MPa": 0.15, "C20_MPa": 0.01, "k1_warp_MPa": 0.4, "k2_warp": 0.3, "k1_weft_MPa": 0.1, "k2_weft": 0.2,
        "k1_bias_MPa": 0.1, "G_MPa": 0.03,
    },
}  # fmt: skip
COLUMNS = (
    "sheet", "law", "depth", "net [N]", "membrane [N]", "its limit [N]", "order", "elements [N]", "net / elements",
    "membrane off", "limit off", "stretch, membrane", "stretch, elements", "net [s]", "membrane [s]",
)  # fmt: skip
HEAD = f"""# Net, membrane and finite elements

Made by `python benchmarks/sheets.py`. A square sheet of 200 mm, and a disc of that diameter, 1 mm thick, clamped all
round, over a frictionless ball of radius 40 mm pushed up by 20 to 80 mm: `hf drape --sheet net` (of the square) and
`--sheet membrane` (with `--shape disc` of the disc) on {GRIDS[-1]} nodes a side, the ball as an STL of 328 000 facets;
elements: `hf fabric-contact`, curved triangles of six nodes about 4 mm long (finer at the edge of contact) on an exact
sphere. Limit: the membrane's force on grids of {", ".join(map(str, GRIDS))}
nodes a side, extrapolated by their squared spacing; order: as these three grids show it. Stretch: the largest. CPU
seconds of one drape to a residual of 1e-6, kernels compiled."""


def laws(name: str) -> tuple[Pulled, Pulled, MembraneLaw]:
    """A law along warp and weft, and of the whole sheet."""
    if name == "orthotropic":
        whole = Orthotropic.of(LAWS[name])
        return Along(whole, 0.0), Along(whole, 90.0), RelaxedSheet(whole)
    material = bind(name, LAWS[name])
    return material, material, IsotropicSheet(material)


def draped(sheet: Sheet, mold: Mold) -> tuple[float, float, float]:
    """Force in N, largest stretch, and CPU seconds."""
    start = time.process_time()
    found = drape(sheet, mold)
    spent = time.process_time() - start
    said = answers(sheet, mold, found)
    if not found.converged or said.cut.node > 1e-9:
        raise SystemExit(f"{sheet.n} nodes a side: {found.status}, {said.cut.node:.1e} mm inside")
    return said.press_force, said.stretch_max, spent


def pressed(name: str, shape: str) -> list[tuple[float, float]]:
    """Force in N and largest stretch by ``hf fabric-contact`` at all depths."""
    with tempfile.TemporaryDirectory() as folder:
        fabric = {"format": "hyperfab.material/1", "model": name, "parameters": LAWS[name]}
        (Path(folder) / "fabric.json").write_text(json.dumps(fabric))
        words = f"fabric-contact fabric.json --shape {shape} --size {SIDE:g}mm --thickness 1mm"
        words += f" --sphere-radius {RADIUS:g}mm --depth {DEPTHS[-1]:g}mm --steps {len(DEPTHS)} --mesh-size 4mm"
        words += " --quiet -o out.json"
        subprocess.run([sys.executable, "-m", "hyperfab", *words.split()], cwd=folder, check=True)
        with (Path(folder) / "out.csv").open(newline="") as rows:
            found = {float(row["depth_mm"]): row for row in csv.DictReader(rows)}
    return [(float(found[depth]["force_N"]), float(found[depth]["stretch_max"])) for depth in DEPTHS]


def compared(shape: str, name: str, mold: Mold, exact: float, stretch: float) -> list[str]:
    """The rest of a row: what net and membrane make of it, beside the elements' force and stretch."""
    warp, weft, whole = laws(name)
    square = Sheet(GRIDS[-1], GRIDS[-1], (SIDE, SIDE), 1.0, spring_law(warp), spring_law(weft))
    sheet = replace(square, membrane=whole, round=shape == "disc")
    own = [draped(sheet.coarser(n, n), mold) for n in GRIDS]
    net = None if sheet.round else draped(square, mold)
    force = [one[0] for one in own]
    order = math.log2((force[1] - force[0]) / (force[2] - force[1]))
    limit = force[2] + (force[2] - force[1]) / 3.0
    return [
        "" if net is None else f"{net[0]:.3f}", f"{force[2]:.3f}", f"{limit:.3f}", f"{order:.1f}", f"{exact:.3f}",
        "" if net is None else f"{net[0] / exact:.2f}", f"{force[2] / exact - 1.0:+.1e}", f"{limit / exact - 1.0:+.1e}",
        f"{own[2][1]:.4f}", f"{stretch:.4f}", "" if net is None else f"{net[2]:.2f}", f"{own[2][2]:.2f}",
    ]  # fmt: skip


def main() -> None:
    """Print the document."""
    print(HEAD)
    print(f"\n| {' | '.join(COLUMNS)} |\n" + "|---" * len(COLUMNS) + "|")
    mesh = trimesh.creation.icosphere(subdivisions=7, radius=RADIUS)
    ball = mold_of(Surface(mesh.vertices, mesh.faces), (0.0, 0.0, -RADIUS))
    for shape in SHAPES:
        for name in LAWS:
            for depth, exact in zip(DEPTHS, pressed(name, shape), strict=True):
                row = compared(shape, name, raised(ball, depth), *exact)
                print(f"| {shape} | {name} | {depth:.0f} mm | {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
