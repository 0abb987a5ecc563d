"""Parts cut into zones, each with a mean temperature of its own: what a material does there goes by that.

A part that is hotter at one end conducts otherwise there; by one mean of the part alone a steel with 30 K from end to
end was off by a quarter of a kelvin. Elements may be as thick as a part: zones are of points of quadrature.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array, Ints
from hyperfab.thermal import elements
from hyperfab.thermal.medium import CHUNK
from hyperfab.thermal.model import HeatModel
from hyperfab.thermal.run_basis import SOLVE


class Zone(NamedTuple):
    """What a zone stores [J/K] and conducts [W/K] (n, n), its material as it is at 50 degC."""

    storing: sparse.csr_matrix
    conducting: sparse.csr_matrix


def halved(places: Array, warm: Array, zones: int) -> list[Ints]:
    """Return which of ``places`` (n, 3) are in each of so many ``zones``, a power of two: halves of as many places
    along the side that parts what is ``warm`` (n,) the most, else the longest, and halves of these.

    >>> places = np.array([[3.0, 0, 0], [0, 1, 0], [2, 1, 0], [1, 0, 0]])
    >>> [[one.tolist() for one in halved(places, warm, 2)] for warm in (np.zeros(4), np.array([0.0, 1.0, 1.0, 0.0]))]
    [[[1, 3], [0, 2]], [[0, 3], [1, 2]]]
    """
    found = [np.arange(len(places))]
    while len(found) < zones:
        pieces = []
        for one in found:
            inside, ways = places[one], []
            for along in inside.T:
                low, high = np.array_split(one[np.argsort(along, kind="stable")], 2)
                apart = abs(float(np.mean(warm[low]) - np.mean(warm[high]))) if len(low) * len(high) else 0.0
                ways.append((apart, float(np.ptp(along)) if len(one) else 0.0, low, high))
            best = max(ways, key=lambda way: way[:2])
            pieces += [np.sort(half) for half in best[2:]]
        found = pieces
    return found


def warmed(model: HeatModel, powers: Sequence[Array], scale: float) -> Array:
    """Return how warm (n,) [K] a mold becomes by all ``powers`` (n,) [W] within about ``scale`` [s]."""
    cold = np.zeros(model.size)
    power = np.sum([cold, *powers], axis=0)
    return model.solve(model.step_matrix(0.0, scale, cold), power, SOLVE) if np.any(power) else cold


def by_zone(model: HeatModel, zones: int, warm: Array) -> list[Zone]:
    """Return so many ``zones`` of each part, one part's after the other's, by where it is ``warm`` (n,)."""
    found, shapes = list[Zone](), elements.TETRAHEDRON.tables[0]
    for part, material in enumerate(model.materials):
        nodes = model.mesh.elements[model.mesh.parts == part]
        places = np.einsum("qi,mid->mqd", shapes, model.mesh.points[nodes]).reshape(-1, 3)
        at = (warm[nodes] @ shapes.T).ravel()
        stores = material.density * material.specific_heat.at(50.0)
        for chosen in halved(places, at, zones):
            inside = np.zeros(len(places))
            inside[chosen] = 1.0
            share = inside.reshape(len(nodes), -1)
            conducts = material.conductivity.at(50.0) * share
            storing = _summed(model, nodes, elements.mass, stores * share)
            found.append(Zone(storing, _summed(model, nodes, elements.stiffness, conducts)))
    return found


def _summed(
    model: HeatModel, nodes: Ints, integral: Callable[[elements.Metric, Array], Array], some: Array
) -> sparse.csr_matrix:
    """Return the matrix of elements with ``nodes`` (m, 10) by an ``integral`` of what they have ``some`` (m, q) of."""
    data = np.zeros(model.pattern.entries)
    chosen = np.flatnonzero(np.any(some != 0.0, axis=1))
    for chunk in (chosen[first : first + CHUNK] for first in range(0, len(chosen), CHUNK)):
        found = elements.metric(model.mesh.points[nodes[chunk]])
        model.pattern.scatter(nodes[chunk], integral(found, some[chunk]), data)
    matrix = model.pattern.matrix(data).copy()
    matrix.eliminate_zeros()
    return matrix


def on_basis(zones: Sequence[Zone], basis: Array) -> tuple[Array, Array, Array]:
    """Return capacity and conduction matrices of each zone on the basis, and its mean of each basis vector."""
    mass, stiffness, means = [], [], []
    for one in zones:
        mass.append(basis.T @ (one.storing @ basis))
        stiffness.append(basis.T @ (one.conducting @ basis))
        weight = one.storing @ np.ones(len(basis))
        means.append(weight @ basis / max(float(weight.sum()), 1e-300))
    return np.stack(mass), np.stack(stiffness), np.stack(means)


def changes(model: HeatModel, zones: int) -> Array:
    """Return the materials' tables as factors on what they are at 50 degC, one place where nothing changes,
    of each zone (2, parts * zones, k, 2)."""
    tables = [[m.specific_heat for m in model.materials], [m.conductivity for m in model.materials]]
    if all(table.is_constant for kind in tables for table in kind):
        return np.ones((2, len(model.materials) * zones, 1, 2))
    at = np.unique(np.concatenate([table.x for kind in tables for table in kind]))
    found = np.array([[np.column_stack([at, table(at) / table.at(50.0)]) for table in kind] for kind in tables])
    return np.repeat(found, zones, axis=1)
