"""The sheet as finite elements: nodes, curved edges on the rim, shape-function gradients at the quadrature points."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from hyperfab.arrays import Array, Ints
from hyperfab.errors import InputError
from hyperfab.membrane.meshing import Triangles
from hyperfab.membrane.outline import Outline
from hyperfab.numerics.blocks import BlockPattern
from hyperfab.numerics.vectors import cross2
from hyperfab.surface.topology import sides

#: Dunavant's rules of degree 4 (six points) and 1, in area coordinates (Int. J. Numer. Meth. Engng 21 (1985) 1129).
_A, _B = 0.445948490915965, 0.091576213509771
_SIX = np.array(
    [
        [1 - 2 * _A, _A, _A], [_A, 1 - 2 * _A, _A], [_A, _A, 1 - 2 * _A],
        [1 - 2 * _B, _B, _B], [_B, 1 - 2 * _B, _B], [_B, _B, 1 - 2 * _B],
    ]
)  # fmt: skip
_SIX_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)


def quadrature(order: int) -> tuple[Array, Array]:
    """Return area coordinates (q, 3) and weights (q,), summing to one, for elements of ``order``."""
    if order == 1:
        return np.full((1, 3), 1 / 3), np.ones(1)
    return _SIX, _SIX_WEIGHTS / _SIX_WEIGHTS.sum()


@dataclass(frozen=True)
class SheetMesh:
    """A triangulated sheet of elements of ``order`` 1 or 2 (P1, P2).

    ``nodes`` (n, 2) [mm] in the undeformed plane, corners first; ``elements`` (m, 3) or (m, 6): corners, then the
    middles of edges 01, 12, 20. ``rim``: clamped nodes. ``symmetric``: for axis 0 and 1 the nodes on the symmetry
    line that must not move along this axis. ``gradients`` (m, q, a, 2) [1/mm] of the shape functions and
    ``weights`` (m, q) [mm²] at the quadrature points; ``copies``: how often the mesh makes up the whole sheet.
    """

    order: int
    nodes: Array
    elements: Ints
    corners: int
    rim: Ints
    symmetric: tuple[Ints, Ints]
    gradients: Array = field(repr=False)
    weights: Array = field(repr=False)
    copies: int
    #: Places of the nodes and the strains recovered from them, of the last time.
    recovered: list[Array] = field(default_factory=list, repr=False)

    @cached_property
    def pattern(self) -> BlockPattern:
        """The pattern of matrices on this mesh: three displacements a node, less clamped and symmetric ones."""
        return self._pattern(slips=False)

    @cached_property
    def slipping_pattern(self) -> BlockPattern:
        """The same where the clamp gives: the rim is held across the sheet's plane alone."""
        return self._pattern(slips=True)

    def _pattern(self, slips: bool) -> BlockPattern:
        free = np.ones((len(self.nodes), 3), bool)
        free[self.rim] = [slips, slips, False]
        for axis, line in enumerate(self.symmetric):
            free[line, axis] = False
        return BlockPattern(self.elements, len(self.nodes), free, self.nodes)

    @property
    def unknowns(self) -> int:
        """Displacements to be found."""
        return self.pattern.unknowns

    @cached_property
    def shapes(self) -> Array:
        """Values (q, a) of the shape functions at the quadrature points."""
        return shape_functions(self.order, quadrature(self.order)[0])

    @cached_property
    def places(self) -> Array:
        """Undeformed places (m, q, 2) [mm] of the quadrature points."""
        return np.einsum("qa,mai->mqi", self.shapes, self.nodes[self.elements])

    @cached_property
    def node_size(self) -> Array:
        """Mean edge length (n,) [mm] of the elements around each node."""
        area = self.weights.sum(axis=1)
        edge = np.sqrt(4.0 / np.sqrt(3.0) * area)
        count = np.bincount(self.elements.ravel(), minlength=len(self.nodes))
        total = np.bincount(self.elements.ravel(), np.repeat(edge, self.elements.shape[1]), minlength=len(self.nodes))
        return np.asarray(total / count)


def sheet_mesh(outline: Outline, triangles: Triangles, order: int = 2) -> SheetMesh:
    """Build the finite elements on a triangulated outline. Middles of edges on a curved rim lie on the rim."""
    if order not in (1, 2):
        raise ValueError("order is 1 or 2")
    nodes, elements = triangles.points, triangles.triangles
    arcs = np.asarray([-1 if arc.normal is None else arc.normal for arc in outline.arcs])
    edge_kind = arcs[triangles.edge_arc]
    edge_nodes = triangles.edges
    if order == 2:
        points, numbers, position = _middles(outline, triangles)
        elements = np.hstack([elements, numbers + len(nodes)])
        edge_nodes = np.column_stack([triangles.edges, position + len(nodes)])
        nodes = np.concatenate([nodes, points])
    rim = np.unique(edge_nodes[edge_kind == -1])
    lines = tuple(np.unique(edge_nodes[edge_kind == axis]) for axis in (0, 1))
    gradients, weights = _gradients(nodes, elements, order)
    copies = 4 if outline.quarter else 1
    return SheetMesh(
        order, nodes, elements, len(triangles.points), rim, (lines[0], lines[1]), gradients, weights, copies
    )


