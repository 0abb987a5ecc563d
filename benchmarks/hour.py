"""An hour of a mold with thermostats: CPU seconds and memory of the whole command, and what the short cut errs by.

    python benchmarks/hour.py [--mesh "8 mm"] [--until "3600 s"] [--threads 1,2] [--full]

A plate of 300 x 300 x 40 mm with four bores of 700 W each, two thermostats (2 K) at mirrored places, a film h(T) and
radiation. Each run is ``hf mold-heat`` in a process of its own; its seconds are CPU time with that of the mesher.
``--full`` follows every step in full too (a quarter of an hour) and prints how far probes and work surface
differ, at the times of the run on the basis, with the switchings as they are.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from hyperfab.numerics.threads import LIMIT

BORES = (-100, -40, 40, 100)
MOLD = """format = "hyperfab.mold/1"

[material.aluminium]
density = "2702 kg/m^3"
conductivity = "237 W/m/K"
specific_heat = "903 J/kg/K"

[[part]]
name = "plate"
material = "aluminium"
box = { origin = ["-150 mm", "-150 mm", "0 mm"], size = ["300 mm", "300 mm", "40 mm"] }

[[cavity]]
name = "bores"
shapes = [
"""
BORE = (
    '    {{ name = "bore{0}", cylinder = {{ origin = ["{1} mm", "-150 mm", "20 mm"], axis = "y", '
    'length = "300 mm", radius = "8 mm" }} }},\n'
)
HEATER = """
[[heater]]
on = ["bore{0}.all", "bore{1}.all"]
power = "1400 W"
control = {{ probe = "{2}", set = "200 degC", band = "2 K" }}
"""
REST = """
[[convection]]
on = "exposed"
h = { table = "film.csv" }
ambient = "25 degC"

[[radiation]]
on = "exposed"
emissivity = 0.2
ambient = "25 degC"

[[probe]]
name = "left"
at = ["-70 mm", "0 mm", "38 mm"]

[[probe]]
name = "right"
at = ["70 mm", "0 mm", "38 mm"]

[[probe]]
name = "corner"
at = ["145 mm", "145 mm", "40 mm"]

[work_surface]
on = "plate.z+"

[run]
start = "25 degC"
"""
FILM = "temperature [degC],film coefficient [W/m^2/K]\n25,5\n50,7\n75,8\n100,9\n125,9.8\n150,10.5\n200,12\n250,13\n"


def mold(mesh: str, until: str, *, full: bool) -> str:
    """Return the mold's file."""
    cavity = "".join(BORE.format(number, x) for number, x in enumerate(BORES, 1)) + "]\n"
    heaters = HEATER.format(1, 2, "left") + HEATER.format(3, 4, "right")
    run = f'until = "{until}"\nmesh_size = "{mesh}"\n' + ("reduced = false\n" if full else "")
    return MOLD + cavity + heaters + REST + run


def main() -> None:
    """Print a line a run, and how far the runs differ."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default="8 mm", help="length of edges")
    parser.add_argument("--until", default="3600 s")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--full", action="store_true", help="in full too")
    options = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "film.csv").write_text(FILM)
        Path(folder, "reduced.toml").write_text(mold(options.mesh, options.until, full=False))
        Path(folder, "full.toml").write_text(mold(options.mesh, options.until, full=True))
        for threads in options.threads.split(","):
            follow(Path(folder), "reduced", threads)
        if options.full:
            follow(Path(folder), "full", threads)
            differences(Path(folder))


def follow(folder: Path, name: str, threads: str) -> None:
    """Run the command and print what it took."""
    one = {"OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", LIMIT: threads}
    program = "from hyperfab.cli import main; main()"
    command = [sys.executable, "-c", program, "mold-heat", f"{name}.toml", "-o", f"{name}.json"]
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]))
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = os.environ | one | {"PYTHONPATH": path}
    subprocess.run(command, check=True, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    document = json.loads((folder / f"{name}.json").read_text())
    unknowns, told = document["unknowns"], document.get("reduced")
    print(
        f"{name:8} {unknowns} unknowns, {threads} threads: CPU {cpu:7.1f} s, "
        f"clock {time.perf_counter() - clock:7.1f} s, peak so far {after.ru_maxrss / 2**20:.2f} GB; {told}",
        flush=True,
    )


def differences(folder: Path) -> None:
    """Print how far the run on the basis is from that in full."""
    for suffix in (".csv", ".history.csv"):
        reduced, full = (pd.read_csv(folder / f"{name}{suffix}") for name in ("reduced", "full"))
        for column in reduced.columns[1:]:
            there = np.interp(reduced["time_s"], full["time_s"], full[column])
            print(f"{suffix} {column:30} differs by at most {np.abs(reduced[column] - there).max():.5f}")


if __name__ == "__main__":
    main()
