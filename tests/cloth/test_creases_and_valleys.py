"""Which spring is bent at which node, and when a node in a valley of the mold stays there: known without a net."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

from hyperfab.cloth.creases import hinge_nodes
from hyperfab.cloth.features import valley
from hyperfab.cloth.mold import mold_of
from hyperfab.cloth.pinning import hinges_to
from hyperfab.surface import Surface


@njit
def in_valley(mold, x, r, slot, before):
    return valley(mold, x, r, slot, before, np.empty(3), np.empty(3))


@njit
def bent_to(hinge, bent, i, j, side):
    return hinges_to(hinge, bent, side)


def test_a_bent_spring_is_known_from_both_of_its_ends_and_from_no_other_side() -> None:
    # A warp spring from (1, 1) to (2, 1), a weft spring from (1, 1) to (1, 2); sides: 0, 1 warp on, back; 2, 3 weft.
    bent = np.array([[1, 1, 0, 0], [1, 1, 1, 0]])
    hinges = np.zeros((4, 4, 2), np.int64)
    hinge_nodes(bent, hinges)
    for node, sides in (((1, 1), [0, 2]), ((2, 1), [1]), ((1, 2), [3]), ((2, 2), [])):
        found = [s for s in range(4) for h in hinges[node] if bent_to(h, bent, *node, s)]
        assert found == sides, node


@pytest.mark.parametrize("seed", range(12))
def test_a_node_stays_in_a_valley_where_the_force_pushes_to_it_from_both_sides(seed: int) -> None:
    """Two facets that rise from an edge, turned any way in space; the force any way, too."""
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    slope = random.uniform(0.2, 2.0, 2)
    # The edge along y; one facet rises to -x, the other to +x.
    points = np.array([[0.0, 0.0, 0.0], [0.0, 5.0, 0.0], [-4.0, 2.0, 4.0 * slope[0]], [4.0, 3.0, 4.0 * slope[1]]])
    mold = mold_of(Surface(points @ turn.T, np.array([[0, 1, 2], [1, 0, 3]])))
    left = next(s for s in range(2) if 2 in mold.vertex[s])
    to_edge = [
        np.array([1.0, 0.0, -slope[0]]),
        np.array([-1.0, 0.0, -slope[1]]),
    ]  # down each facet, square to the edge
    both = []
    for _ in range(40):
        force, place = random.normal(size=3), np.array([0.0, random.uniform(0.5, 4.5), 0.0])
        pushed = [float(force @ way) > 0.0 for way in to_edge]
        # A node that came over from the left facet stands on the right one, a little beside the edge, and the reverse.
        for slot, before, beside in ((1 - left, left, to_edge[1]), (left, 1 - left, to_edge[0])):
            x = turn @ (place - 0.01 * beside)
            edge = in_valley(mold, x, turn @ force, slot, before)
            assert (edge >= 0) == all(pushed)
            if edge >= 0:
                assert mold.twins[slot, edge] == before
                np.testing.assert_allclose(turn.T @ x, place, atol=1e-12)
        both.append(all(pushed))
    assert set(both) == {True, False}
