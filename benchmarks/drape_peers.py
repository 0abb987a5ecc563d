"""The drape of one sheet by several programs: CPU seconds to equal position error, in one run.

    python benchmarks/drape_peers.py [--sizes 50,100,200] [--peers PYTHON]

A sheet of 200 x 200 x 1 mm, clamped, over a ball of radius 60 mm of 82 000 facets that stands 80 mm above its plane.
So that all can express it the springs are linear (1 MPa) and the sheet is mounted stretched by 1.1, which leaves none
slack. All start from the same sheet lowered onto the ball. ``newton-vbd`` is vertex block descent of NVIDIA Newton on
Warp (installed apart: pip install newton), at three time steps with damping tuned to the grid, the best of them at
each error; ``direct`` is Newton's method with SciPy's sparse direct solver on one grid. Errors are rms over the nodes
against hyperfab at a residual of 1e-10. Residual, energy (relative to hyperfab's) and penetration are those of a
program's best place; before residual and energy are taken, nodes in the mold are put on it. Seconds are CPU time after
import and compilation.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh

from hyperfab.cloth import Mold, Sheet, drape, mold_of, piecewise_linear
from hyperfab.cloth.balance import Balance
from hyperfab.cloth.start import lowered, settled
from hyperfab.surface import Surface

PEERS = Path(__file__).parent / "drape_peers"
LINEAR = piecewise_linear([1.0, 2.0], [0.0, 1.0])
ERRORS = (1e-1, 3e-2, 1e-2)
LINE = "{:>5}  {:<16}" + "{:>9}" * len(ERRORS) + "{:>11} {:>10} {:>10} {:>10}"
NOTES = """
What newton-vbd cannot express: springs that carry no pressure (a sheet with slack springs), a nonlinear law, a mold
that nothing enters (its contact is a penalty). The model sheet of benchmarks/drape.py has all three: no figure of it.
direct knows one grid. It comes to rest in other facets than hyperfab, some 1e-3 mm away: both are equilibria."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="50,100,200")
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has newton")
    options = parser.parse_args()
    ball = trimesh.creation.icosphere(subdivisions=6, radius=60.0)
    surface = Surface(ball.vertices + np.array([0.0, 0.0, 20.0]), ball.faces)
    mold = mold_of(surface)
    drape(sheet_of(30), mold)  # compile
    errors = (f"{error:.0e} mm" for error in ERRORS)
    print(LINE.format("nodes", "program", *errors, "best mm", "residual", "energy", "inside mm"))
    with tempfile.TemporaryDirectory() as folder:
        for n in map(int, options.sizes.split(",")):
            table(n, surface, mold, Path(folder), options.peers)
    print(NOTES)


def sheet_of(n: int) -> Sheet:
    """n by n nodes."""
    return Sheet(n, n, (200.0, 200.0), 1.0, LINEAR, LINEAR, prestretch=(1.1, 1.1))


def table(n: int, surface: Surface, mold: Mold, folder: Path, peers: str) -> None:
    """Print the rows of one size."""
    sheet = sheet_of(n)
    exact = drape(sheet, mold, 1e-10)
    reference = exact.state.x
    problem = folder / "problem.npz"
    np.savez(problem, **problem_of(sheet, mold, surface), reference=reference.reshape(-1, 3))
    ours, theirs = own(sheet, mold, reference), {}
    theirs["newton-vbd"] = vbd(n, problem, folder, peers)
    theirs["direct"] = run(sys.executable, "direct.py", problem, folder / "found.npz", "120")
    print_row(n, "hyperfab", sheet, surface, mold, ours, exact.energy)
    for name, found in theirs.items():
        if found is None:
            print(f"{n:>5}  {name:<16}{'-':>9}")
            continue
        print_row(n, name, sheet, surface, mold, found, exact.energy)
        ratios = []
        for error in ERRORS:
            one, other = first(ours[0], error), first(found[0], error)
            ratios.append("" if one is None or other is None else f"{other / one:.0f} x")
        print(LINE.format("", "", *ratios, *4 * [""]))


