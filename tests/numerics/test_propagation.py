"""Sampling of what is uncertain, against what is known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.numerics.propagation import Source, draws, linear, sampled


@pytest.mark.parametrize("count", [60, 200, 1000])
def test_what_goes_straight_with_its_sources_has_its_exact_deviation_and_no_share_together(
    count: int,
) -> None:
    """Draws that are not independent of each other would make up a joint effect, and a deviation by chance."""
    sources = [Source("a", np.diag([1.0, 4.0])), Source("b", np.array([[9.0]])), Source("c", np.eye(3))]
    slopes = np.array([2.0, -1.0, 0.5, 1.0, 3.0, -2.0])
    drawn = draws(sources, count)
    np.testing.assert_allclose(np.cov(drawn, rowvar=False), np.eye(6), atol=1e-12)
    band = sampled(7.0, 7.0 + drawn @ slopes, drawn, sources)
    assert band.sd == pytest.approx(np.linalg.norm(slopes), rel=1e-12)
    assert "together" not in dict(band.budget)
    assert sum(share for _, share in band.budget) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("bend", [0.0, 0.01, 0.02, 0.03, 0.3])
def test_shares_make_up_the_whole(bend: float) -> None:
    sources = [Source("a", np.eye(1)), Source("b", np.eye(1))]
    drawn = draws(sources, 400)
    outcomes = drawn @ [1.0, 0.5] + bend * drawn[:, 0] * drawn[:, 1]
    budget = sampled(0.0, outcomes, drawn, sources).budget
    assert sum(share for _, share in budget) == pytest.approx(1.0, abs=1e-12)


def test_what_hangs_on_one_part_has_that_parts_degrees_of_freedom() -> None:
    """Two numbers, the sum and the difference of two known by three specimens each: their sum is twice the one."""
    one, other = np.array([[1.0, 1.0], [1.0, 1.0]]), np.array([[1.0, -1.0], [-1.0, 1.0]])
    source = Source("constants", one + other, 4.0, ((one, 2.0), (other, 2.0)))
    for slope, sd, wide in (
        (np.array([1.0, 1.0]), 2.0, 4.302653),
        (np.array([1.0, 0.0]), 2.0**0.5, 2.776445),
    ):
        band = linear(0.0, source.root.T @ slope, [source])
        assert band.sd == pytest.approx(sd, rel=1e-12)
        assert band.high == pytest.approx(wide * sd, rel=1e-6)
        assert band.budget == (("constants", pytest.approx(1.0)),)
