"""Connected touching and open regions of the male surface."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hyperfab.arrays import Array, Ints
from hyperfab.pressing.clip import positive_part
from hyperfab.pressing.gap import Front
from hyperfab.pressing.press import Contact
from hyperfab.pressing.sandwich import Sandwich
from hyperfab.surface.topology import twin_edges


@dataclass(frozen=True)
class Region:
    """One connected region: ``area`` [mm^2], ``centroid`` (3,) [mm], mean ``gap`` [mm] and ``pressure`` [MPa] over
    its area, the ``load`` [N] it carries (pressure times area)."""

    contact: bool
    area: float
    centroid: Array
    gap: float
    pressure: float
    load: float


def regions(front: Front, touch_gap: Array, result: Contact, sandwich: Sandwich) -> list[Region]:
    """Return the touching regions and then the open ones, each kind by falling area.

    ``touch_gap`` (n,) [mm] decides what touches. Two faces belong together where the touching (open) part reaches
    across their common edge.
    """
    twins = twin_edges(front.of_mold[front.faces])[0]
    level = np.asarray(sandwich.thickness - touch_gap)
    return [
        region
        for touching, sign in ((True, 1.0), (False, -1.0))
        for region in _regions(front, twins, sign * level, touch_gap, result, sandwich, touching)
    ]


def _regions(
    front: Front,
    twins: Ints,
    level: Array,
    touch_gap: Array,
    result: Contact,
    sandwich: Sandwich,
    touching: bool,
) -> list[Region]:
    part = positive_part(level, front.faces, front.areas)
    count = len(front.faces)
    links = []
    for edge in range(3):
        across = level[front.faces[:, [edge, (edge + 1) % 3]]].max(axis=1) > 0.0
        joined = np.flatnonzero(across & (twins[:, edge] >= 0))
        links.append(np.stack([joined, twins[joined, edge]]))
    pair = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(pair.shape[1], dtype=np.int8), (pair[0], pair[1])), shape=(count, count))
    # At a crease each side tells for itself whether it reaches the edge.
    both = graph.tocsr().minimum(graph.tocsr().T)
    _, label = connected_components(both, directed=False)
    total = partial(replace(part, face=label[part.face]).per_face, count=count)
    there = sandwich.at(partial(part.at_corners, front.faces))
    place = part.at_corners(front.faces, front.vertices)
    area = total(np.ones(part.area.shape))
    gap = total(part.at_corners(front.faces, touch_gap))
    load = total(there.pressure(part.at_corners(front.faces, result.gap))) if touching else np.zeros(count)
    centroid = np.stack([total(place[..., axis]) for axis in range(3)], axis=1)
    found = [int(k) for k in np.argsort(-area, kind="stable") if area[k] > 0.0]
    return [
        Region(
            touching,
            float(area[k]),
            centroid[k] / area[k],
            float(gap[k] / area[k]),
            float(load[k] / area[k]),
            float(load[k]),
        )
        for k in found
    ]