def halved(outline: Outline, coarse: Triangles) -> Triangles:
    """Return each triangle divided into four by halving its sides; halves of the boundary lie on the outline."""
    points, numbers, position = _middles(outline, coarse)
    a, b, c = coarse.triangles.T
    ab, bc, ca = (numbers + len(coarse.points)).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    middle = position + len(coarse.points)
    start, end = coarse.edges.T
    return Triangles(
        np.concatenate([coarse.points, points]),
        np.column_stack([corner for part in parts for corner in part]).reshape(-1, 3),
        np.column_stack([start, middle, middle, end]).reshape(-1, 2),
        np.repeat(coarse.edge_arc, 2),
    )


def shape_functions(order: int, area: Array) -> Array:
    """Return the values (q, a) of the shape functions at area coordinates (q, 3)."""
    if order == 1:
        return area.copy()
    vertex = area * (2 * area - 1)
    middle = 4 * area * np.roll(area, -1, axis=1)
    return np.hstack([vertex, middle])


def interpolate(mesh: SheetMesh, values: Array, points: Array) -> Array:
    """Return nodal ``values`` (n, k) interpolated at undeformed ``points`` (p, 2) inside or just outside the mesh."""
    corners = mesh.nodes[mesh.elements[:, :3]]
    centres = cKDTree(corners.mean(axis=1))
    element, area = _containing(corners, centres, points, 4)
    # On graded meshes the element around a point may be further off.
    astray = np.flatnonzero(area.min(axis=1) < 0.0)
    if len(astray):
        element[astray], area[astray] = _containing(corners, centres, points[astray], 16)
    return np.einsum("pa,pak->pk", shape_functions(mesh.order, area), values[mesh.elements[element]])


def _containing(corners: Array, centres: cKDTree, points: Array, count: int) -> tuple[Ints, Array]:
    """Return which of the ``count`` nearest elements holds each point best, and its area coordinates (p, 3) there."""
    _, near = centres.query(points, k=min(count, len(corners)))
    near = near.reshape(len(points), -1)
    a, b, c = (corners[near, i] for i in range(3))
    p = points[:, None, :]
    area = np.stack([cross2(b - p, c - p), cross2(c - p, a - p), cross2(a - p, b - p)], axis=-1)
    area /= cross2(b - a, c - a)[..., None]
    best = np.argmax(area.min(axis=-1), axis=1)
    row = np.arange(len(points))
    return near[row, best], area[row, best]


def _middles(outline: Outline, triangles: Triangles) -> tuple[Array, Ints, Ints]:
    """Return the middles (k, 2) of all edges, those of boundary edges on their arcs; which are of the three edges of
    each triangle (m, 3), and which of each boundary edge."""
    count = len(triangles.points)
    ends, numbers = sides(triangles.triangles, count)
    points = 0.5 * (triangles.points[ends[:, 0]] + triangles.points[ends[:, 1]])
    place = np.array([count, 1])
    position = np.searchsorted(ends @ place, np.sort(triangles.edges, axis=1) @ place)
    for number, arc in enumerate(outline.arcs):
        mine = triangles.edge_arc == number
        points[position[mine]] = arc.between(triangles.points[triangles.edges[mine]])
    return points, numbers, position


def _gradients(nodes: Array, elements: Ints, order: int) -> tuple[Array, Array]:
    area, weight = quadrature(order)
    if order == 1:
        local = np.array([[[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]])
    else:
        local = np.stack([_p2_slopes(point) for point in area])
    jacobian = np.swapaxes(nodes[elements], 1, 2)[:, None] @ local
    double = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
    if np.any(double <= 0):
        raise InputError(
            "an element is folded: the mesh is too coarse for its rim", remedy="choose a smaller --mesh-size"
        )
    turned = np.stack([jacobian[..., 1, 1], -jacobian[..., 0, 1], -jacobian[..., 1, 0], jacobian[..., 0, 0]], axis=-1)
    inverse = (turned / double[..., None]).reshape(jacobian.shape)
    return local @ inverse, 0.5 * double * weight


def _p2_slopes(point: Array) -> Array:
    """Derivatives (6, 2) of the P2 shape functions with respect to the second and third area coordinate."""
    a, b, c = point
    by_area = np.array(
        [
            [4 * a - 1, 0, 0], [0, 4 * b - 1, 0], [0, 0, 4 * c - 1],
            [4 * b, 4 * a, 0], [0, 4 * c, 4 * b], [4 * c, 0, 4 * a],
        ]
    )  # fmt: skip
    return np.column_stack([by_area[:, 1] - by_area[:, 0], by_area[:, 2] - by_area[:, 0]])
