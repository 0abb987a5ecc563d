"""How an unevenly hot mold deforms: linear thermoelasticity on ten-node tetrahedra.

The mold is free but for its mounting face. Young's modulus cancels; only Poisson's ratio is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from hyperfab.arrays import Array, Flags, Ints
from hyperfab.errors import NotConverged
from hyperfab.numerics.multilevel import Direct, Preconditioner, TwoLevel, conjugate_gradients
from hyperfab.pressing.tetra import EDGES, TetraMesh, boundary, samples

POISSON = 0.33
_BLOCK = 4000
#: Above this number of corner nodes the coarse problem gets a coarser one of its own.
_DIRECT_NODES = 6000
_AGGREGATES = 1200


@dataclass(frozen=True)
class Mounting:
    """The mounting face: its ``nodes``, whether it is held ``flat`` on its platen (free to slide), and the ``line``
    (2,) [mm], seen along the axis, from which it grows sideways."""

    nodes: Ints
    flat: bool
    line: Array


def mounting(mesh: TetraMesh, side: int, flat: bool, line: Array) -> Mounting:
    """Return the mounting of a mold: its outer nodes at the end turned away from the other mold (``side`` +1: low)."""
    outer = np.unique(boundary(mesh))
    height = side * mesh.points[outer, 2]
    span = float(np.ptp(mesh.points, axis=0).max())
    return Mounting(outer[height < height.min() + 1e-6 * span], flat, line)


def deform(mesh: TetraMesh, strain: Array, mount: Mounting, poisson: float = POISSON) -> Array:
    """Return the displacements (n, 3) [mm] under free thermal ``strain`` (n,) at the nodes, z the closing axis.

    Of several strains (k, n), which all meet one stiffness, (k, n, 3). A strain that is linear in space leaves a free
    body free of stress, and quadratic elements give that to rounding.
    Raises NotConverged where the equations are not solved, as on a mesh with torn elements.
    """
    matrix, loads = _assemble(mesh, np.atleast_2d(strain), poisson)
    held = _held(mesh, mount)
    free = np.ones(3 * len(mesh.points), dtype=bool)
    free[held] = False
    # Held unknowns: their rows become diagonal, so that the smoother has something to divide by.
    keep = sparse.diags_array(free.astype(float))
    hold = sparse.diags_array(np.where(free, 0.0, matrix.diagonal()))
    matrix = sparse.csr_matrix(keep @ matrix @ keep + hold)
    preconditioner = _preconditioner(mesh, matrix, free)
    moved = []
    for load in loads:
        if not load[free].any():
            moved.append(np.zeros((len(mesh.points), 3)))
            continue
        found = conjugate_gradients(matrix, load, preconditioner, free, tolerance=1e-10, iterations=400)
        if not found.residual < 1e-7:
            raise NotConverged(
                f"the deformation of the mold was not found: residual {found.residual:.1e}",
                remedy="mesh the mold again with another mesh_size",
            )
        moved.append(_seated(mesh, found.x.reshape(-1, 3), mount))
    return np.array(moved).reshape(*np.shape(strain), 3)


def _assemble(mesh: TetraMesh, strain: Array, poisson: float) -> tuple[sparse.csr_matrix, Array]:
    """Stiffness and thermal loads (k, 3 n) of strains (k, n) for a Young's modulus of one."""
    mu = 0.5 / (1.0 + poisson)
    lam = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    nodes, count = len(mesh.points), len(mesh.elements)
    pairs = (mesh.elements[:, :, None] * nodes + mesh.elements[:, None, :]).reshape(count, 100)
    keys, place = np.unique(pairs, return_inverse=True)
    data = np.zeros((len(keys), 3, 3))
    load = np.zeros((len(strain), nodes, 3))
    for start in range(0, count, _BLOCK):
        chosen = slice(start, start + _BLOCK)
        at = samples(mesh, chosen)
        size = len(at.volume)
        slope = at.slope.reshape(size, -1, 30)
        gram = (slope * at.volume[..., None]).transpose(0, 2, 1) @ slope
        gram = gram.reshape(size, 10, 3, 10, 3)
        block = lam * gram.transpose(0, 1, 3, 2, 4) + mu * gram.transpose(0, 1, 3, 4, 2)
        same = np.einsum("maibi->mab", gram)
        block += mu * same[..., None, None] * np.eye(3)
        flat = place[chosen].ravel()
        for i in range(3):
            for j in range(3):
                data[:, i, j] += np.bincount(flat, weights=block[..., i, j].ravel(), minlength=len(keys))
        for one, total in zip(strain, load, strict=True):
            thermal = (3.0 * lam + 2.0 * mu) * (one[mesh.elements[chosen]] @ at.value.T)
            force = np.einsum("mqai,mq->mai", at.slope, thermal * at.volume)
            for i in range(3):
                total[:, i] += np.bincount(
                    mesh.elements[chosen].ravel(), weights=force[..., i].ravel(), minlength=nodes
                )
    rows = np.searchsorted(keys // nodes, np.arange(nodes + 1))
    matrix = sparse.bsr_array((data, keys % nodes, rows), shape=(3 * nodes, 3 * nodes))
    return sparse.csr_matrix(matrix), load.reshape(len(strain), -1)


def _held(mesh: TetraMesh, mount: Mounting) -> Ints:
    """Unknowns that are held: the face's height, and as many more as a rigid body needs and no others."""
    dx, dy = np.abs(mesh.points[mount.nodes][:, :2] - mount.line).T
    middle = mount.nodes[np.argmin(dx + dy)]
    # Far along one axis and near along the other: never one node for both.
    aside, across = mount.nodes[np.argmax(dx - dy)], mount.nodes[np.argmax(dy - dx)]
    held = [3 * middle, 3 * middle + 1, 3 * aside + 1]
    if mount.flat:
        return np.unique(np.concatenate([held, 3 * mount.nodes + 2]))
    return np.unique([*held, 3 * middle + 2, 3 * aside + 2, 3 * across + 2])


def _seated(mesh: TetraMesh, moved: Array, mount: Mounting) -> Array:
    """Take out the rigid motion by which the mounting face as a whole has left its place.

    The face's displacements are fitted by a rigid motion and an even growth from the guides' line; the rigid part is
    taken out, of a face that is held flat only what moves it in its plane.
    """
    arm = mesh.points[mount.nodes] - np.array([*mount.line, 0.0])
    height = float(arm[:, 2].mean())
    arm[:, 2] = 0.0
    shown = moved[mount.nodes]
    ones, zero = np.ones(len(arm)), np.zeros(len(arm))
    x, y = arm[:, 0], arm[:, 1]
    modes = [(ones, zero, zero), (zero, ones, zero), (-y, x, zero)]
    if not mount.flat:
        modes += [(zero, zero, ones), (zero, zero, y), (zero, zero, -x)]
    columns = np.stack([np.concatenate(mode) for mode in [*modes, (x, y, zero)]], axis=1)
    share, *_ = np.linalg.lstsq(columns, shown.T.ravel(), rcond=None)
    shift, turn = np.zeros(3), np.zeros(3)
    shift[:2], turn[2] = share[:2], share[2]
    if not mount.flat:
        shift[2], turn[:2] = share[3], share[4:6]
    return moved - shift - np.cross(turn, mesh.points - np.array([*mount.line, height]))


def _preconditioner(mesh: TetraMesh, matrix: sparse.csr_matrix, free: Flags) -> Preconditioner:
    """Quadratic elements on linear ones on, for large meshes, rigid pieces."""
    corners = np.unique(mesh.elements[:, :4])
    number = np.full(len(mesh.points), -1)
    number[corners] = np.arange(len(corners))
    rows, columns, weights = [corners], [number[corners]], [np.ones(len(corners))]
    for k, (a, b) in enumerate(EDGES):
        middle, first = np.unique(mesh.elements[:, 4 + k], return_index=True)
        for end in (a, b):
            rows.append(middle)
            columns.append(number[mesh.elements[first, end]])
            weights.append(np.full(len(middle), 0.5))
    row, column = np.concatenate(rows), np.concatenate(columns)
    # A middle that several elements share is met several times: once is enough.
    _, once = np.unique(row * len(corners) + column, return_index=True)
    shape = (len(mesh.points), len(corners))
    linear = sparse.csr_matrix((np.concatenate(weights)[once], (row[once], column[once])), shape=shape)
    prolongation = _only_free(sparse.csr_matrix(sparse.kron(linear, sparse.eye(3), format="csr")), free)
    coarse = sparse.csr_matrix(prolongation.T @ matrix @ prolongation)
    used = coarse.diagonal() > 0.0
    if len(corners) <= _DIRECT_NODES:
        return TwoLevel(matrix, prolongation, Direct(coarse, used), free)
    pieces = _only_free(_rigid_pieces(mesh.points[corners]), used)
    coarsest = sparse.csr_matrix(pieces.T @ coarse @ pieces)
    keep = coarsest.diagonal() > 1e-9 * coarsest.diagonal().max()
    whole = sparse.csr_matrix(coarse + sparse.diags_array(np.where(used, 0.0, 1.0)))
    below = TwoLevel(whole, pieces, Direct(coarsest, keep), used, degree=4)
    return TwoLevel(matrix, prolongation, below, free)


def _rigid_pieces(points: Array) -> sparse.csr_matrix:
    """Prolongation from the six rigid motions of boxes of nodes to the nodes' displacements."""
    low, span = points.min(axis=0), np.ptp(points, axis=0)
    side = float(np.cbrt(np.prod(np.maximum(span, 1e-3 * span.max())) / _AGGREGATES))
    cell = np.floor((points - low) / side).astype(np.int64)
    _, piece = np.unique(cell, axis=0, return_inverse=True)
    piece = piece.reshape(-1)
    count = np.bincount(piece)
    centre = np.stack([np.bincount(piece, weights=points[:, k]) / count for k in range(3)], axis=1)
    arm = (points - centre[piece]) / side
    node = np.arange(len(points))
    rows, columns, values = [], [], []
    for k in range(3):
        axis = np.eye(3)[k]
        turn = np.cross(axis, arm)
        rows += [3 * node + k] + [3 * node + i for i in range(3)]
        columns += [6 * piece + k] + [6 * piece + 3 + k] * 3
        values += [np.ones(len(points))] + [turn[:, i] for i in range(3)]
    shape = (3 * len(points), 6 * len(count))
    return sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)


def _only_free(prolongation: sparse.csr_matrix, free: Flags) -> sparse.csr_matrix:
    return sparse.csr_matrix(sparse.diags_array(free.astype(float)) @ prolongation)
