"""A first guess of the sheet's shape: a film under uniform tension, stretched over the punch."""

from __future__ import annotations

import numpy as np

from hyperfab.arrays import Array, Flags
from hyperfab.membrane.sheet import Sheet
from hyperfab.membrane.sphere import Punch
from hyperfab.numerics.blocks import BlockPattern

_MAX_ROUNDS = 40


def film_over(sheet: Sheet, punch: Punch, depth: float) -> tuple[Array, Flags]:
    """Return places (n, 3) and touching nodes (n,) of a film of uniform tension over the punch.

    The height w solves the Laplace equation with w >= punch: a linear obstacle problem, by the active-set method.
    """
    mesh = sheet.mesh
    places = sheet.flat
    floor = punch.height(places[:, :2], depth)
    free = np.ones((len(mesh.nodes), 1), bool)
    free[mesh.rim] = False
    pattern = BlockPattern(mesh.elements, len(mesh.nodes), free, mesh.nodes)
    local = np.einsum("mqai,mqbi,mq->mab", mesh.gradients, mesh.gradients, mesh.weights)
    blocks = np.zeros((pattern.blocks, 1, 1))
    np.add.at(blocks[:, 0, 0], pattern.block_of.ravel(), local.ravel())
    stiff = 1e8 * float(blocks[pattern.diagonal].max())
    touching = (floor > 0) & free[:, 0]
    height = np.zeros(len(mesh.nodes))
    for _ in range(_MAX_ROUNDS):
        held = blocks.copy()
        held[pattern.diagonal[touching]] += stiff
        right = np.where(touching, stiff * np.where(touching, floor, 0.0), 0.0)[:, None]
        height = pattern.extend(
            pattern.solver.factorise(pattern.matrix(held)).solve(pattern.restrict(right))
        )[:, 0]
        pressed = touching & (np.where(touching, floor, 0.0) > height)
        chosen = (pressed | (~touching & (height < floor))) & free[:, 0]
        if (chosen == touching).all():
            break
        touching = chosen
    places[:, 2] = height
    return places, touching
