"""The work of the punch on curves whose integral is known."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.membrane.work import doubtful, work


def _trace(force, depths):
    return [(float(depth), float(force(depth))) for depth in depths]


def test_a_polynomial_is_integrated_exactly():
    assert work(_trace(lambda s: s**3 - 0.01 * s**5, np.arange(1.0, 9.0))) == pytest.approx(
        8.0**4 / 4 - 0.01 * 8.0**6 / 6, rel=1e-12
    )


def test_a_vertical_slope_at_the_turning_point_costs_nothing():
    """F = 10 - sqrt(60.35 - s) + a constant that takes the force at zero away."""
    start = 60.35**0.5
    trace = _trace(lambda s: start - (60.35 - s) ** 0.5, [7.5, 15, 22.5, 30, 37.5, 45, 52.5, 60, 60.34])
    exact = start * 60.34 - 2 / 3 * (60.35**1.5 - 0.01**1.5)
    assert work(trace, 60.35) == pytest.approx(exact, rel=1e-9)
    assert abs(work(trace) / exact - 1.0) > 1e-5
    assert doubtful(trace, 1e-6, 60.35) == []


def test_a_kink_is_found_and_closed_in_on():
    """Slack up to 31.3 mm, then a force that rises with a slope, and bends."""
    kink = 31.3

    def force(depth):
        way = max(depth - kink, 0.0)
        return 0.9 * way + 0.01 * way**2

    trace = _trace(force, np.linspace(7.5, 60.0, 8))
    exact = 0.45 * (60 - kink) ** 2 + 0.01 / 3 * (60 - kink) ** 3
    assert abs(work(trace) / exact - 1.0) > 2e-5
    more = 0
    while depths := doubtful(trace, 3e-5, most=2):
        trace = sorted([*trace, *((depth, force(depth)) for depth in depths)])
        more += len(depths)
        assert more < 8
    assert work(trace) == pytest.approx(exact, rel=3e-5)


def test_smooth_curves_need_no_more_points():
    assert doubtful(_trace(lambda s: s**3, np.linspace(7.5, 60.0, 8)), 3e-5) == []


def test_few_points_are_not_believed():
    """One step, two or three: more points are asked for until the integral of a smooth curve is right."""
    for count in (1, 2, 3, 4):
        trace = _trace(lambda s: s**3 - 0.01 * s**4, np.linspace(60.0 / count, 60.0, count) / 10.0)
        more = 0
        while depths := doubtful(trace, 3e-5):
            trace = sorted([*trace, *((depth, depth**3 - 0.01 * depth**4) for depth in depths)])
            more += len(depths)
            assert more <= 6
        assert work(trace) == pytest.approx(6.0**4 / 4 - 0.01 * 6.0**5 / 5, rel=3e-5)


def test_a_sheet_that_is_never_touched_does_no_work():
    assert work([(10.0, 0.0), (20.0, 0.0)]) == 0.0
    assert doubtful([(10.0, 0.0), (20.0, 0.0)], 1e-5) == []


def test_where_a_slack_sheet_begins_to_bear_is_not_sought_where_it_is_known():
    """Nothing up to 1.3 and the square of the way beyond: five points tell all of it once the kink is known."""
    trace = [(float(s), max(s - 1.3, 0.0) ** 2) for s in range(1, 7)]
    assert doubtful(trace, 1e-6, taut=1.3) == []
    assert work(trace, taut=1.3) == pytest.approx(4.7**3 / 3.0, rel=1e-12)
    assert doubtful(trace, 1e-6)
