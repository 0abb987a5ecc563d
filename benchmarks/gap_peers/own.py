"""The same by hyperfab: ``hyperfab`` walks (nearest and along the normal), ``hyperfab-tree`` its exact tree."""

import json
import sys
import time

import numpy as np

from hyperfab.pressing.search import Search
from hyperfab.surface import Surface


def both(v, f, p, n):
    search = Search(Surface(v, f))
    near, _, hit = search.both(p, n)
    return np.abs(near.distance), {
        "lost": int((hit < 0).sum()),
        "checked": "tree" if search.distrusted else "agrees",
    }


def tree(v, f, p, n):
    return np.abs(Surface(v, f).nearest(p).distance), {}


def peak():
    """Largest memory of this process, MB (getrusage would tell the parent's where that is larger)."""
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024.0


def main():
    name, pair, out = sys.argv[1:]
    work = both if name == "hyperfab" else tree
    data = np.load(pair)
    v, f, p, n = (np.ascontiguousarray(data[key]) for key in ("vertices", "faces", "points", "normals"))
    # A handful of triangles first, so that the kernels are compiled.
    work(v[:3], np.array([[0, 1, 2]]), p[:2], n[:2])
    seconds = float("inf")
    for _ in range(2):
        start = time.process_time()
        distance, told = work(v, f, p, n)
        seconds = min(seconds, time.process_time() - start)
    np.save(out, distance)
    print(json.dumps({"seconds": seconds, "peak_MB": peak(), **told}))


if __name__ == "__main__":
    main()
