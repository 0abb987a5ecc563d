"""Strains at the nodes, more accurate than the elements' own: polynomials fitted to the places of nearby nodes.

Around each inner corner a cubic (P2; quadratic for P1) is fitted to the deformed places of the nodes of the elements
that meet there, and differentiated (polynomial-preserving recovery; Zhang and Naga, SIAM J. Sci. Comput. 26 (2005)
1192). On symmetry lines the mirrored nodes take part.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.membrane.mesh import SheetMesh
from hyperfab.numerics.kernels import kernel

#: Weights of the corners' polynomials at the element's nodes: an own or adjacent corner counts, others stand in
#: where those lie on the rim and have no polynomial.
_FAR = 1e-6
_SHARES = np.array(
    [
        [1, _FAR, _FAR, 1, _FAR, 1],
        [_FAR, 1, _FAR, 1, 1, _FAR],
        [_FAR, _FAR, 1, _FAR, 1, 1],
    ]
)  # fmt: skip
_MIRRORS = np.array([[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])


def recovered_strain(mesh: SheetMesh, places: Array) -> Array:
    """Return C11, C22, C12 (n, 3) of the right Cauchy–Green tensor at the nodes for places (n, 3) [mm].

    The mesh keeps those of the last places: one equilibrium is asked for them several times.
    """
    if not (mesh.recovered and np.array_equal(mesh.recovered[0], places)):
        mesh.recovered[:] = [places.copy(), _recovered(mesh, places)]
    return mesh.recovered[1].copy()


def _recovered(mesh: SheetMesh, places: Array) -> Array:
    powers = np.array([(i, j) for i in range(4) for j in range(4) if i + j <= mesh.order + 1])
    corner_size = mesh.node_size[: mesh.corners]
    on_line = np.zeros((2, mesh.corners), bool)
    for axis, line in enumerate(mesh.symmetric):
        on_line[axis, line[line < mesh.corners]] = True
    normal, right = _sums(mesh.elements, mesh.nodes, places, corner_size, on_line, powers, _MIRRORS)
    # The ridge decides only where a corner of the outline has too few nodes around it.
    normal[:, range(len(powers)), range(len(powers))] += 1e-9
    polynomials = np.asarray(np.linalg.solve(normal, right), float)
    inner = np.ones(mesh.corners, bool)
    inner[mesh.rim[mesh.rim < mesh.corners]] = False
    return np.asarray(
        _strains(
            mesh.elements, mesh.nodes, corner_size, inner, polynomials, powers, _SHARES,
            1e-12 * _averaged(mesh, places),
        )
    )  # fmt: skip


@kernel
def _sums(
    elements: Ints,
    nodes: Array,
    places: Array,
    size: Array,
    on_line: Flags,
    powers: Ints,
    mirrors: Array,
) -> tuple[Array, Array]:
    """Return the normal equations (corners, terms, terms) and (corners, terms, 3) of the polynomials.

    They are in (X - X_corner) / size of the places around each corner.
    """
    count = len(powers)
    normal = np.zeros((len(size), count, count))
    right = np.zeros((len(size), count, 3))
    term = np.empty(count)
    seen = np.empty(3)
    for mirror in mirrors:
        for e in range(elements.shape[0]):
            for own in range(3):
                corner = elements[e, own]
                if (mirror[0] < 0 and not on_line[0, corner]) or (mirror[1] < 0 and not on_line[1, corner]):
                    continue
                for node in elements[e]:
                    x = (mirror[0] * nodes[node, 0] - nodes[corner, 0]) / size[corner]
                    y = (mirror[1] * nodes[node, 1] - nodes[corner, 1]) / size[corner]
                    seen[0], seen[1] = mirror[0] * places[node, 0], mirror[1] * places[node, 1]
                    seen[2] = places[node, 2]
                    for p in range(count):
                        term[p] = x ** powers[p, 0] * y ** powers[p, 1]
                    for p in range(count):
                        for q in range(count):
                            normal[corner, p, q] += term[p] * term[q]
                        for i in range(3):
                            right[corner, p, i] += term[p] * seen[i]
    return normal, right


@kernel
def _strains(
    elements: Ints,
    nodes: Array,
    size: Array,
    inner: Flags,
    polynomials: Array,
    powers: Ints,
    shares: Array,
    total: Array,
) -> Array:
    """Return the strains (n, 3) of the mean of the corners' slopes at each node; ``total`` (n, 3, 2) is kept low."""
    weight = np.full(len(nodes), 1e-12)
    for own in range(3):
        for e in range(elements.shape[0]):
            corner = elements[e, own]
            if not inner[corner]:
                continue
            for local in range(elements.shape[1]):
                node = elements[e, local]
                share = shares[own, local]
                x = (nodes[node, 0] - nodes[corner, 0]) / size[corner]
                y = (nodes[node, 1] - nodes[corner, 1]) / size[corner]
                for p in range(len(powers)):
                    i, j = powers[p]
                    by_x = i * x ** max(i - 1, 0) * y**j * share / size[corner]
                    by_y = j * x**i * y ** max(j - 1, 0) * share / size[corner]
                    for axis in range(3):
                        total[node, axis, 0] += polynomials[corner, p, axis] * by_x
                        total[node, axis, 1] += polynomials[corner, p, axis] * by_y
                weight[node] += share
    strain = np.zeros((len(nodes), 3))
    for node in range(len(nodes)):
        for axis in range(3):
            f1, f2 = total[node, axis, 0] / weight[node], total[node, axis, 1] / weight[node]
            strain[node, 0] += f1 * f1
            strain[node, 1] += f2 * f2
            strain[node, 2] += f1 * f2
    return strain


def _averaged(mesh: SheetMesh, places: Array) -> Array:
    """Return the elements' mean deformation gradients (n, 3, 2), averaged at the nodes."""
    weights = mesh.weights / mesh.weights.sum(axis=1)[:, None]
    gradients = (weights[:, None, :] @ mesh.gradients.reshape(*weights.shape, -1)).reshape(*mesh.elements.shape, 2)
    mean = np.swapaxes(places[mesh.elements], 1, 2) @ gradients
    at = mesh.elements.ravel()
    total = [
        np.bincount(at, np.repeat(mean[:, axis, slope], mesh.elements.shape[1]), len(mesh.nodes))
        for axis in range(3)
        for slope in range(2)
    ]
    return np.stack(total, axis=1).reshape(-1, 3, 2) / np.bincount(at, minlength=len(mesh.nodes))[:, None, None]
