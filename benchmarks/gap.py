"""The gap between the sample cup's molds by several programs: CPU seconds, memory and agreement, in one run.

    python benchmarks/gap.py [--sizes 50000,200000,1000000] [--peers PYTHON]

Each program is given the female's triangles and the male's vertices, in a process of its own. hyperfab finds the
nearest point, then the hit along the male's normal too, on one thread and on two; the others (installed apart: pip
install libigl open3d point-cloud-utils trimesh rtree; Debian's package cloudcompare) find the nearest point alone.
Seconds are CPU time of the whole process for the nearest point, after import and compilation, the better of two runs,
with building whatever is searched; for hyperfab also CPU time, and that of the clock, for both. Of CloudCompare it is
the time of its process less that of one that only reads the files. The difference is the largest one from libigl's
distances, or from hyperfab's own where libigl is not there.
A dash: not installed, or (trimesh above 60,000 triangles) far too slow.
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

from hyperfab.numerics.threads import LIMIT
from hyperfab.pressing.curved import smooth_normals
from hyperfab.pressing.gap import molding_front
from hyperfab.pressing.mold import mold
from hyperfab.samples.cup import female_cup, male_cup
from hyperfab.surface import Surface

PEERS = Path(__file__).parent / "gap_peers"
PROGRAMS = (
    "hyperfab",
    "hyperfab-2",
    "libigl",
    "open3d",
    "point-cloud-utils",
    "trimesh",
    "cloudcompare",
)
TRIMESH_LIMIT = 60_000


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="50000,200000,1000000")
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has the other programs")
    options = parser.parse_args()
    print(
        f"{'triangles':>10} {'program':>18} {'CPU s':>8} {'both s':>8} {'wall s':>8} {'peak MB':>8} "
        f"{'difference mm':>14}  lost"
    )
    with tempfile.TemporaryDirectory() as folder:
        for size in map(int, options.sizes.split(",")):
            table(size, Path(folder), options.peers)


def table(size: int, folder: Path, peers: str) -> None:
    """Print the rows of one size."""
    faces = write_pair(size, folder / "pair.npz")
    runs = {name: run(name, folder, peers, faces) for name in PROGRAMS}
    reference = next(runs[name][1] for name in ("libigl", "hyperfab") if runs[name] is not None)
    for name, found in runs.items():
        if found is None:
            print(f"{faces:>10} {name:>18} {'-':>8}")
            continue
        told, distance = found
        error = np.abs(distance - reference).max()
        extra = f"{told['lost']:>5}" if "lost" in told else ""
        both, wall = (f"{told[key]:>8.3f}" if key in told else f"{'':>8}" for key in ("both", "wall"))
        print(
            f"{faces:>10} {name:>18} {told['seconds']:>8.3f} {both} {wall} {told['peak_MB']:>8.0f} "
            f"{error:>14.1e} {extra}"
        )
    ours = runs["hyperfab"]
    others = [runs[name][0]["seconds"] for name in PROGRAMS[2:] if runs[name] is not None]
    if ours is not None and others:
        nearest, both = (min(others) / ours[0][key] for key in ("seconds", "both"))
        print(f"{'':>10} nearest in 1/{nearest:.1f} of the best other's, nearest and normal in 1/{both:.1f}")
    two = runs["hyperfab-2"]
    if ours is not None and two is not None:
        same = "the same" if np.array_equal(ours[1], two[1]) else "OTHER"
        print(f"{'':>10} two threads {ours[0]['wall'] / two[0]['wall']:.2f} times as fast as one, {same} bytes\n")


def write_pair(size: int, path: Path) -> int:
    """Write the pair with about ``size`` triangles each; return the female's number."""
    cells = round((size / 2.0) ** 0.5)
    one, two = male_cup(cells - 4, cells - 4), female_cup(cells - 7, cells - 2)
    male, female = mold(one.vertices, one.faces, 1), mold(two.vertices, two.faces, -1)
    front = molding_front(male, female)
    normals = smooth_normals(Surface(front.vertices, front.faces))
    np.savez(path, vertices=two.vertices, faces=two.faces, points=front.vertices, normals=normals)
    return len(two.faces)


def run(name: str, folder: Path, peers: str, faces: int) -> tuple[dict, np.ndarray] | None:
    """Run one program in its own process: what it tells of itself, and its distances; None where it is missing."""
    if name == "trimesh" and faces > TRIMESH_LIMIT:
        return None
    ours = name.startswith("hyperfab")
    script = PEERS / ("own.py" if ours else "cloudcompare.py" if name == "cloudcompare" else "nearest.py")
    python = sys.executable if ours else peers
    command = [python, str(script), name, str(folder / "pair.npz"), str(folder / "found.npy")]
    alone = {**os.environ, LIMIT: "2" if name == "hyperfab-2" else "1"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=alone)
    if done.returncode != 0:
        print(f"{name}: {done.stderr.strip().splitlines()[-1:] or 'failed'}", file=sys.stderr)
        return None
    return json.loads(done.stdout), np.load(folder / "found.npy")


if __name__ == "__main__":
    main()
