"""Nodes moved against a mold, one by one: where each must come to rest is known without a computation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
import trimesh

from hyperfab.cloth.contact import Laid, move
from hyperfab.cloth.mold import FREE, ON_FACE, Mold, mold_of
from hyperfab.cloth.state import State
from hyperfab.surface import Surface

HALF = 10.0


def box() -> Mold:
    mesh = trimesh.creation.box((2.0 * HALF,) * 3)
    return mold_of(Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)))


class Node(NamedTuple):
    at: np.ndarray
    state: int
    slot: int
    clear: float


def moved(mold: Mold, start: Node, step: tuple[float, float, float]) -> Node:
    """Return a single node after a step."""
    one = (1, 1)
    place, onto = np.asarray(start.at, float).reshape(1, 1, 3), np.empty((1, 1, 3))
    states, slots, clears = np.empty(one, np.int8), np.empty(one, np.int64), np.empty(one)
    crossed = np.zeros(one, np.int8)
    now = State(
        place,
        np.full(one, start.state, np.int8),
        np.full(one, start.slot),
        np.full(one, start.clear),
        crossed,
    )
    flat = Laid(np.empty((0, 4), np.int64), np.empty((0, 13)), np.zeros((1, 1, 2), np.int64))
    out = State(onto, states, slots, clears, crossed.copy())
    move(now, np.asarray(step, float).reshape(1, 1, 3), 1.0, mold, out, flat, 0, 1)
    return Node(onto[0, 0], int(states[0, 0]), int(slots[0, 0]), float(clears[0, 0]))


def free(*at: float) -> Node:
    return Node(np.array(at), FREE, 0, 0.0)


def test_a_node_that_stays_outside_goes_where_it_is_sent_and_knows_how_far_the_mold_is() -> None:
    found = moved(box(), free(1.0, 2.0, HALF + 3.0), (0.5, -1.0, -1.0))
    assert found.at == pytest.approx([1.5, 1.0, HALF + 2.0], abs=1e-12)
    assert (found.state, found.clear) == (FREE, pytest.approx(2.0, abs=1e-12))


def test_a_node_whose_ball_holds_no_mold_is_not_looked_for() -> None:
    """It goes by what it was told, the step off: the distance is a bound, and needs no search."""
    found = moved(box(), Node(np.array([0.0, 0.0, HALF + 3.0]), FREE, 0, 2.5), (0.0, 0.0, -1.0))
    assert found.clear == pytest.approx(1.5, abs=1e-12)


def test_a_short_step_into_the_mold_ends_at_the_nearest_point_of_its_surface() -> None:
    found = moved(box(), free(1.0, 2.0, HALF + 1e-3), (1e-3, 0.0, -3e-3))
    assert found.at == pytest.approx([1.001, 2.0, HALF], abs=1e-12)
    assert found.state == ON_FACE


@pytest.mark.parametrize("deep", [3.0, 40.0])
def test_a_long_step_ends_where_it_meets_the_mold_though_it_leads_through(deep: float) -> None:
    found = moved(box(), free(1.0, 2.0, HALF + 1.0), (0.0, 0.0, -deep))
    assert found.at == pytest.approx([1.0, 2.0, HALF], abs=1e-9)
    assert found.state == ON_FACE


def test_a_node_on_a_facet_keeps_to_it_whatever_the_step_has_across() -> None:
    mold = box()
    down = moved(mold, free(1.0, 2.0, HALF + 1e-3), (0.0, 0.0, -2e-3))
    found = moved(mold, down, (0.3, -0.2, -0.5))
    assert found.at == pytest.approx([1.3, 1.8, HALF], abs=1e-12)
    assert found.state == ON_FACE


def test_a_node_that_does_not_move_is_left_as_it_is() -> None:
    mold = box()
    down = moved(mold, free(1.0, 2.0, HALF + 1e-3), (0.0, 0.0, -2e-3))
    found = moved(mold, down, (0.0, 0.0, 0.0))
    assert np.array_equal(found.at, down.at)
    assert found[1:] == down[1:]
