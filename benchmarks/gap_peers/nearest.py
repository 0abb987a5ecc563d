"""Nearest distances by one of the other programs: ``nearest.py NAME PAIR.npz FOUND.npy``, JSON on standard output."""

import json
import sys
import time

import numpy as np


def libigl():
    import igl

    return lambda v, f, p: np.sqrt(igl.point_mesh_squared_distance(p, v, f)[0])


def open3d():
    import open3d as o3d

    def search(v, f, p):
        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(o3d.core.Tensor(v.astype(np.float32)), o3d.core.Tensor(f.astype(np.uint32)))
        found = scene.compute_closest_points(o3d.core.Tensor(p.astype(np.float32)))
        return np.linalg.norm(found["points"].numpy() - p, axis=1)

    return search


def point_cloud_utils():
    import point_cloud_utils as pcu

    return lambda v, f, p: pcu.closest_points_on_mesh(p, v, f)[0]


def trimesh():
    import trimesh as tm

    def search(v, f, p):
        return tm.proximity.closest_point(tm.Trimesh(v, f, process=False), p)[1]

    return search


def peak():
    """Largest memory of this process, MB (getrusage would tell the parent's where that is larger)."""
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024.0


def main():
    name, pair, out = sys.argv[1:]
    search = {"libigl": libigl, "open3d": open3d, "point-cloud-utils": point_cloud_utils, "trimesh": trimesh}[name]()
    data = np.load(pair)
    v, f, p = data["vertices"], data["faces"], data["points"]
    seconds = float("inf")
    for _ in range(2):
        start = time.process_time()
        distance = search(v, f, p)
        seconds = min(seconds, time.process_time() - start)
    np.save(out, np.asarray(distance, dtype=float).ravel())
    print(json.dumps({"seconds": seconds, "peak_MB": peak()}))


if __name__ == "__main__":
    main()
