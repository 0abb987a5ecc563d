"""The sphere on the disc by this program, FElupe and CalculiX: CPU seconds and error of the force, in one run.

    python benchmarks/contact.py [--peers PYTHON] [--cells 40] [--calculix-cells 40]

A sphere of radius 40 mm is pushed 60 mm, in 8 steps, into a clamped neo-Hookean disc of diameter 200 mm (C10 0.2 MPa,
1 mm thick, frictionless); the force is known from two other methods, 41.576556565 N. FElupe (installed apart: pip
install felupe pypardiso) has linear hexahedra, one thin layer on a quarter of the disc, and a penalty against the
sphere; its steps are halved where they fail. CalculiX (ccx, as Debian packages it: calculix-ccx) has C3D8I hexahedra,
also one thin layer on a quarter, node-to-surface contact with a stiff spring, and steps of its own choice. Seconds are
CPU of the whole process, with kernels compiled before, the better of two runs (of CalculiX one). A dash: not
installed, or no result; the reason is printed to standard error.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

FORCE = 41.576556565
PEERS = Path(__file__).parent / "contact_peers"
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has FElupe")
    parser.add_argument("--cells", default="40", help="cells along a side of FElupe's mesh")
    parser.add_argument("--calculix-cells", default="40", help="cells along a side of CalculiX's mesh; 0 leaves it out")
    options = parser.parse_args()
    print("| program | linear solver | unknowns | CPU s | error of the force |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        sheet = Path(folder) / "sheet.json"
        sheet.write_text('{"format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}}')
        for mesh in ("16mm", "8mm", "4mm"):
            command = [sys.executable, "-m", "hyperfab", "fabric-contact", str(sheet), "--mesh-size", mesh]
            row("hyperfab", "its own", [*command, "--quiet", "-o", "-"])
    for solver in ("scipy", "pardiso"):
        row("FElupe", solver, [options.peers, str(PEERS / "with_felupe.py"), options.cells, solver])
    if options.calculix_cells != "0":
        calculix = [sys.executable, str(PEERS / "with_calculix.py"), options.calculix_cells]
        row("CalculiX", "SPOOLES", calculix, times=1)


def row(program: str, solver: str, command: list[str], times: int = 2) -> None:
    """Run a command some times and print its line."""
    runs = [run for _ in range(times) if (run := measured(command)) is not None]
    if not runs:
        print(f"| {program} | {solver} | – | – | – |", flush=True)
        return
    seconds, found = min(run[0] for run in runs), runs[0][1]
    solver = found.get("linear_solver", solver)
    error = abs(found["force_N"] / FORCE - 1.0)
    print(f"| {program} | {solver} | {found['unknowns']} | {seconds:.2f} | {error:.1e} |", flush=True)


def measured(command: list[str]) -> tuple[float, dict] | None:
    """Return CPU seconds and what was printed, None where the program is missing or fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, check=False, env={**os.environ, **ONE_THREAD})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        print(done.stderr.decode().strip().rpartition("\n")[2], file=sys.stderr)
        return None
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, json.loads(done.stdout)


if __name__ == "__main__":
    main()