def problem_of(sheet: Sheet, mold: Mold, surface: Surface) -> dict[str, np.ndarray]:
    """The problem as arrays that any program takes."""
    n, net = sheet.n, sheet.arrays
    number = np.arange(n * n).reshape(n, n)
    warp = np.stack([number[:-1], number[1:]], 2).reshape(-1, 2)
    weft = np.stack([number[:, :-1], number[:, 1:]], 2).reshape(-1, 2)
    rest = np.repeat(net.rest[:2], [len(warp), len(weft)])
    area = np.concatenate([np.tile(net.warp_area, n - 1), np.repeat(net.weft_area, n - 1)])
    return {
        "n": np.array(n),
        "x": lowered(sheet, mold).x.reshape(-1, 3),
        "fixed": (sheet.fixed != 0).ravel(),
        "springs": np.concatenate([warp, weft]),
        "rest": rest,
        "stiffness": area / rest,
        "vertices": surface.vertices,
        "faces": surface.faces,
    }


def own(sheet: Sheet, mold: Mold, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """hyperfab at rising tolerance: (seconds, error), and the last place."""
    line = []
    for tolerance in (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8):
        start = time.process_time()
        x = drape(sheet, mold, tolerance).state.x
        line.append((time.process_time() - start, np.sqrt(((x - reference) ** 2).sum(2).mean())))
    return np.array(line), x.reshape(-1, 3)


def vbd(n: int, problem: Path, folder: Path, peers: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Vertex block descent at three time steps: all their (seconds, error), and the best place."""
    lines, best = [], None
    for dt, iterations in ((2.0, 4), (3.0, 4), (4.0, 10)):
        damping = 1.0 - 10.0 / n * dt / 3.0  # of the slowest mode, about critical
        seconds = 1.25 * (n / 50) ** 2
        found = run(
            peers,
            "vbd.py",
            problem,
            folder / "found.npz",
            f"{dt}",
            f"{iterations}",
            f"{damping}",
            f"{seconds}",
        )
        if found is None:
            return None
        if best is None or found[0][:, 1].min() < min(line[:, 1].min() for line in lines):
            best = found[1]
        lines.append(found[0])
    return np.concatenate(lines), best


def run(python: str, script: str, *words: object) -> tuple[np.ndarray, np.ndarray] | None:
    """Run one program in its own process: its (seconds, error) and best place; None where it is missing."""
    command = [python, str(PEERS / script), *(str(word) for word in words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"{script}: {done.stderr.strip().splitlines()[-1:] or 'failed'}", file=sys.stderr)
        return None
    print(done.stdout.strip().splitlines()[-1], file=sys.stderr)
    found = np.load(words[1])
    return found["line"], found["x"]


def first(line: np.ndarray, error: float) -> float | None:
    """Least seconds to ``error`` mm."""
    reached = line[line[:, 1] <= error, 0]
    return float(reached.min()) if len(reached) else None


def print_row(
    n: int,
    name: str,
    sheet: Sheet,
    surface: Surface,
    mold: Mold,
    found: tuple[np.ndarray, np.ndarray],
    energy: float,
) -> None:
    """One program's row."""
    line, x = found
    times = ["never" if (at := first(line, error)) is None else f"{at:.2f}" for error in ERRORS]
    inside = max(0.0, -float(surface.nearest(x).distance.min()))
    state = settled(x.reshape(n, n, 3), mold, sheet, np.full((n, n), 1e-9))
    balance = Balance(sheet, mold, 1e-6)
    balance.forces(state)
    balance.settle(state)
    figures = (f"{line[:, 1].min():.1e}", f"{balance.residual:.1e}")
    figures += (f"{abs(balance.energy / energy - 1.0):.0e}", f"{inside:.0e}")
    print(LINE.format(n, name, *times, *figures), flush=True)


if __name__ == "__main__":
    main()
