"""The benchmark's steps with this program: python ours.py MESH.npz linear|film STEPS."""

from __future__ import annotations

import json
import resource
import sys
import time

import numpy as np

from hyperfab.thermal.condition import Convection, Heater
from hyperfab.thermal.facet_operator import FacetOperator
from hyperfab.thermal.locate import Locator
from hyperfab.thermal.medium import ThermalMaterial
from hyperfab.thermal.mesh import EDGES, HeatMesh, build_mesh
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.tables import Table

FILM = Table(np.array([25.0, 50, 100, 150, 200, 250]), np.array([5.0, 7, 9, 10.5, 12, 13]))
STEP = 30.0
PROBES = ((0.0, 0.0, 0.135), (0.0, 0.0, 0.0), (0.17, 0.15, 0.13))


def degree_two(vertices, tetrahedra) -> HeatMesh:
    """Put a node in the middle of every edge."""
    ends = np.sort(tetrahedra[:, EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    points = np.concatenate([vertices, vertices[edges].mean(axis=1)])
    elements = np.concatenate([tetrahedra, len(vertices) + number.reshape(-1, 6)], axis=1)
    return build_mesh(points, elements, np.zeros(len(elements), dtype=np.int64))


def facets(mesh: HeatMesh, triangles):
    """Return the outer facets (f, 6) on the given triangles of vertices."""
    all_nodes = mesh.facet_nodes(mesh.facets.outer)
    wanted = {tuple(row) for row in np.sort(triangles, axis=1).tolist()}
    chosen = [tuple(row) in wanted for row in np.sort(all_nodes[:, :3], axis=1).tolist()]
    return FacetOperator(mesh.points, all_nodes[chosen])


def main() -> None:
    """Run the steps and print one line of JSON."""
    data, mode, steps = np.load(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    mesh = degree_two(data["points"], data["elements"])
    bottom, exposed = facets(mesh, data["bottom"]), facets(mesh, data["exposed"])
    clock = time.process_time()
    film = Table.constant(10.0) if mode == "linear" else FILM
    aluminium = ThermalMaterial("aluminium", 2702.0, Table.constant(237.0), Table.constant(903.0))
    heater = Heater("heater", bottom.load(1.0) / bottom.area, Table.constant(3000.0))
    model = HeatModel(mesh, [aluminium], [heater, Convection("air", exposed, film, Table.constant(25.0))])
    temperature = before = np.full(model.size, 25.0)
    stored, rate = model.medium.stored(temperature), model.flow(0.0, temperature)
    spent = [time.process_time() - clock]
    for number in range(steps):
        clock = time.process_time()
        guess = 2.0 * temperature - before
        reference = STEP * float(np.sqrt(np.einsum("i,i->", rate, rate)))
        after, _ = model.solve_stage((number + 1) * STEP, STEP, stored, guess, reference=reference)
        before, temperature = temperature, after
        now = model.medium.stored(temperature)
        stored, rate = now, (now - stored) / STEP
        spent.append(time.process_time() - clock)
    locator = Locator(mesh.points, mesh.elements)
    at = [float(locator.sensor(np.array(place)) @ temperature) for place in PROBES]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    step = float(np.mean(spent[2:])) if steps > 1 else spent[1]
    print(json.dumps({"setup": spent[0], "first": spent[1], "step": step, "gigabytes": memory, "at": at}))


if __name__ == "__main__":
    main()
