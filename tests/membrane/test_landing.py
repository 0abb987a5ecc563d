"""Where nodes land on the punch between two load steps, and how far ahead a turning point is expected."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hyperfab.membrane.contact import Memory, landings
from hyperfab.membrane.path import _turning_ahead
from hyperfab.membrane.punch import Sphere


def test_what_has_not_touched_yet_lands_on_the_punch():
    """Nodes above a sphere that come down by a millimetre each millimetre of depth, and a little aside."""
    sphere = Sphere(40.0)
    x = np.array([0.0, 3.0, 6.0])
    places = np.column_stack([x, 0.0 * x, np.full(3, 0.8)])
    near = sphere.near(places, 0.0)
    drift = np.tile([0.1, 0.0, -1.0], (3, 1))
    memory = Memory(
        10.0,
        places,
        near.gap,
        near.normal,
        np.zeros(3, bool),
        0 * places,
        0 * places,
        np.zeros(3, bool),
        drift=drift,
    )
    found = landings(memory, sphere, 12.0)
    assert np.abs(sphere.near(found, 0.0).gap).max() < 1e-9
    assert found[0, 0] > 0.0  # carried along by what drifts
    assert np.abs(found - places).max() < 5.0


def test_a_turning_point_is_expected_where_the_speed_would_be_without_bounds():
    """The speed grows as one over the root of the depth that is left: from 50 and 55 mm, 5 mm before 60."""
    footings = [
        SimpleNamespace(state=SimpleNamespace(depth=depth), speed=2.0 / np.sqrt(60.0 - depth)) for depth in (50.0, 55.0)
    ]
    assert _turning_ahead(footings) == pytest.approx(5.0, rel=1e-12)
    assert _turning_ahead(footings[:1]) is None
    assert _turning_ahead(footings[::-1]) is None
