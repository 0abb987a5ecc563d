"""A clamp that gives: the rim creeps inward with the tension of the sheet, on springs in the sheet's plane.

The rim's displacement is ``compliance`` times the membrane traction, the force per undeformed length of the rim
[N/mm]: an elastic foundation of stiffness 1/compliance along the rim, with the elements' own shape functions.
Compliance zero is the rigid clamp.
"""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Ints
from hyperfab.membrane.mesh import SheetMesh

#: Gauss's rule of three points on the unit interval: exact for the squares of the shape functions.
_AT = 0.5 + np.sqrt(0.15) * np.array([-1.0, 0.0, 1.0])
_WEIGHT = np.array([5.0, 8.0, 5.0]) / 18.0


class Clamp:
    """Springs along the rim of ``mesh`` that hold it at ``rest`` (n, 3) [mm], free in the plane alone.

    ``compliance`` [mm per N/mm] is above zero.
    """

    def __init__(self, mesh: SheetMesh, compliance: float, rest: Array) -> None:
        self.compliance = compliance
        self._rest = rest[:, :2]
        element, nodes, local = rim_edges(mesh)
        mass = _edge_mass(mesh.nodes[nodes]) / compliance
        self._nodes = nodes
        self._mass = mass
        self._block = mesh.slipping_pattern.block_of[
            element[:, None, None], local[:, :, None], local[:, None, :]
        ]

    def energy(self, places: Array) -> float:
        """Return the energy [N mm] of the springs of what is meshed."""
        slip = self._slip(places)
        return 0.5 * float(np.einsum("eax,eab,ebx->", slip, self._mass, slip))

    def add(self, places: Array, force: Array, blocks: Array) -> float:
        """Add the springs' nodal forces to ``force`` (n, 3) and stiffness to ``blocks``; return their energy."""
        pull = np.einsum("eab,ebx->eax", self._mass, self._slip(places))
        for axis in (0, 1):
            np.add.at(force[:, axis], self._nodes, pull[:, :, axis])
            np.add.at(blocks[:, axis, axis], self._block, self._mass)
        return self.energy(places)

    def _slip(self, places: Array) -> Array:
        return np.asarray(places[self._nodes, :2] - self._rest[self._nodes])


def rim_edges(mesh: SheetMesh) -> tuple[Ints, Ints, Ints]:
    """Return for each element edge on the rim its element (k,), nodes (k, 2 or 3), and their places in the element."""
    local = np.array([[0, 1, 3], [1, 2, 4], [2, 0, 5]])[:, : mesh.order + 1]
    nodes = mesh.elements[:, local]
    ends = np.sort(nodes[:, :, :2], axis=2).reshape(-1, 2)
    _, inverse, count = np.unique(
        ends[:, 0] * len(mesh.nodes) + ends[:, 1], return_inverse=True, return_counts=True
    )
    held = np.zeros(len(mesh.nodes), bool)
    held[mesh.rim] = True
    mine = held[nodes].all(axis=2) & (count[inverse].reshape(-1, 3) == 1)
    element, edge = np.nonzero(mine)
    return element, nodes[element, edge], local[edge]


def _edge_mass(places: Array) -> Array:
    """Return the integrals (k, a, a) [mm] of products of shape functions along edges through ``places`` (k, a, 2)."""
    t = _AT
    if places.shape[1] == 2:
        shapes, slopes = np.stack([1 - t, t]), np.stack([-np.ones(3), np.ones(3)])
    else:
        shapes = np.stack([(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)])
        slopes = np.stack([4 * t - 3, 4 * t - 1, 4 - 8 * t])
    length = np.linalg.norm(np.einsum("aq,kax->kqx", slopes, places), axis=2)
    return np.einsum("q,kq,aq,bq->kab", _WEIGHT, length, shapes, shapes)
