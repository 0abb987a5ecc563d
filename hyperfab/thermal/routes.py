"""Whether heat can leave: a steady state needs a way out of every piece of the mold."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from hyperfab.thermal.model import HeatModel


def without_route(model: HeatModel) -> int | None:
    """Return a node of a piece that no film, radiation or held face lets heat out of; None where there is none."""
    n = model.size
    ambient = np.full(n, 20.0)
    touched = ~model.free
    for condition in model.conditions:
        if len(condition.nodes):
            loss = condition.tangent(0.0, ambient).sum(axis=(1, 2))
            leaks = condition.nodes[loss > 1e-12 * max(float(np.abs(loss).max()), 1e-300)]
            touched[leaks.ravel()] = True
    linked = model.pattern.matrix(model.tangent(0.0, ambient))
    linked.data = np.abs(linked.data)
    _, piece = connected_components(linked, directed=False)
    open_pieces = np.unique(piece[touched])
    closed = np.flatnonzero(~np.isin(piece, open_pieces))
    return int(closed[0]) if closed.size else None
