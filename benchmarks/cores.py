"""Two threads against one, and the same bytes with one, two and three: drape, gap, membrane and heat.

    python benchmarks/cores.py [--small] [--pairs 3] [TASK ...]

Tasks: drape (400 by 400 nodes over a ball), gap (a million triangles: tree, nearest points and rays), membrane (a
sphere on a sheet of some 100,000 unknowns, three steps of load), heat (350,000 unknowns of degree 2, 30 steps with a
film, after the set-up). Each run is a process of its own, with its kernels compiled and a small case run before the
clock starts; runs of one and two threads alternate, and the least of each counts. Seconds are those of the clock: the
machine must be quiet. About seven minutes; ``--small`` takes sizes for a test of the script.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hyperfab.numerics.threads import LIMIT

HERE = Path(__file__).parent
#: Size of each task, and that for a test of the script.
SIZES = {
    "drape": (400, 60),
    "gap": (1_000_000, 20_000),
    "membrane": (1.15, 6.0),  # mm, edge length of the elements
    "heat": (7.4, 25.0),  # mm
}
WANTED = 1.6


def drape(size: float) -> Callable[[], bytes]:
    """Return the drape to be timed."""
    sys.path.insert(0, str(HERE))
    from drape import RUBBER, ball

    from hyperfab.cloth import Sheet
    from hyperfab.cloth import drape as solve

    mold = ball()

    def work(nodes: int = int(size)) -> bytes:
        found = solve(Sheet(nodes, nodes, (200.0, 200.0), 1.0, RUBBER, RUBBER), mold)
        return found.state.x.tobytes() + found.force.tobytes()

    work(30)
    return work


def gap(size: float) -> Callable[[], bytes]:
    """Return the search to be timed: building the tree too."""
    sys.path.insert(0, str(HERE))
    from gap import write_pair

    from hyperfab.surface import Surface
    from hyperfab.surface.curve import along_a_curve

    with tempfile.TemporaryDirectory() as folder:
        write_pair(int(size), Path(folder, "pair.npz"))
        with np.load(Path(folder, "pair.npz")) as data:
            v, f, p, n = (np.ascontiguousarray(data[key]) for key in ("vertices", "faces", "points", "normals"))

    def work(faces: np.ndarray = f, points: np.ndarray = p, normals: np.ndarray = n) -> bytes:
        surface, order = Surface(v, faces), along_a_curve(points)
        near, (along, facet) = (
            surface.nearest(points, order=order),
            surface.along(points, normals, order=order),
        )
        return near.distance.tobytes() + along.tobytes() + facet.tobytes()

    work(f[:50], p[:50], n[:50])
    return work


def membrane(size: float) -> Callable[[], bytes]:
    """Return the command to be timed, in this process."""
    from hyperfab.cli import main

    folder = Path(tempfile.mkdtemp())
    material = {"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}}
    (folder / "sheet.json").write_text(json.dumps(material))
    os.chdir(folder)

    def work(mesh: float = size) -> bytes:
        sys.argv = [
            "hf",
            "fabric-contact",
            "sheet.json",
            "--mesh-size",
            f"{mesh}mm",
            "--depth",
            "30mm",
            "--steps",
            "3",
        ]
        sys.argv += ["--uncertainty", "none", "--quiet", "-o", "out.json"]
        try:
            main()
        except SystemExit as ended:
            if ended.code:
                raise
        return (folder / "out.json").read_bytes() + (folder / "out.vtu").read_bytes()

    work(12.0)
    return work


def heat(size: float) -> Callable[[], bytes]:
    """Return the time steps to be timed."""
    sys.path[:0] = [str(HERE), str(HERE / "heat_peers")]
    from heat import write_mesh
    from ours import FILM, STEP, degree_two, facets

    from hyperfab.thermal.condition import Convection, Heater
    from hyperfab.thermal.medium import ThermalMaterial
    from hyperfab.thermal.model import HeatModel
    from hyperfab.thermal.tables import Table

    with tempfile.TemporaryDirectory() as folder:
        write_mesh(Path(folder, "mesh.npz"), size)
        with np.load(Path(folder, "mesh.npz")) as data:
            mesh = degree_two(data["points"], data["elements"])
            bottom, exposed = facets(mesh, data["bottom"]), facets(mesh, data["exposed"])
    aluminium = ThermalMaterial("aluminium", 2702.0, Table.constant(237.0), Table.constant(903.0))
    heater = Heater("heater", bottom.load(1.0) / bottom.area, Table.constant(3000.0))
    model = HeatModel(mesh, [aluminium], [heater, Convection("air", exposed, FILM, Table.constant(25.0))])

    def work(steps: int = 30) -> bytes:
        temperature = before = np.full(model.size, 25.0)
        for number in range(steps):
            stored, rate = model.medium.stored(temperature), model.flow(number * STEP, temperature)
            reference = STEP * float(np.sqrt(np.einsum("i,i->", rate, rate)))
            guess = 2.0 * temperature - before
            after, _ = model.solve_stage((number + 1) * STEP, STEP, stored, guess, reference=reference)
            before, temperature = temperature, after
        return temperature.tobytes()

    work(1)
    return work


def main() -> None:
    """Print a line for each task."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", metavar="TASK", help=", ".join(SIZES))
    parser.add_argument("--small", action="store_true", help="sizes for a test of this script")
    parser.add_argument("--pairs", type=int, default=3, help="runs of one and of two threads")
    parser.add_argument("--alone", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.alone:
        alone(options.tasks[0], options.small)
        return
    print(f"load {os.getloadavg()[0]:.1f}; seconds of the clock, least of {options.pairs}")
    print(f"{'task':9} {'1 thread':>9} {'2 threads':>9} {'ratio':>6}  bytes with 1, 2, 3 threads")
    for task in options.tasks or SIZES:
        pairs = [[run(task, options.small, threads) for threads in (1, 2)] for _ in range(options.pairs)]
        one, two = (min(pair[i][0] for pair in pairs) for i in (0, 1))
        found = {run[1] for pair in pairs for run in pair} | {run(task, options.small, 3)[1]}
        verdict = "" if one / two >= WANTED else f"  below {WANTED}"
        same = "the same" if len(found) == 1 else "DIFFERENT"
        print(f"{task:9} {one:9.2f} {two:9.2f} {one / two:6.2f}  {same}{verdict}", flush=True)


def run(task: str, small: bool, threads: int) -> tuple[float, str]:
    """Run a task in a process of its own; seconds, and a digest of its answer."""
    command = [sys.executable, __file__, task, "--alone", *(["--small"] if small else [])]
    one = {"OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", LIMIT: str(threads)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | one)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    seconds, digest = done.stdout.split()
    return float(seconds), digest


def alone(task: str, small: bool) -> None:
    """Print the seconds of a task and a digest of its answer."""
    work = globals()[task](SIZES[task][small])
    start = time.perf_counter()
    answer = work()
    print(time.perf_counter() - start, hashlib.sha256(answer).hexdigest())


if __name__ == "__main__":
    main()
