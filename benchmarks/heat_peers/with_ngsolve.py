"""The benchmark's steps with NGSolve: python with_ngsolve.py MESH.npz linear|newton|frozen STEPS; 77: not installed."""

from __future__ import annotations

import json
import resource
import sys
import time

import numpy as np

try:
    import netgen.meshing as nm
    import ngsolve as ng
except ImportError:
    raise SystemExit(77) from None

STEP = 30.0
FILM = ([25.0, 50, 100, 150, 200, 250], [5.0, 7, 9, 10.5, 12, 13])
PROBES = ((0.0, 0.0, 0.135), (0.0, 0.0, 0.0), (0.17, 0.15, 0.13))


def read_mesh(data):
    """Give NGSolve the mesh as it is, straight-sided."""
    mesh = nm.Mesh(dim=3)
    for number, name in enumerate(("bottom", "exposed"), 1):
        mesh.Add(nm.FaceDescriptor(surfnr=number, domin=1, domout=0, bc=number))
        mesh.SetBCName(number - 1, name)
    ids = [mesh.Add(nm.MeshPoint(nm.Pnt(*map(float, point)))) for point in data["points"]]
    for nodes in data["elements"][:, [0, 2, 1, 3]]:
        mesh.Add(nm.Element3D(1, [ids[i] for i in nodes]))
    for number, name in enumerate(("bottom", "exposed"), 1):
        for nodes in data[name]:
            mesh.Add(nm.Element2D(number, [ids[i] for i in nodes]))
    return ng.Mesh(mesh)


def film(temperature):
    """Return the film coefficient as a coefficient function."""
    x, y = FILM
    value = ng.CF(y[0])
    for i in range(len(x) - 1):
        slope = (y[i + 1] - y[i]) / (x[i + 1] - x[i])
        value = ng.IfPos(temperature - x[i], y[i] + slope * (temperature - x[i]), value)
    return ng.IfPos(temperature - x[-1], y[-1], value)


def main() -> None:
    """Run the steps and print one line of JSON."""
    ng.SetNumThreads(1)
    data, mode, steps = np.load(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    mesh = read_mesh(data)
    clock = time.process_time()
    space = ng.H1(mesh, order=2)
    u, v = space.TnT()
    capacity, k = 2702.0 * 903.0, 237.0
    flux = 3000.0 / ng.Integrate(1, mesh, ng.BND, definedon=mesh.Boundaries("bottom"))
    now, before = ng.GridFunction(space), ng.GridFunction(space)
    now.Set(25.0)
    spent = []
    if mode == "linear":
        mass, matrix, load = ng.BilinearForm(space), ng.BilinearForm(space), ng.LinearForm(space)
        mass += capacity * u * v * ng.dx
        matrix += (capacity * u * v + STEP * k * ng.grad(u) * ng.grad(v)) * ng.dx
        matrix += STEP * 10.0 * u * v * ng.ds("exposed")
        load += STEP * flux * v * ng.ds("bottom") + STEP * 250.0 * v * ng.ds("exposed")
        for form in (mass, matrix, load):
            form.Assemble()
        inverse = matrix.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
        right = now.vec.CreateVector()
        spent.append(time.process_time() - clock)
        for _ in range(steps):
            clock = time.process_time()
            right.data = mass.mat * now.vec + load.vec
            now.vec.data = inverse * right
            spent.append(time.process_time() - clock)
    else:
        form = ng.BilinearForm(space)
        form += (capacity * (u - before) * v + STEP * k * ng.grad(u) * ng.grad(v)) * ng.dx
        form += STEP * film(u) * (u - 25.0) * v * ng.ds("exposed")
        form += -STEP * flux * v * ng.ds("bottom")
        residual, change = now.vec.CreateVector(), now.vec.CreateVector()
        inverse = None
        spent.append(time.process_time() - clock)
        for _ in range(steps):
            clock = time.process_time()
            before.vec.data = now.vec
            start = None
            for _newton in range(20):
                form.Apply(now.vec, residual)
                size = ng.Norm(residual)
                start = start or size
                if size < 1e-6 * start:
                    break
                if mode == "newton" or inverse is None:
                    form.AssembleLinearization(now.vec)
                    inverse = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
                change.data = inverse * residual
                now.vec.data -= change
            spent.append(time.process_time() - clock)
    at = [now(mesh(*place)) for place in PROBES]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    step = float(np.mean(spent[2:])) if steps > 1 else spent[1]
    print(json.dumps({"setup": spent[0], "first": spent[1], "step": step, "gigabytes": memory, "at": at}))


if __name__ == "__main__":
    main()
