"""Strains at the nodes, more accurate than the elements' own: polynomials fitted to the places of nearby nodes.

Around each inner corner a cubic (P2; quadratic for P1) is fitted to the deformed places of the nodes of the elements
that meet there, and differentiated (polynomial-preserving recovery; Zhang and Naga, SIAM J. Sci. Comput. 26 (2005)
1192). On symmetry lines the mirrored nodes take part.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hyperfab.membrane.mesh import SheetMesh

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Weights of the corners' polynomials at the element's nodes: an own or adjacent corner counts, others stand in
#: where those lie on the rim and have no polynomial.
_NEAR, _FAR = 1.0, 1e-6
_BESIDE = np.array([[0], [1], [2], [0, 1], [1, 2], [2, 0]], dtype=object)


def recovered_strain(mesh: SheetMesh, places: Array) -> Array:
    """Return C11, C22, C12 (n, 3) of the right Cauchy–Green tensor at the nodes for places (n, 3) [mm]."""
    powers = [(i, j) for i in range(4) for j in range(4) if i + j <= mesh.order + 1]
    polynomials = _fit(mesh, places, powers)
    corner_size = mesh.node_size[: mesh.corners]
    inner = np.ones(mesh.corners, bool)
    inner[mesh.rim[mesh.rim < mesh.corners]] = False
    total = np.zeros((len(mesh.nodes), 3, 2))
    weight = np.full(len(mesh.nodes), 1e-12)
    total += 1e-12 * _averaged(mesh, places)
    for own in range(3):
        corner = mesh.elements[:, own]
        for local in range(mesh.elements.shape[1]):
            node = mesh.elements[:, local]
            share = np.where(inner[corner], _NEAR if own in _BESIDE[local] else _FAR, 0.0)
            offset = (mesh.nodes[node] - mesh.nodes[corner]) / corner_size[corner, None]
            slope = np.einsum("mpx,mpi->mxi", polynomials[corner], _slopes(offset, powers))
            np.add.at(total, node, (share / corner_size[corner])[:, None, None] * slope)
            np.add.at(weight, node, share)
    gradient = total / weight[:, None, None]
    strain = np.einsum("nxi,nxj->nij", gradient, gradient)
    return np.column_stack([strain[:, 0, 0], strain[:, 1, 1], strain[:, 0, 1]])


def _fit(mesh: SheetMesh, places: Array, powers: list[tuple[int, int]]) -> Array:
    """Return polynomials (corners, terms, 3) in (X - X_corner) / size of the places around each corner."""
    count = len(powers)
    normal = np.zeros((mesh.corners, count, count))
    right = np.zeros((mesh.corners, count, 3))
    on_line = [np.isin(np.arange(mesh.corners), line) for line in mesh.symmetric]
    for flip_x, flip_y in ((False, False), (True, False), (False, True), (True, True)):
        mirror = np.array([-1.0 if flip_x else 1.0, -1.0 if flip_y else 1.0])
        taking = np.ones(mesh.corners, bool)
        if flip_x:
            taking &= on_line[0]
        if flip_y:
            taking &= on_line[1]
        for own in range(3):
            mine = taking[mesh.elements[:, own]]
            corner, nodes = mesh.elements[mine, own], mesh.elements[mine]
            offset = mirror * mesh.nodes[nodes] - mesh.nodes[corner][:, None]
            terms = _terms(offset / mesh.node_size[corner][:, None, None], powers)
            seen = places[nodes] * np.append(mirror, 1.0)
            np.add.at(normal, corner, np.einsum("map,maq->mpq", terms, terms))
            np.add.at(right, corner, np.einsum("map,max->mpx", terms, seen))
    # The ridge decides only where a corner of the outline has too few nodes around it.
    normal[:, range(count), range(count)] += 1e-9
    return np.asarray(np.linalg.solve(normal, right), float)


def _terms(offset: Array, powers: list[tuple[int, int]]) -> Array:
    return np.stack([offset[..., 0] ** i * offset[..., 1] ** j for i, j in powers], axis=-1)


def _slopes(offset: Array, powers: list[tuple[int, int]]) -> Array:
    x, y = offset[..., 0], offset[..., 1]
    by_x = [i * x ** max(i - 1, 0) * y**j for i, j in powers]
    by_y = [j * x**i * y ** max(j - 1, 0) for i, j in powers]
    return np.stack([np.stack(by_x, axis=-1), np.stack(by_y, axis=-1)], axis=-1)


def _averaged(mesh: SheetMesh, places: Array) -> Array:
    """Return the elements' mean deformation gradients (n, 3, 2), averaged at the nodes."""
    mean = np.einsum("max,mqai,mq->mxi", places[mesh.elements], mesh.gradients, mesh.weights)
    mean /= mesh.weights.sum(axis=1)[:, None, None]
    total = np.zeros((len(mesh.nodes), 3, 2))
    np.add.at(total, mesh.elements.ravel(), np.repeat(mean, mesh.elements.shape[1], axis=0))
    return total / np.bincount(mesh.elements.ravel(), minlength=len(mesh.nodes))[:, None, None]
