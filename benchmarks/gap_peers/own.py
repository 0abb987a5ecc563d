"""The same by hyperfab: nearest gap and gap along the normal."""

import json
import sys
import time

import numpy as np

from hyperfab.surface import Surface
from hyperfab.surface.curve import along_a_curve


def work(v, f, p, n):
    surface, order = Surface(v, f), along_a_curve(p)
    distance = np.abs(surface.nearest(p, order=order).distance)
    return distance, {"lost": int((surface.along(p, n, order=order)[1] < 0).sum())}


def peak():
    """Largest memory of this process, MB (getrusage would tell the parent's where that is larger)."""
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024.0


def main():
    _, pair, out = sys.argv[1:]
    data = np.load(pair)
    v, f, p, n = (np.ascontiguousarray(data[key]) for key in ("vertices", "faces", "points", "normals"))
    # A handful of triangles first, so that the kernels are compiled.
    work(v[:3], np.array([[0, 1, 2]]), p[:2], n[:2])
    seconds, wall = float("inf"), float("inf")
    for _ in range(2):
        start, clock = time.process_time(), time.perf_counter()
        distance, told = work(v, f, p, n)
        seconds = min(seconds, time.process_time() - start)
        wall = min(wall, time.perf_counter() - clock)
    np.save(out, distance)
    print(json.dumps({"seconds": seconds, "wall": wall, "peak_MB": peak(), **told}))


if __name__ == "__main__":
    main()
