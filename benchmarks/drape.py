"""CPU time, residual, penetration and memory of the drape of two sheets, and of the slower solvers.

    python benchmarks/drape.py [NODES ...]

Model sheet: 200 x 200 x 1 mm, four edges clamped, over a ball of radius 60 mm (82 000 facets) that stands 80 mm above
its plane; with slack springs, and mounted stretched by 1.1, which leaves none. Cup: 260 x 260 mm, 50 mm deep. The
relative residual is 1e-6; seconds are CPU time after compilation, on one core. Up to 100 nodes a side also the report's
relaxation, 400 steps, and dynamic relaxation.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh

from hyperfab.cloth import Equilibrium, Mold, Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.dynamic import swing
from hyperfab.cloth.relaxation import relax
from hyperfab.cloth.start import lowered
from hyperfab.io.stl import read_stl
from hyperfab.surface import Surface

CUP = Path(__file__).parents[1] / "molds" / "cup-male.stl"
RUBBER = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
LINE = "{:>6}  {:<24} {:>9} {:>7} {:>10} {:>10} {:>11} {:>8}"
SLOW = 100


def ball() -> Mold:
    """The model sheet's mold."""
    mesh = trimesh.creation.icosphere(subdivisions=6, radius=60.0)
    return mold_of(Surface(mesh.vertices, mesh.faces), (0.0, 0.0, 20.0))


def cup() -> Mold:
    """The sample cup, 50 mm above the sheet's plane."""
    mesh = read_stl(CUP.read_bytes(), CUP.name, "mm")
    surface = Surface(mesh.vertices, mesh.faces)
    return mold_of(surface, (0.0, 0.0, 50.0 - float(surface.bounds[0, 5])))


def memory() -> float:
    """Largest memory of this process so far, GB."""
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1e6


def row(
    n: int, name: str, side: float, mold: Mold, solve: Callable[[Sheet], Equilibrium], stretch: float = 1.0
) -> float:
    """Print one line; the CPU seconds."""
    sheet = Sheet(n, n, (side, side), 1.0, RUBBER, RUBBER, prestretch=(stretch, stretch))
    start = time.process_time()
    found = solve(sheet)
    spent = time.process_time() - start
    peak = memory()
    said = answers(sheet, mold, found)
    last = {step.nodes: step.iteration for step in found.history}  # of each grid
    figures = (
        f"{spent:.2f}",
        sum(last.values()),
        f"{found.residual_relative:.1e}",
        said.slack_springs,
        f"{said.cut.node:.0e}",
        f"{peak:.2f}",
    )
    print(LINE.format(n, name, *figures), flush=True)
    return spent


def main(sizes: list[int]) -> None:
    """Print the table."""
    model, sample = ball(), cup()
    times: dict[str, list[float]] = {}

    def quick(sheet: Sheet) -> Equilibrium:
        return drape(sheet, model if sheet.size[0] == 200.0 else sample)

    quick(Sheet(30, 30, (200.0, 200.0), 1.0, RUBBER, RUBBER))  # compile
    quick(Sheet(30, 30, (260.0, 260.0), 1.0, RUBBER, RUBBER))
    print(LINE.format("nodes", "run", "CPU s", "steps", "residual", "slack", "node in mm", "GB"))
    for n in sizes:
        for name, side, mold, stretch in (
            ("model sheet, slack", 200.0, model, 1.0),
            ("model sheet, stretched", 200.0, model, 1.1),
            ("cup", 260.0, sample, 1.0),
        ):
            times.setdefault(name, []).append(row(n, name, side, mold, quick, stretch))
        if n <= SLOW:
            for c in (40.0, 1000.0):

                def rough(sheet: Sheet, c: float = c) -> Equilibrium:
                    return relax(sheet, model, lowered(sheet, model), c, largest=400)

                row(n, f"relaxation, c = {c:g}", 200.0, model, rough)
            row(n, "dynamic", 200.0, model, lambda sheet: swing(sheet, model, lowered(sheet, model)))
    if len(sizes) > 1:
        for name, spent in times.items():
            power = np.polyfit(np.log(sizes), np.log(spent), 1)[0]
            print(f"{name}: CPU time grows as N^{power:.2f}, N nodes a side")


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [50, 100, 200, 400])
