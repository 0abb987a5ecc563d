"""Nearest distances by CloudCompare: ``cloudcompare.py NAME PAIR.npz FOUND.npy``, JSON on standard output.

Its seconds are those of a run with the distances less those of a run that only reads both files.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np


def write_ply(path, points, faces=None):
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property double x\nproperty double y\nproperty double z\n"
    )
    rows = b""
    if faces is not None:
        header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
        table = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
        table["count"], table["corners"] = 3, faces
        rows = table.tobytes()
    path.write_bytes((header + "end_header\n").encode() + np.ascontiguousarray(points, "<f8").tobytes() + rows)


def run(folder, *options):
    """CPU seconds of one run; files of the program's own stay in ``folder``."""
    program = shutil.which("CloudCompare") or shutil.which("cloudcompare")
    if program is None:
        sys.exit("CloudCompare is not installed")
    command = [program, "-SILENT", "-AUTO_SAVE", "OFF", "-O", "points.ply", "-O", "mesh.ply", *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(folder)}
    subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    _, pair, out = sys.argv[1:]
    data = np.load(pair)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_ply(folder / "points.ply", data["points"])
        write_ply(folder / "mesh.ply", data["vertices"], data["faces"])
        distances = ("-C2M_DIST", "-C_EXPORT_FMT", "PLY", "-PLY_EXPORT_FMT", "BINARY_LE")
        read = min(run(folder) for _ in range(2))
        seconds = min(run(folder, *distances, "-SAVE_CLOUDS", "FILE", "found.ply") for _ in range(2)) - read
        head, _, body = (folder / "found.ply").read_bytes().partition(b"end_header\n")
        columns = [line.split() for line in head.decode().splitlines() if line.startswith("property")]
        kinds = {"float": "<f4", "double": "<f8"}
        found = np.frombuffer(body, [(words[2], kinds[words[1]]) for words in columns], len(data["points"]))
    np.save(out, np.abs(found[columns[-1][2]].astype(float)))
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
    print(json.dumps({"seconds": seconds, "peak_MB": peak}))


if __name__ == "__main__":
    main()
